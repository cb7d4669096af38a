"""Mutations: whether a test notices that a line of mechanics is wrong.

    python tools/mutations.py --count 100 --out mutations.json
    python tools/mutations.py --table mutations.json        # the table of tests/README.md

Each mutation changes one operator, comparison, sign, ½ or choice between least and greatest, in a copy of
the project. Of the tests of its room, those run that come to the changed line, the quickest first, until one
fails; which they are is asked once a file of tests (`touched.py`). What no room noticed is asked of the tests
of validation. Tests run in forks of this process, which has loaded the libraries. A seed chooses the places,
as many in each file as any.

A run goes on where one ended, with the copy made then, in a folder named as the file of outcomes; tests are
those of now, and what was not noticed is asked again, but where the file of outcomes has a reason, "why".
"""

from __future__ import annotations

import argparse
import ast
import importlib.util
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import pytest
from touched import Touched

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "masonry_fem"
LONGEST = 60  # seconds of CPU in which a file of tests is asked for its lines; tests beyond them are left out

# files in which a wrong sign is wrong mechanics, and the tests that are to see it first
ROOMS = {
    ("march/step", "march/rounds", "march/conditions", "march/coupling", "march/place", "march/loads",
     "march/motion"):
        ("tests/march", "tests/validation/test_a1_single_block.py", "tests/validation/test_a1_6_rocking.py"),
    ("march/energy", "march/acting", "march/measure"): ("tests/march", "tests/test_certificate_page.py"),
    ("bodies/rigid", "bodies/rotation", "bodies/motions", "bodies/inertia", "bodies/support"):
        ("tests/bodies", "tests/march"),
    ("nscd/local", "nscd/graphs", "nscd/contact_measures", "nscd/transfer", "nscd/problem", "nscd/residuals",
     "nscd/scaling"): ("tests/nscd",),
    ("contact/contacts", "contact/clipping", "contact/placement/corners", "contact/placement/nodes",
     "contact/placement/parts/quadrature", "contact/interpolation"): ("tests/contact",),
    ("fem/condense", "fem/stress", "fem/assemble", "fem/material", "fem/traction"): ("tests/fem",),
    ("joints/reduction", "joints/laws/fremond_cangemi", "joints/laws/mohr_coulomb", "joints/laws/parts/bed",
     "joints/laws/parts/rigid_brittle", "joints/laws/parts/rough", "joints/laws/parts/softening"): (
         "tests/joints",),
    ("limit/problem", "limit/program", "limit/strength"): ("tests/limit",),
    ("solid/polytope", "solid/pose"): ("tests/solid", "tests/contact"),
}  # fmt: skip
BROKEN = 99  # exit status of a fork in which asking itself failed
OPTIONS = ("-q", "-p", "no:cacheprovider", "-m", "not slow")
# what most tests load; libraries with threads or MPI are left to those who need them
LIBRARIES = ("numba", "scipy.optimize", "scipy.sparse.linalg", "scipy.spatial", "msgspec", "meshio")
LAST = ("tests/validation",)  # asked where the tests of the room saw nothing

SWAPPED = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
TURNED = {ast.Lt: ">", ast.LtE: ">", ast.Gt: "<", ast.GtE: "<"}
OTHER = {"maximum": "minimum", "minimum": "maximum", "max": "min", "min": "max"}


@dataclass(frozen=True)
class Mutation:
    """A change of one place: the text between two offsets of a file's line, and what takes its place."""

    file: str
    line: int
    start: int
    end: int
    old: str
    new: str
    code: str


def main(arguments: list[str] | None = None) -> int:
    """Make mutations and run the tests on each; or print the table of a run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100, help="mutations in all (100)")
    parser.add_argument("--seed", type=int, default=0, help="which ones (0)")
    parser.add_argument(
        "--room", default="", help="only those of such a folder of the package, and its tests (all)"
    )
    parser.add_argument("--out", type=Path, default=Path("mutations.json"), help="where they are told")
    parser.add_argument("--table", type=Path, help="print the table of such a file, and end")
    chosen = parser.parse_args(arguments)
    if chosen.table:
        print(table(json.loads(chosen.table.read_text())))
        return 0
    told = json.loads(chosen.out.read_text()) if chosen.out.exists() else []
    tests = Tests(chosen.out.with_suffix("").resolve())
    for last in (False,) if chosen.room else (False, True):
        for number, one in enumerate(sample(chosen.count, chosen.seed, tests.copy), 1):
            entry = next((entry for entry in told if entry.items() >= asdict(one).items()), asdict(one))
            if (
                entry.get("noticed")
                or entry.get("why")
                or not one.file.startswith(f"{PACKAGE}/{chosen.room}")
            ):
                continue
            if entry not in told:
                told.append(entry)
            entry["noticed"] = tests.noticed(one, LAST if last else _near(one))
            chosen.out.write_text(json.dumps(told, indent=1) + "\n")
            change = f"{one.file}:{one.line} {one.old} -> {one.new}"
            print(f"{number:4d} {change}: {entry['noticed'] or 'NOT NOTICED'}", flush=True)
    return 0


def sample(count: int, seed: int, root: Path = ROOT) -> list[Mutation]:
    """So many mutations, spread evenly over the files."""
    generator = random.Random(seed)
    piles = []
    for files in ROOMS:
        for file in files:
            places = list(mutations(f"{PACKAGE}/{file}.py", root))
            generator.shuffle(places)
            piles.append(places)
    chosen: list[Mutation] = []
    while len(chosen) < count and any(piles):
        for pile in piles:
            if pile and len(chosen) < count:
                chosen.append(pile.pop())
    return chosen


def mutations(file: str, root: Path = ROOT) -> Iterator[Mutation]:
    """All that can be changed in a file, but in its messages and types."""
    text = (root / file).read_text()
    lines = text.splitlines()
    for node in _mechanics(ast.parse(text)):
        for line, start, end, new in _changes(node, lines):
            old = lines[line - 1].encode()[start:end].decode()
            yield Mutation(file, line, start, end, old, new, lines[line - 1].strip())


def _mechanics(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes of the tree in its order, without what is said to people or to the type checker."""
    for name, field in ast.iter_fields(node):
        if name in {"annotation", "returns", "decorator_list", "slice"}:
            continue
        for child in field if isinstance(field, list) else [field]:
            if isinstance(child, ast.AST) and not _is_talk(child):
                yield child
                yield from _mechanics(child)


def _is_talk(node: ast.AST) -> bool:
    """Whether it raises, checks, logs or formats."""
    if isinstance(node, ast.If):
        return any(isinstance(inside, ast.Raise) for inside in ast.walk(node))
    return isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr | ast.Import | ast.ImportFrom)


def _changes(node: ast.AST, lines: list[str]) -> Iterator[tuple[int, int, int, str]]:
    """Line, offsets in bytes and new text of what can be changed at a node itself."""
    if isinstance(node, ast.BinOp) and type(node.op) in SWAPPED:
        yield from _between(node.left, node.right, lines, SWAPPED[type(node.op)])
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in TURNED:
        yield from _between(node.left, node.comparators[0], lines, TURNED[type(node.ops[0])])
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        if not isinstance(node.operand, ast.Constant):
            yield node.lineno, node.col_offset, node.col_offset + 1, "+"
    elif isinstance(node, ast.Constant) and node.value == 0.5:
        yield node.lineno, node.col_offset, node.end_col_offset or 0, "1.0"
    elif isinstance(node, ast.Call):
        called = node.func
        name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
        if name in OTHER and called.end_col_offset is not None and called.end_lineno is not None:
            end = called.end_col_offset
            yield called.end_lineno, end - len(name), end, OTHER[name]


def _between(
    left: ast.expr, right: ast.expr, lines: list[str], new: str
) -> Iterator[tuple[int, int, int, str]]:
    """The operator between two operands of one line."""
    if left.end_lineno != right.lineno or left.end_col_offset is None:
        return
    gap = lines[right.lineno - 1].encode()[left.end_col_offset : right.col_offset].decode()
    sign = gap.strip("() ")
    if sign in {"+", "-", "*", "/", "<", "<=", ">", ">="}:
        start = left.end_col_offset + len(gap[: gap.index(sign)].encode())
        yield right.lineno, start, start + len(sign), new


def _near(one: Mutation) -> tuple[str, ...]:
    """Where the tests of its room are."""
    stem = one.file.removeprefix(f"{PACKAGE}/").removesuffix(".py")
    return next(folders for files, folders in ROOMS.items() if stem in files)


class Tests:
    """The tests of a copy of the project: how long each takes, and to which lines it comes.

    Parameters
    ----------
    memory : Path
        A folder that keeps the copy and what is known of its tests from one run to the next.
    """

    def __init__(self, memory: Path) -> None:
        self.memory = memory
        self.copy = memory / "project"
        if not self.copy.exists():
            _copy(self.copy, "")
        _copy(self.copy, "tests")
        for library in LIBRARIES:  # for all forks
            importlib.import_module(library)

    def noticed(self, one: Mutation, folders: tuple[str, ...]) -> str:
        """The test that fails with the mutation, "too long", or "" where all pass."""
        path = self.copy / one.file
        original, times = path.read_text(), path.stat()
        lines = original.splitlines(keepends=True)
        line = lines[one.line - 1].encode()
        lines[one.line - 1] = (line[: one.start] + one.new.encode() + line[one.end :]).decode()
        files = self._files(one, folders)
        plain = "@compiled" in original
        own = [file for file in files if Path(file).stem == f"test_{Path(one.file).stem}"]
        kept = [file for file in files if file not in own and self._fresh(file, plain)]
        for group in [own, kept, *([file] for file in files if file not in own + kept)]:
            seconds, chosen = self._touching(one, original, group)
            if not chosen:
                continue
            _write(path, "".join(lines))
            try:
                failing = self._failing(chosen, 20 + 5 * seconds, plain)
            finally:
                _write(path, original)
                os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # what Numba compiled of it is good
            if failing:
                return failing
        return ""

    def _files(self, one: Mutation, folders: tuple[str, ...]) -> list[str]:
        """Files of tests, the shortest first."""
        places = [self.copy / folder for folder in folders]
        found = {
            path for place in places for path in (place.rglob("test_*.py") if place.is_dir() else [place])
        }
        return [
            str(path.relative_to(self.copy)) for path in sorted(found, key=lambda path: path.stat().st_size)
        ]

    def _touching(self, one: Mutation, text: str, files: list[str]) -> tuple[float, list[str]]:
        """Those of files of tests that come to the statement, the quickest first, and their seconds.

        A statement that runs on import counts for all.
        """
        within = _statement(text, one.line)
        file = one.file.removeprefix(f"{PACKAGE}/")
        chosen = sorted(
            (seconds, name)
            for tests in files
            for name, (seconds, lines) in self._known(tests, plain="@compiled" in text).items()
            if within is None or within & set(lines.get(file, ()))
        )
        return sum(seconds for seconds, _ in chosen), [name for _, name in chosen]

    def _known(self, tests: str, plain: bool) -> dict[str, tuple[float, dict[str, list[int]]]]:
        """Seconds and lines of each test of a file that passes and is not marked slow."""
        kept = self._kept(tests, plain)
        if not self._fresh(tests, plain):
            kept.unlink(missing_ok=True)
            self._run(lambda: self._ask(tests, kept), LONGEST, plain)
            if not kept.exists():
                raise SystemExit(
                    f"{tests} did not run without a mutation:\n{(self.memory / 'said').read_text()}"
                )
        known: dict[str, tuple[float, dict[str, list[int]]]] = json.loads(kept.read_text())
        return known

    def _kept(self, tests: str, plain: bool) -> Path:
        return self.memory / f"{tests.replace('/', '.')}{'.plain' if plain else ''}.json"

    def _fresh(self, tests: str, plain: bool) -> bool:
        kept = self._kept(tests, plain)
        return kept.exists() and kept.stat().st_mtime > (self.copy / tests).stat().st_mtime

    def _ask(self, tests: str, kept: Path) -> int:
        signal.signal(signal.SIGXCPU, signal.default_int_handler)  # what was seen until then is kept
        touched = Touched(f"{self.copy / PACKAGE}{os.sep}")
        ended = pytest.main([*OPTIONS, tests], plugins=[touched])
        kept.write_text(json.dumps(touched.found))
        return ended

    def _failing(self, chosen: list[str], longest: float, plain: bool) -> str:
        """The first of the tests that fails, "too long", or ""."""
        ended = self._run(lambda: pytest.main([*OPTIONS, "-x", *chosen]), longest, plain)
        if ended == 0:
            return ""
        if ended == -signal.SIGXCPU:
            return "too long"
        if ended in {BROKEN, pytest.ExitCode.INTERNAL_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED}:
            raise SystemExit(f"{chosen} ended with {ended}:\n{(self.memory / 'said').read_text()}")
        said = (self.memory / "said").read_text().splitlines()
        lines = [line for line in said if line.startswith(("FAILED", "ERROR"))]
        return lines[0].split(" - ")[0].split(" ", 1)[1] if lines else chosen[0]

    def _run(self, ask: Callable[[], int], longest: float, plain: bool) -> int:
        """Exit status of a fork in which something is asked of the copy.

        Where functions of the mutated file are compiled, nothing is (``plain``): compiled, their lines are
        not seen, and Numba would keep those that call them and hold a copy of them.
        """
        child = os.fork()
        if child:
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (int(longest), int(longest) + 10))
            os.chdir(self.copy)
            said = os.open(self.memory / "said", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(said, 1)
            os.dup2(said, 2)
            os.environ["PYTHONPATH"] = str(self.copy)
            sys.path.insert(0, str(self.copy))
            if plain:
                os.environ["NUMBA_DISABLE_JIT"] = "1"
                sys.modules["numba"].config.DISABLE_JIT = 1
            status = ask()
        except BaseException:
            traceback.print_exc()
            status = BROKEN
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _write(path: Path, text: str) -> None:
    """Write a module; Python would take an older one's bytecode for it if length and second are the same."""
    path.write_text(text)
    Path(importlib.util.cache_from_source(str(path))).unlink(missing_ok=True)


def _statement(text: str, line: int) -> set[int] | None:
    """Lines of the statement (its head, if it has a body), or None if it runs on import."""
    around = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or 0)
    ]  # from the outside to the inside
    if not any(isinstance(node, ast.FunctionDef) for node in around):
        return None
    inner = around[-1]
    body = getattr(inner, "body", None)
    last = body[0].lineno - 1 if body else inner.end_lineno or line
    return set(range(inner.lineno, last + 1))


def _copy(folder: Path, part: str) -> None:
    """Put the project's own files, or those of a part, in a folder."""
    command = ["git", "ls-files", "-z", "--", part or "."]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    for name in filter(None, listed.stdout.split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)


def table(told: list[dict[str, str]]) -> str:
    """How many were noticed, and each with the test that did."""
    seen = sum(bool(one["noticed"]) for one in told)
    rows = [
        f"{seen} of {len(told)} were noticed.",
        "",
        "| file | line | change | noticed by |",
        "|---|---|---|---|",
    ]
    for one in sorted(told, key=lambda one: (one["file"], one.get("line", 0))):
        by = one["noticed"].split("::")
        noticed = f"`{by[-1]}`" if one["noticed"] else f"**nothing**: {one.get('why', 'a hole')}"
        file = one["file"].removeprefix(f"{PACKAGE}/")
        cells = (f"`{file}`", f"`{one['code']}`", f"`{one['old']}` → `{one['new']}`", noticed)
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())

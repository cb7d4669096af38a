"""Mutations: whether a test notices that a line of mechanics is wrong.

    python tools/mutations.py --count 100 --out mutations.json
    python tools/mutations.py --table mutations.json        # the table of tests/README.md

Each mutation changes one operator, comparison, sign, ½ or choice between least and greatest, in a copy of
the project. Of the tests of its room, then of those of validation, it runs those that come to the changed
line, the quickest first, until one fails; which these are is asked once (`touched.py`). A seed chooses the
places, as many in each file as any. A run goes on where one ended, with the copy made then: it stands beside
the file of outcomes, in a folder of that name.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "masonry_fem"
LONGEST = 900  # seconds of a run of tests; what takes longer is noticed, too

# files in which a wrong sign is wrong mechanics, and the tests that are to see it first
ROOMS = {
    ("march/step", "march/conditions", "march/coupling", "march/place", "march/loads", "march/motion"):
        ("tests/march", "tests/validation/test_a1_single_block.py", "tests/validation/test_a1_6_rocking.py"),
    ("march/energy", "march/acting", "march/measure"): ("tests/march", "tests/test_certificate_page.py"),
    ("bodies/rigid", "bodies/rotation", "bodies/inertia", "bodies/support"):
        ("tests/bodies", "tests/march"),
    ("nscd/local", "nscd/graphs", "nscd/problem", "nscd/residuals", "nscd/scaling"): ("tests/nscd",),
    ("contact/kinematics", "contact/clipping", "contact/placement/corners", "contact/placement/nodes",
     "contact/placement/parts/quadrature", "contact/interpolation"): ("tests/contact",),
    ("fem/condense", "fem/stress", "fem/assemble", "fem/material", "fem/traction"): ("tests/fem",),
    ("joints/reduction", "joints/laws/fremond_cangemi", "joints/laws/mohr_coulomb", "joints/laws/parts/bed",
     "joints/laws/parts/rigid_brittle", "joints/laws/parts/rough", "joints/laws/parts/softening"): (
         "tests/joints",),
    ("limit/problem", "limit/program", "limit/strength"): ("tests/limit",),
    ("solid/polytope", "solid/pose"): ("tests/solid", "tests/contact"),
}  # fmt: skip
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
    parser.add_argument("--out", type=Path, default=Path("mutations.json"), help="where they are told")
    parser.add_argument("--table", type=Path, help="print the table of such a file, and end")
    chosen = parser.parse_args(arguments)
    if chosen.table:
        print(table(json.loads(chosen.table.read_text())))
        return 0
    told = json.loads(chosen.out.read_text()) if chosen.out.exists() else []
    known = {(one["file"], one["line"], one["start"], one["new"]) for one in told}
    tests = Tests(chosen.out.with_suffix("").resolve())
    for number, one in enumerate(sample(chosen.count, chosen.seed, tests.copy), 1):
        if (one.file, one.line, one.start, one.new) in known:
            continue
        seen = noticed(one, tests)
        told.append(asdict(one) | {"noticed": seen})
        chosen.out.write_text(json.dumps(told, indent=1) + "\n")
        print(
            f"{number:4d} {one.file}:{one.line} {one.old} -> {one.new}: {seen or 'NOT NOTICED'}", flush=True
        )
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


def noticed(one: Mutation, tests: Tests) -> str:
    """The test that fails with it, "too long", or "" where all pass."""
    stem = one.file.removeprefix(f"{PACKAGE}/").removesuffix(".py")
    near = next(folders for files, folders in ROOMS.items() if stem in files)
    touching = [tests.touching(one, folders) for folders in (near, LAST)]
    path = tests.copy / one.file
    original, times = path.read_text(), path.stat()
    lines = original.splitlines(keepends=True)
    line = lines[one.line - 1].encode()
    lines[one.line - 1] = (line[: one.start] + one.new.encode() + line[one.end :]).decode()
    path.write_text("".join(lines))
    try:
        return next(filter(None, (tests.failing(chosen, one) for chosen in touching)), "")
    finally:
        path.write_text(original)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # what was compiled of it is good again


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
            _copy(self.copy)

    def touching(self, one: Mutation, folders: tuple[str, ...]) -> list[str]:
        """Tests that come to the statement, the quickest first; all where that cannot be seen."""
        within, hidden = _statement((self.copy / one.file).read_text(), one.line)
        file = one.file.removeprefix(f"{PACKAGE}/")
        known = [test for folder in folders for test in self._known(folder).items()]
        chosen = {
            name: seconds for name, (seconds, lines) in known if hidden or within & set(lines.get(file, ()))
        }
        return sorted(chosen, key=lambda name: chosen[name])

    def _known(self, folder: str) -> dict[str, tuple[float, dict[str, list[int]]]]:
        """Seconds and lines of each test of a folder (or file) that is not marked slow."""
        kept = self.memory / f"{folder.replace('/', '.')}.json"
        if not kept.exists():
            done = self._run([folder], {"TOUCHED": str(kept)}, "-p", "touched")
            if done.returncode:
                kept.unlink(missing_ok=True)
                print(done.stdout)
                raise SystemExit(f"{folder} fails without any mutation, expected it to pass; mend that first")
        known: dict[str, tuple[float, dict[str, list[int]]]] = json.loads(kept.read_text())
        return known

    def failing(self, chosen: list[str], one: Mutation) -> str:
        """The first of the tests that fails, "too long", or ""."""
        if not chosen:
            return ""
        extra = {"PYTHONDONTWRITEBYTECODE": "1"}
        with tempfile.TemporaryDirectory(prefix="compiled-") as fresh:
            if "@njit" in (self.copy / one.file).read_text():
                extra["NUMBA_CACHE_DIR"] = fresh  # what calls a compiled function may hold a copy of it
            try:
                done = self._run(chosen, extra, timeout=LONGEST)
            except subprocess.TimeoutExpired:
                return "too long"
        if done.returncode == 0:
            return ""
        lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
        return lines[0].split(" - ")[0].split(" ", 1)[1] if lines else chosen[0]

    def _run(
        self, tests: list[str], extra: dict[str, str], *options: str, timeout: float | None = None
    ) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow"]
        paths = f"{self.copy}{os.pathsep}{self.copy / 'tools'}"
        environment = os.environ | {"PYTHONPATH": paths} | extra
        return subprocess.run(
            [*command, *options, *tests],
            cwd=self.copy,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=timeout,
        )


def _statement(text: str, line: int) -> tuple[set[int], bool]:
    """Lines of the statement (its head, if it has a body), and whether no one sees who runs it.

    Nobody sees it in a compiled function; and what runs on import, runs for all.
    """
    around = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or 0)
    ]  # from the outside to the inside
    functions = [node for node in around if isinstance(node, ast.FunctionDef)]
    compiled = any("njit" in ast.unparse(mark) for node in functions for mark in node.decorator_list)
    inner = around[-1]
    body = getattr(inner, "body", None)
    last = body[0].lineno - 1 if body else inner.end_lineno or line
    return set(range(inner.lineno, last + 1)), compiled or not functions


def _copy(folder: Path) -> None:
    """Put the project's own files in a folder."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    for name in filter(None, listed.stdout.split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)


def table(told: list[dict[str, str]]) -> str:
    """How many were noticed by room, and each that was not."""
    rows = ["| lines of | mutations | noticed |", "|---|---|---|"]
    rooms = {one["file"].split("/")[1] for one in told}
    for room in sorted(rooms):
        here = [one for one in told if one["file"].split("/")[1] == room]
        rows.append(f"| `{room}` | {len(here)} | {sum(bool(one['noticed']) for one in here)} |")
    rows.append(f"| all | {len(told)} | {sum(bool(one['noticed']) for one in told)} |")
    missed = [one for one in told if not one["noticed"]]
    rows += ["", *(f"- `{one['file']}`, `{one['code']}`: `{one['old']}` → `{one['new']}`" for one in missed)]
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())

"""Fuzz: scenes and files changed at random; what becomes of them, counted.

    python -m benchmarks.fuzz --scenes 10000 --files 1000 --seed 0 --out results/fuzz    # docs/robustness.md
    python -m benchmarks.fuzz --only scene:4711 --out results/fuzz    # one case, kept in that folder

Each case is one command of masonry-fem, in a worker that runs hundreds of them (``fuzz_worker``). One that
kills the worker, or is not done in ``LIMIT`` s of CPU time, is run again as users run it, and Ctrl-C is
pressed where that takes as long. A fault is a traceback, a hang (Ctrl-C does not help), a crash (a signal), a
file written outside of the results folder, a program that was run without trust, an error that the program
did not foresee ("unexpected ...", "does not foresee"), and bad input without exactly one sentence.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import psutil

from benchmarks.fuzz_bases import FOREIGN, HELD, LAW, QUAKE, ROOT, SMALL, files, scene_trees
from benchmarks.mutation import mutated_file, mutated_scene

LIMIT = 30.0  # CPU time after which a case counts as long [s]
PATIENCE = 20.0  # CPU time for Ctrl-C to end it [s]
BATCH = 400  # cases of a worker
RUN_SCENES, RUN_FILES = 0.04, 0.10  # shares that are run, not only checked
BESIDE = {"record csv": ("quake.csv", "sliding"), "law py": ("law.py", "yielding")}  # file of which scene
FAULTS = ("traceback", "hang", "crash", "stray file", "run untrusted", "unforeseen", "no sentence")
GOOD = {0: "accepted", 1: "refused", 2: "no convergence", 3: "no equilibrium", 130: "long, ended by Ctrl-C"}


@dataclass(slots=True)
class Case:
    """A command in a folder that holds all it needs."""

    kind: str
    name: str
    folder: Path
    arguments: list[str]
    untrusted: bool = False


@dataclass(slots=True)
class Verdict:
    """What became of a case: an entry of ``GOOD`` or of ``FAULTS``, and what was said."""

    name: str
    kind: str
    outcome: str
    said: str
    seconds: float
    faults: list[str] = field(default_factory=list)
    again: bool = False


class Bases:
    """What is mutated, made once."""

    def __init__(self) -> None:
        self.scenes, self.small = scene_trees()
        self.files = files()

    def prepare(self, name: str, seed: int, out: Path) -> Case:
        """The case ``scene:7`` or ``file:7`` in a new folder."""
        kind, _, number = name.partition(":")
        random = Random(f"{seed}:{name}")
        folder = out / f"{kind}{number}"
        shutil.rmtree(folder, ignore_errors=True)
        (folder / "tmp").mkdir(parents=True)
        (folder / "quake.csv").write_text(QUAKE)
        (folder / "law.py").write_text(LAW, encoding="utf-8")
        return self._scene(name, folder, random) if kind == "scene" else self._file(name, folder, random)

    def _scene(self, name: str, folder: Path, random: Random) -> Case:
        runs = random.random() < RUN_SCENES
        text = mutated_scene(self.small if runs else self.scenes, random)
        meshes = str(ROOT / "meshes") + "/"
        (folder / "scene.toml").write_text(
            text.replace("../meshes/", meshes), encoding="utf-8", errors="replace"
        )
        return Case("scene, run" if runs else "scene, check", name, folder, _command(runs))

    def _file(self, name: str, folder: Path, random: Random) -> Case:
        label, ending, data = self.files[int(name.partition(":")[2]) % len(self.files)]
        runs = random.random() < RUN_FILES
        (folder / f"file{ending}").write_bytes(data)
        changed = mutated_file(ending, data, random)
        if ending == ".npz":
            (folder / "file.npz").write_bytes(changed)
            return Case(label, name, folder, ["contact", "file.npz"])
        if label in BESIDE:
            beside, scene = BESIDE[label]
            (folder / beside).write_bytes(changed)
            (folder / "scene.toml").write_text(SMALL[scene])
            return Case(label, name, folder, _command(runs=True))
        (folder / f"file{ending}").write_bytes(changed)
        more = f', supports = ["{HELD.get(label, "b1")}"]' + (", trusted = true" if label == "geo" else "")
        more = ", depth = 0.3" if label == "survey csv" else more
        kind = "survey" if label == "survey csv" else "file"
        fidelity = "elastic" if random.random() < 0.2 else "rigid"
        text = FOREIGN.format(fidelity=fidelity, kind=kind, ending=ending, more=more)
        (folder / "scene.toml").write_text(text)
        return Case(label, name, folder, _command(runs), untrusted=label == "geo untrusted")


def _command(runs: bool) -> list[str]:
    return ["run", "scene.toml", "--quiet", "--out", "out"] if runs else ["check", "scene.toml"]


class Worker:
    """A worker process, begun anew where it has died or done its share."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._done = 0

    def judge(self, case: Case) -> Verdict:
        """Run a case here; run it again as users do where it ends the worker or does not end."""
        report = self._report(case)
        verdict = None if report is None else verdict_of(case, report)
        if verdict is None or verdict.outcome == GOOD[130]:
            verdict = verdict_of(case, _as_users_do(case))
            verdict.again = True
        return verdict

    def _report(self, case: Case) -> dict[str, Any] | None:
        process = self._started()
        assert process.stdin is not None
        assert process.stdout is not None
        request = {"folder": str(case.folder), "arguments": case.arguments}
        try:
            process.stdin.write(json.dumps(request) + "\n")
            process.stdin.flush()
        except OSError:
            self.end()
            return None
        if _awaited(process, process.stdout.fileno()):
            line = process.stdout.readline()
            if line:
                self._done += 1
                report: dict[str, Any] = json.loads(line)
                return report
        self.end()
        return None

    def _started(self) -> subprocess.Popen[str]:
        if self._process is None or self._done >= BATCH or self._process.poll() is not None:
            self.end()
            self._done = 0
            self._process = subprocess.Popen(
                [sys.executable, "-m", "benchmarks.fuzz_worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                cwd=ROOT,
                env=_environment(),
                start_new_session=True,
            )
        return self._process

    def end(self) -> None:
        """Kill it."""
        if self._process is not None:
            _kill(self._process)
            self._process = None


def _environment() -> dict[str, str]:
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    return os.environ | threads | {"PYTHONPATH": path}


def _kill(process: subprocess.Popen[Any]) -> None:
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            with contextlib.suppress(OSError):
                stream.close()


def _used(process: subprocess.Popen[Any]) -> float:
    """CPU time of a process and of those that it started [s]."""
    try:
        own = psutil.Process(process.pid)
        return sum(sum(one.cpu_times()[:2]) for one in (own, *own.children(recursive=True)))
    except psutil.Error:
        return 0.0


def _awaited(process: subprocess.Popen[Any], stream: int) -> bool:
    """Whether something is said, or the stream ends, before the limit."""
    begun, wall = _used(process), time.monotonic()
    while not select.select([stream], [], [], 0.5)[0]:
        if _used(process) - begun > LIMIT or time.monotonic() - wall > 10 * LIMIT:
            return False
    return True


def _ends(process: subprocess.Popen[Any], limit: float) -> bool:
    """Whether it ends by itself within so much more CPU time, or ten times as long."""
    begun, wall = _used(process), time.monotonic()
    while process.poll() is None:
        if _used(process) - begun > limit or time.monotonic() - wall > 10 * limit:
            return False
        time.sleep(0.1)
    return True


def _as_users_do(case: Case) -> dict[str, Any]:
    """Run a case in a process of its own; Ctrl-C after the limit, the end after some more."""
    before = set(case.folder.rglob("*"))
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "masonry_fem", *case.arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
            cwd=case.folder,
            env=_environment() | {"TMPDIR": str(case.folder / "tmp")},
            start_new_session=True,
        )
        begun = time.monotonic()
        hung = not _ends(process, LIMIT)
        if hung:
            process.send_signal(signal.SIGINT)
            hung = not _ends(process, PATIENCE)
        _kill(process)
        said.seek(0)
        words = said.read().decode(errors="replace")[-20_000:]
    strays = [
        str(one)
        for one in set(case.folder.rglob("*")) - before
        if "out" not in one.relative_to(case.folder).parts
    ]
    return {
        "code": process.returncode,
        "said": words,
        "strays": strays,
        "hung": hung,
        "seconds": time.monotonic() - begun,
    }


def verdict_of(case: Case, report: dict[str, Any]) -> Verdict:
    """What a report of a case comes to."""
    code, said = report["code"], report["said"]
    sentences = re.findall(r"(?m)^masonry-fem: .*", said)
    trusted = case.kind == "geo"
    strays = [one for one in report["strays"] if not (trusted and Path(one).name.startswith("ran"))]
    faults = {
        "hang": report.get("hung", False),
        "crash": isinstance(code, int) and code < 0 and not report.get("hung"),
        "traceback": "Traceback (most recent" in said
        or (code not in GOOD and not (isinstance(code, int) and code < 0)),
        "unforeseen": "masonry-fem: unexpected " in said or "does not foresee" in said,
        "no sentence": code == 1 and len(sentences) != 1,
        "stray file": bool(strays),
        "run untrusted": case.untrusted and (case.folder / "ran").exists(),
    }
    found = [name for name in FAULTS if faults[name]]
    outcome = GOOD.get(code, "fault")
    words = "; ".join([*sentences, *(["strays: " + ", ".join(strays)] if strays else [])]) or said[-500:]
    return Verdict(case.name, case.kind, outcome, words, report["seconds"], found)


def judged(
    names: Sequence[str],
    seed: int,
    out: Path,
    workers: int = 1,
    keep: bool = False,
    bases: Bases | None = None,
) -> Iterator[Verdict]:
    """The verdict of each case, in order; folders of cases without fault are removed."""
    mutated = bases or Bases()

    def share(own: Sequence[str]) -> Iterator[Verdict]:
        worker = Worker()
        try:
            for name in own:
                case = mutated.prepare(name, seed, out)
                verdict = worker.judge(case)
                if not verdict.faults and not keep:
                    shutil.rmtree(case.folder, ignore_errors=True)
                yield verdict
        finally:
            worker.end()

    if workers == 1:
        yield from share(names)
        return
    pieces = [names[at : at + BATCH] for at in range(0, len(names), BATCH)]
    with ThreadPoolExecutor(workers) as pool:
        for made in pool.map(lambda own: list(share(own)), pieces):
            yield from made


def table(verdicts: Sequence[Verdict]) -> str:
    """Cases by kind: what became of them, and faults, as Markdown."""
    columns = [*GOOD.values(), *FAULTS]
    lines = ["| cases | number | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    kinds = list(dict.fromkeys(one.kind for one in sorted(verdicts, key=lambda one: one.kind)))
    for title, own in [
        *((kind, [one for one in verdicts if one.kind == kind]) for kind in kinds),
        ("**all**", list(verdicts)),
    ]:
        counts = Counter(one.outcome for one in own) + Counter(fault for one in own for fault in one.faults)
        lines.append(f"| {title} | {len(own)} | " + " | ".join(str(counts[name]) for name in columns) + " |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Fuzz and print the table; 1 where there was a fault."""
    parser = argparse.ArgumentParser(prog="benchmarks.fuzz")
    parser.add_argument("--scenes", type=int, default=10_000)
    parser.add_argument("--files", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument(
        "--only", action="append", default=[], metavar="KIND:NUMBER", help="this case; it is kept"
    )
    parser.add_argument("--out", type=Path, required=True, help="where cases with faults stay")
    options = parser.parse_args(arguments)
    names = options.only or [
        *(f"scene:{number}" for number in range(options.scenes)),
        *(f"file:{number}" for number in range(options.files)),
    ]
    out = options.out.resolve()
    verdicts = []
    for verdict in judged(names, options.seed, out, options.workers, keep=bool(options.only)):
        verdicts.append(verdict)
        if verdict.faults or options.only or verdict.outcome == GOOD[130]:
            told = ", ".join(verdict.faults) or verdict.outcome
            print(f"{verdict.name} ({verdict.kind}): {told}: {verdict.said[:600]}", flush=True)
    print(table(verdicts))
    print(
        f"seed {options.seed}; {sum(one.again for one in verdicts)} cases were run again, as users run them"
    )
    return int(any(one.faults for one in verdicts))


if __name__ == "__main__":
    sys.exit(main())

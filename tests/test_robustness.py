"""Robustness: a small part of what ``benchmarks/fuzz.py`` does (docs/robustness.md), with other seeds."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from benchmarks.fuzz import FAULTS, GOOD, Bases, judged, table, verdict_of
from benchmarks.mutation import mutated_file, mutated_scene


@pytest.fixture(scope="module")
def bases() -> Bases:
    return Bases()


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "count"), [("scene", 500), ("file", 100)])
def test_what_is_changed_at_random_is_answered(kind: str, count: int, bases: Bases, tmp_path: Path) -> None:
    """Accepted or refused in one sentence, within the limits, and nothing is written elsewhere."""
    verdicts = list(judged([f"{kind}:{number}" for number in range(count)], 1, tmp_path, bases=bases))
    assert [(one.name, one.faults, one.said) for one in verdicts if one.faults] == []
    outcomes = {one.outcome for one in verdicts}
    assert outcomes <= set(GOOD.values())
    assert {"accepted", "refused"} <= outcomes  # neither all too tame nor all too wild
    assert f"| **all** | {count} |" in table(verdicts)


def test_the_same_seed_makes_the_same_cases(bases: Bases) -> None:
    for number in range(50):
        texts = [mutated_scene(bases.scenes, Random(number)) for _ in range(2)]
        assert texts[0] == texts[1]
    for number, (_, ending, data) in enumerate(bases.files):
        made = [mutated_file(ending, data, Random(number)) for _ in range(2)]
        assert made[0] == made[1]


def test_faults_are_found(bases: Bases, tmp_path: Path) -> None:
    """A program that is run, a file that is left and an error that is not foreseen do not pass."""
    name = next(f"file:{k}" for k, (label, _, _) in enumerate(bases.files) if label == "geo untrusted")
    case = bases.prepare(name, 0, tmp_path)
    (case.folder / "ran").touch()
    sentence = "masonry-fem: unexpected KeyError: 'x'\n"
    report = {"code": 1, "said": sentence, "strays": ["/elsewhere"], "seconds": 0.0}
    assert set(verdict_of(case, report).faults) == {"unforeseen", "stray file", "run untrusted"}
    (case.folder / "ran").unlink()
    said = {
        "traceback": {"code": None, "said": "Traceback (most recent call last):\n"},
        "no sentence": {"code": 1, "said": ""},
        "crash": {"code": -11, "said": ""},
        "hang": {"code": -9, "said": "", "hung": True},
    }
    for fault, what in said.items():
        assert fault in FAULTS
        assert verdict_of(case, {"strays": [], "seconds": 0.0} | what).faults == [fault]

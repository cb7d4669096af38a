"""One answer on every processor: what a scene comes to does not depend on the machine code of the BLAS.

- Outcomes, verdicts, exit codes and the names of what moves are the same.
- Supports' resultants and displacements, where they are determined, agree to a hundred times the solver's
  tolerance (1e-10 unless a scene says otherwise) of the largest of them.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from masonry_fem.scene.specs import Contact, Output, Probe, Scene
from masonry_fem.scene.writing import dumps
from tests.extremes.scenes import arch, pushed_wall, sliding_block
from tests.kernels import NAMES, environment, kernel

AGREE = 100 * 1e-10

# A rigid scene's reactions are many; those of least norm are the same for all solvers.
LEAST_NORM = Output(determinacy=True, pictures=False)
CORNER = Probe(name="corner", block="wall.c4.b4", point=(1.2, 0.8))


def _with(scene: Scene, **changes: Any) -> Scene:
    return msgspec.structs.replace(scene, **{"output": Output(pictures=False), **changes})


SCENES: dict[str, tuple[str, Scene]] = {
    "arch": ("run", _with(arch(9, 0.15), output=LEAST_NORM)),
    "thin_arch": ("run", _with(arch(7, 0.1), output=LEAST_NORM)),
    "wall_that_slips": ("run", _with(pushed_wall(0.3, 0.2), output=LEAST_NORM)),
    "elastic_wall": ("run", _with(pushed_wall(0.3, 0.2, "elastic"), probes=(CORNER,))),
    "falls": ("run", _with(pushed_wall(0.3, 0.5))),
    "just_above_the_limit": ("run", _with(pushed_wall(0.3, 0.3001))),
    # as its stones turn its limit falls, by some 1e-6 of the load; where they do not it stands
    "elastic_at_the_limit": ("run", _with(pushed_wall(0.3, 0.3, "elastic"))),
    "elastic_short_of_the_limit": ("run", _with(pushed_wall(0.3, 0.3 * (1 - 3e-7), "elastic"))),
    "elastic_at_the_fixed_limit": (
        "run",
        _with(pushed_wall(0.3, 0.3, "elastic"), contact=Contact(update="fixed")),
    ),
    "slides_in_time": ("run", _with(sliding_block(0.01))),
    "limit": ("limit --tilt=x --json", _with(pushed_wall(0.6, 0.0))),
    "collapse": ("collapse --acceleration=x", _with(pushed_wall(0.6, 0.0))),
}


@pytest.fixture(scope="module")
def came_to(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str | None], dict[str, Any]]:
    """All scenes run with a kernel: exit codes, what was printed, summaries."""

    @cache
    def run(name: str | None) -> dict[str, Any]:
        folder = tmp_path_factory.mktemp(name or "own")
        for key, (command, scene) in SCENES.items():
            (folder / f"{key}.toml").write_text(f"# {command}\n{dumps(scene)}", encoding="utf-8")
        worker = [sys.executable, "-m", "tests.kernel_worker", str(folder)]
        root = Path(__file__).resolve().parents[1]
        made = subprocess.run(
            worker, env=environment(name), cwd=root, capture_output=True, text=True, check=False
        )
        assert made.returncode == 0, made.stderr
        told: dict[str, Any] = json.loads((folder / "codes.json").read_text(encoding="utf-8"))
        for key, (command, _) in SCENES.items():
            written = {"run": "summary.json", "collapse": "collapse.json"}.get(command.split()[0])
            text = told[key]["printed"] if written is None else (folder / key / written).read_text("utf-8")
            told[key] = {**told[key], **json.loads(text)}
        return told

    return run


def forces(told: dict[str, Any]) -> np.ndarray:
    """Of all supports, with their moments, one after the other."""
    return np.concatenate([one[part] for one in told["supports"].values() for part in ("force", "moment")])


def positions(told: dict[str, Any]) -> np.ndarray:
    return np.array(list(told["probes"].values()), dtype=float).ravel()


def assert_close(one: np.ndarray, other: np.ndarray) -> None:
    assert one.shape == other.shape
    assert one == pytest.approx(other, rel=0, abs=AGREE * np.abs(other).max(initial=0.0))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_kernel_changes_nothing_that_is_promised(name: str, came_to) -> None:
    own, asked = kernel(None), kernel(name)
    if asked.taken is None:
        pytest.skip(f"{name}: {asked.reason}")
    if own.taken is None:
        pytest.skip(own.reason)
    if asked.taken == own.taken:
        pytest.skip(f"{name}: this processor runs {own.taken} by itself")
    one, other = came_to(None), came_to(name)
    assert one["kernels"] == [own.taken]
    assert other["kernels"] == [asked.taken]
    for key, (command, _) in SCENES.items():
        ours, theirs = one[key], other[key]
        assert ours["code"] == theirs["code"], key
        if command == "run":
            assert ours["outcome"] == theirs["outcome"], key
            assert {b["block"] for b in ours["moving"]} == {b["block"] for b in theirs["moving"]}, key
            if ours["code"] == 0:
                assert_close(forces(ours), forces(theirs))
                assert_close(positions(ours), positions(theirs))
        elif key == "limit":
            assert ours["admissible"] == theirs["admissible"]
            assert ours["multiplier"] == pytest.approx(theirs["multiplier"], rel=AGREE)
        else:
            assert ours["outcome"] == theirs["outcome"]
            for bound in ("stands", "falls", "limit_multiplier"):
                assert ours[bound] == pytest.approx(theirs[bound], rel=AGREE), bound


@pytest.mark.slow
def test_the_scenes_come_to_all_there_is(came_to) -> None:
    """So that agreement is not one of failures."""
    told = came_to(None)
    outcomes = {key: told[key]["outcome"] for key, (command, _) in SCENES.items() if command == "run"}
    assert outcomes == {
        "arch": "equilibrium",
        "thin_arch": "equilibrium",
        "wall_that_slips": "equilibrium",
        "elastic_wall": "equilibrium",
        "falls": "no_equilibrium",
        "just_above_the_limit": "no_equilibrium",
        "elastic_at_the_limit": "no_equilibrium",
        "elastic_short_of_the_limit": "no_equilibrium",
        "elastic_at_the_fixed_limit": "equilibrium",
        "slides_in_time": "finished",
    }
    assert told["elastic_wall"]["probes"]
    assert told["collapse"]["outcome"] == "bracketed"


def test_a_kernel_that_nothing_knows_is_not_taken() -> None:
    """OpenBLAS then picks its own, and one sees it."""
    one = kernel("NoSuchKernel")
    assert one.taken is None or one.taken == kernel(None).taken

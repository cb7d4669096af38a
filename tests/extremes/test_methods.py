"""Every analysis, strategy and method on scenes at rest and on one that falls: the answer, or what to do."""

from __future__ import annotations

import re

import msgspec
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.errors import MasonryError
from masonry_fem.scene.specs import Analysis, Dynamics, Equilibrium, Solver, Statics
from tests.extremes.scenes import (
    arch,
    arch_error,
    block_on_slope,
    certificate,
    finite,
    pushed_wall,
    slope_error,
    wall_error,
)

METHODS = ["auto", "nsgs", "newton", "interior_point"]
ANALYSES: dict[str, Analysis] = {
    "statics": Statics(),
    "load steps": Statics(load_steps=3),
    "dynamics": Dynamics(step=0.01, duration=0.03, theta=1.0),
    "numerical viscosity": Equilibrium(strategy="numerical_viscosity", step=1.0, max_steps=20),
    "brutal damping": Equilibrium(strategy="brutal_damping", step=0.1, max_steps=20),
    "linear damping": Equilibrium(strategy="linear_damping", step=1.0, max_steps=40),
    "large step": Equilibrium(strategy="large_step", step=1.0, max_steps=5),
}
SCENES = {
    "slope": (block_on_slope, slope_error),
    "arch": (arch, arch_error),
    "wall": (pushed_wall, wall_error),
}


def attempted(name: str, fidelity: str, analysis: str, method: str) -> RunResult:
    """The result of a scene at rest."""
    build, _ = SCENES[name]
    scene = build(fidelity=fidelity, dimension=2, analysis=ANALYSES[analysis])
    return solve_scene(msgspec.structs.replace(scene, solver=Solver(method=method, tolerance=1e-8)))


REFUSED = [("nsgs", analysis) for analysis in ("statics", "load steps")]  # sweeps want inertia


@pytest.mark.parametrize(("method", "analysis"), REFUSED)
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("name", SCENES)
def test_sweeps_refuse_statics(name: str, fidelity: str, analysis: str, method: str) -> None:
    with pytest.raises(MasonryError, match="use method 'auto' or 'newton'"):
        attempted(name, fidelity, analysis, method)


CRAWLING = [  # sweeps between elastic blocks
    (name, "elastic", analysis, "nsgs")
    for name in SCENES
    for analysis in ANALYSES
    if ("nsgs", analysis) not in REFUSED and (name, analysis) != ("slope", "dynamics")
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "fidelity", "analysis", "method"), CRAWLING)
def test_a_method_that_gives_up_says_what_to_try(
    name: str, fidelity: str, analysis: str, method: str
) -> None:
    result = attempted(name, fidelity, analysis, method)
    assert finite(result)
    assert result.outcome == "no_convergence"
    assert re.search(r"[Tt]ry|[Rr]aise|[Aa]llow|Compare|Apply", result.message)


SOLVED = [
    pytest.param(
        name, fidelity, analysis, method,
        marks=[pytest.mark.slow] if fidelity == "elastic" and method == "nsgs" else [],
    )
    for name in SCENES
    for fidelity in ("rigid", "elastic")
    for analysis in ANALYSES
    for method in METHODS
    if (method, analysis) not in REFUSED and (name, fidelity, analysis, method) not in CRAWLING
]  # fmt: skip


@pytest.mark.parametrize(("name", "fidelity", "analysis", "method"), SOLVED)
def test_whatever_is_asked_for_is_solved(name: str, fidelity: str, analysis: str, method: str) -> None:
    """No method pretends: what it calls solved carries the weight; waves of elastic blocks go on in time."""
    result = attempted(name, fidelity, analysis, method)
    assert finite(result)
    assert result.outcome == ("finished" if analysis == "dynamics" else "equilibrium")
    if fidelity == "rigid" or analysis != "dynamics":
        assert SCENES[name][1](result) < 1e-5
    assert max(certificate(result).values()) < 1e-5


# Methods that only approach an answer, and stop where they no longer do, before they know that there is none.
UNDECIDED = {
    ("elastic", analysis, "nsgs")
    for analysis in ("numerical viscosity", "brutal damping", "linear damping", "large step")
} | {
    (fidelity, analysis, "interior_point")
    for fidelity, analyses in {
        "rigid": ("statics", "load steps"),
        "elastic": ("statics", "load steps", "numerical viscosity", "linear damping", "large step"),
    }.items()
    for analysis in analyses
}


def slide(fidelity: str, analysis: str, method: str) -> RunResult:
    """tan 20° > 0.3."""
    scene = block_on_slope(0.3, 20.0, fidelity, 2, ANALYSES[analysis])
    return solve_scene(msgspec.structs.replace(scene, solver=Solver(method=method, tolerance=1e-8)))


@pytest.mark.parametrize(
    ("fidelity", "analysis", "method"),
    [
        (fidelity, analysis, method)
        for fidelity in ("rigid", "elastic")
        for analysis in ANALYSES
        for method in METHODS
        if analysis != "dynamics"
        and (method, analysis) not in REFUSED
        and (fidelity, analysis, method) not in UNDECIDED
    ],
)
def test_what_slides_is_told(fidelity: str, analysis: str, method: str) -> None:
    result = slide(fidelity, analysis, method)
    assert result.outcome == "no_equilibrium"
    assert "cube.b1 slides" in result.message
    assert finite(result)


@pytest.mark.parametrize(("fidelity", "analysis", "method"), sorted(UNDECIDED))
def test_no_method_holds_what_slides(fidelity: str, analysis: str, method: str) -> None:
    result = slide(fidelity, analysis, method)
    assert result.outcome == "no_convergence"
    assert "Try method 'auto'" in result.message
    assert finite(result)

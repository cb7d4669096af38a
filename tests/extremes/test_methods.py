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

METHODS = ["auto", "nsgs", "newton", "interior_point", "pivoting"]
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


def attempted(name: str, fidelity: str, analysis: str, method: str) -> RunResult | str:
    """The result, or the words of a refusal."""
    build, _ = SCENES[name]
    scene = build(fidelity=fidelity, dimension=2, analysis=ANALYSES[analysis])
    try:
        return solve_scene(msgspec.structs.replace(scene, solver=Solver(method=method, tolerance=1e-8)))
    except MasonryError as error:
        return str(error)


CASES = [
    pytest.param(
        name, fidelity, analysis, method,
        marks=[pytest.mark.slow] if fidelity == "elastic" and method in ("pivoting", "nsgs") else [],
    )
    for name in SCENES
    for fidelity in ("rigid", "elastic")
    for analysis in ANALYSES
    for method in METHODS
]  # fmt: skip


REFUSED = [("nsgs", analysis) for analysis in ("statics", "load steps")]  # sweeps want inertia


def gives_up(name: str, fidelity: str, analysis: str, method: str) -> bool:
    """Sweeps crawl between elastic blocks."""
    return (fidelity, method) == ("elastic", "nsgs") and (name, analysis) != ("slope", "dynamics")


@pytest.mark.parametrize(("name", "fidelity", "analysis", "method"), CASES)
def test_whatever_is_asked_for_is_solved_or_told(
    name: str, fidelity: str, analysis: str, method: str
) -> None:
    """No method pretends: what it calls solved carries the weight, what it gives up on says what to try."""
    result = attempted(name, fidelity, analysis, method)
    if (method, analysis) in REFUSED:
        assert isinstance(result, str)
        assert "use method 'auto' or 'newton'" in result
        return
    assert not isinstance(result, str)
    assert finite(result)
    if gives_up(name, fidelity, analysis, method):
        assert result.outcome == "no_convergence"
        assert re.search(r"[Tt]ry|[Rr]aise|[Aa]llow|Compare|Apply", result.message)
        return
    assert result.outcome == ("finished" if analysis == "dynamics" else "equilibrium")
    if fidelity == "rigid" or analysis != "dynamics":
        assert SCENES[name][1](result) < 1e-5
    assert max(certificate(result).values()) < 1e-5


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("analysis", [name for name in ANALYSES if name != "dynamics"])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_no_method_holds_what_slides(fidelity: str, analysis: str, method: str) -> None:
    """tan 20° > 0.3."""
    scene = block_on_slope(0.3, 20.0, fidelity, 2, ANALYSES[analysis])
    scene = msgspec.structs.replace(scene, solver=Solver(method=method, tolerance=1e-8))
    if (method, analysis) in REFUSED:
        with pytest.raises(MasonryError, match="use method 'auto' or 'newton'"):
            solve_scene(scene)
        return
    result = solve_scene(scene)
    if method in {"auto", "newton", "pivoting"} or (
        fidelity == "rigid" and analysis not in {"statics", "load steps"}
    ):
        assert result.outcome == "no_equilibrium"
    else:  # one that only approaches an answer may end before it knows that there is none
        assert result.outcome in {"no_equilibrium", "no_convergence"}
    assert finite(result)
    if method == "auto":
        assert "cube.b1 slides" in result.message

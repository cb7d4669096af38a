"""A9.9, A9.10: the contact patch test with stiffnesses 1e6 apart, and with slivers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem, Solution, SolverSettings, Start, solve
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Solver,
    Statics,
    Support,
    Traction,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.file import FileStructure
from tests.validation.patch import P, by_block, pressed, worst_stress
from tests.validation.scenes import solved

# --- A9.9 ------------------------------------------------------------------------------------------

CONTRASTS = [1e-6, 1e6]


def least_squares(problem: ContactProblem, settings: SolverSettings, start: Start | None) -> Solution:
    """All contacts closed and without friction: W p + B U = −q, Bᵀ p = −f solved by eigenvectors."""
    d, count = problem.dimension, problem.count
    unit = 1e-16 + float(problem.compliance.diagonal().max())
    normal = np.zeros((count, problem.rigid_mass.size))
    m = problem.rigid_mass.shape[1]
    for contact, side in zip(*np.nonzero(problem.bodies >= 0), strict=True):
        body = int(problem.bodies[contact, side])
        normal[contact, m * body : m * (body + 1)] += problem.rigid_map[contact, side, 0]
    pushed = np.abs(normal).max(axis=0) > 0
    normal = normal[:, pushed]
    zero = np.zeros((normal.shape[1],) * 2)
    matrix = np.block([[problem.compliance.toarray()[::d, ::d] / unit, normal], [normal.T, zero]])
    right = -np.concatenate([problem.free_velocity[:, 0] / unit, problem.rigid_impulse.ravel()[pushed]])
    values, vectors = np.linalg.eigh(matrix)
    seen = np.abs(values) > 1e-13
    vectors, values = vectors[:, seen], values[seen]
    answer = np.zeros_like(right)
    for _ in range(3):  # with refinement
        answer += vectors @ ((vectors.T @ (right - matrix @ answer)) / values)
    impulse, motion = np.zeros((count, d)), problem.rigid_velocity.copy()
    impulse[:, 0] = answer[:count]
    motion.ravel()[pushed] = unit * answer[count:]
    ours = solve(problem, settings, start)
    return replace(ours, impulse=impulse, rigid_velocity=motion)


@pytest.mark.slow
@pytest.mark.parametrize("contrast", CONTRASTS)
@pytest.mark.parametrize(("d", "lower", "upper"), [(2, 2, 3), (2, 5, 7), (3, 2, 3), (3, 3, 2)])
def test_a9_9_condensed_problem_bears_a_contrast(
    d: int, lower: int, upper: int, contrast: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Condensation and stress recovery keep 8 digits, whoever solves the contact problem."""
    monkeypatch.setattr("masonry_fem.joints.fold.solve", least_squares)
    assert pressed(d, lower, upper, young=1e10 * contrast)[1] < 1e-8


@pytest.mark.parametrize("contrast", CONTRASTS)
def test_a9_9_solver_bears_a_contrast(contrast: float) -> None:
    result, error = pressed(2, 2, 3, young=1e10 * contrast, solver=Solver(tolerance=1e-15))
    assert result.outcome == "equilibrium"
    assert error < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-12, 1e-14])
@pytest.mark.parametrize("contrast", CONTRASTS)
@pytest.mark.parametrize(("d", "lower", "upper"), [(2, 5, 7), (3, 2, 3)])
def test_a9_9_stress_of_the_stiff_block_follows_the_tolerance(
    d: int, lower: int, upper: int, contrast: float, tolerance: float
) -> None:
    """Impulses that only the stiff mesh feels meet 1e-8 of the compliance of the others.

    A residual in units of the larger compliance lets them err by 2e6 … 2e7 times the tolerance;
    the stress in the soft block has none of it.
    """
    result, error = pressed(d, lower, upper, young=1e10 * contrast, solver=Solver(tolerance=tolerance))
    assert result.outcome == "equilibrium"
    assert error < 3e7 * tolerance
    soft = [stress for name, stress in by_block(result).items() if (name == "upper") == (contrast < 1)]
    assert max(soft) < 30 * tolerance


@pytest.mark.parametrize("contrast", CONTRASTS)
def test_a9_9_stiffness_contrast_keeps_uniform_stress(contrast: float) -> None:
    """A soft and a stiff cube under pressure with ν = 0: σ = −p in both."""
    result = solved(
        materials={
            "one": Material(density=1.0, young=1e10, poisson=0.0),
            "two": Material(density=1.0, young=1e10 * contrast, poisson=0.0),
        },
        structures=(
            BlockStructure(
                name="ground", material="one", size=(3, 3, 1), position=(-1, -1, -1), support=True
            ),
            BlockStructure(name="lower", material="one", size=(1, 1, 1)),
            BlockStructure(name="upper", material="two", size=(1, 1, 1), position=(0, 0, 1)),
        ),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        loads=Loads(tractions=(Traction(on="upper/top", vector=(0, 0, -P)),)),
        joints=(Joint(friction=0.0),),
        analysis=Statics(),
    )
    assert result.outcome == "equilibrium"
    stress = result.summary.stress
    assert stress.min_principal.value == pytest.approx(-P, rel=1e-8)
    assert abs(stress.max_principal.value) <= 1e-8 * P


# --- A9.10: slivers --------------------------------------------------------------------------------


def sliced(path: Path, name: str, y: float, cuts: list[float], layers: int) -> Path:
    """A unit square at height y whose columns of elements end at ``cuts``, as a gmsh geometry."""
    lines = []
    for i, x in enumerate(cuts):
        lines += [f"Point({2 * i + 1}) = {{{x}, {y}, 0}};", f"Point({2 * i + 2}) = {{{x}, {y + 1}, 0}};"]
        lines += [f"Line({3 * i + 1}) = {{{2 * i + 1}, {2 * i + 2}}};"]
    for i in range(len(cuts) - 1):
        a, b = 2 * i + 1, 2 * i + 3
        lines += [f"Line({3 * i + 2}) = {{{a}, {b}}};", f"Line({3 * i + 3}) = {{{a + 1}, {b + 1}}};"]
        loop = f"{3 * i + 2}, {3 * i + 4}, -{3 * i + 3}, -{3 * i + 1}"
        lines += [f"Curve Loop({i + 1}) = {{{loop}}}; Plane Surface({i + 1}) = {{{i + 1}}};"]
    columns = ", ".join(str(i + 1) for i in range(len(cuts) - 1))
    across = ", ".join(f"{3 * i + 2}, {3 * i + 3}" for i in range(len(cuts) - 1))
    upright = ", ".join(str(3 * i + 1) for i in range(len(cuts)))
    edges = {
        "bottom": [3 * i + 2 for i in range(len(cuts) - 1)],
        "top": [3 * i + 3 for i in range(len(cuts) - 1)],
    }
    lines += [
        f"Transfinite Curve {{{across}}} = 2; Transfinite Curve {{{upright}}} = {layers + 1};",
        f"Transfinite Surface {{{columns}}}; Recombine Surface {{{columns}}};",
        f'Physical Surface("{name}") = {{{columns}}};',
        'Physical Curve("left") = {1};',
        *(f'Physical Curve("{face}") = {{{", ".join(map(str, tags))}}};' for face, tags in edges.items()),
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a9_10_slivers(tmp_path: Path) -> None:
    """The patch test with elements of aspect 1e4 at the joint, at different places on both sides.

    The stress of a sliver magnifies the error of its impulses 1e5 times, hence the tight tolerance.
    """
    sliced(tmp_path / "lower.geo", "stone", 0.0, [0.0, 5e-5, 0.5, 1.0], 2)
    sliced(tmp_path / "upper.geo", "stone", 1.0, [0.0, 0.3, 0.3 + 5e-5, 1.0], 2)
    result = solved(
        dimension=2,
        plane="stress",
        materials={"stone": Material(density=1000.0, young=1e10, poisson=0.2)},
        structures=tuple(
            FileStructure(name=name, material="stone", path=str(tmp_path / f"{name}.geo"), trusted=True)
            for name in ("lower", "upper")
        ),
        supports=(
            Support(on="lower.stone/bottom", components=("y",)),
            Support(on="lower.stone/left", components=("x",)),
            Support(on="upper.stone/left", components=("x",)),
        ),
        joints=(Joint(friction=0.0, placement="gauss"),),
        loads=Loads(tractions=(Traction(on="upper.stone/top", vector=(0.0, -P)),)),
        analysis=Statics(),
        solver=Solver(tolerance=1e-14),
    )
    assert result.outcome == "equilibrium"
    assert worst_stress(result) < 1e-8

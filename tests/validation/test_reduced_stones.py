"""Reduced stones beside elastic ones: mean stresses, frequencies, rotation, and what the estimate tells."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.build import build
from masonry_fem.errors import MasonryError
from masonry_fem.fem.assemble import assemble_shapes
from masonry_fem.fem.error_estimate import energy_density
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.fem.modes import rigid_modes
from masonry_fem.fem.reduction import Basis
from masonry_fem.nscd import modal
from masonry_fem.nscd.mumps import Mumps
from masonry_fem.nscd.solvers import modal_system
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Initial,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Mortar,
    Override,
    Scene,
    Statics,
    Support,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.fem.meshes import box_mesh

YOUNG, POISSON, DENSITY, G = 10e9, 0.2, 2400.0, 9.81
# Numbers of polynomials of degree 1, 2, 3 without rigid motions, in 2D and in 3D.
NUMBERS = {2: (3, 9, 17), 3: (6, 24, 54)}


def scene(structure, fidelity: str, degree: int = 1, **keys) -> Scene:
    stone = Material(density=DENSITY, young=YOUNG, poisson=POISSON, degree=degree)
    down = (0.0,) * (keys.get("dimension", 3) - 1) + (-G,)
    given = {
        "fidelity": fidelity,
        "materials": {"stone": stone},
        "structures": structure if isinstance(structure, tuple) else (structure,),
        "joints": (Joint(friction=0.6),),
        "loads": Loads(gravity=down),
        "analysis": Statics(),
    } | keys
    return check(Scene(**given))


def wall(columns: int, courses: int) -> WallStructure:
    return WallStructure(
        name="wall", material="stone", brick=(0.5, 0.25, 0.25), columns=columns, courses=courses
    )


def means(made: RunResult) -> np.ndarray:
    """Mean stress of each block that deforms, one after another, shape (blocks, 6) [Pa]."""
    told = []
    for group, state in zip(made.built.model.groups, made.march.state.bodies, strict=True):
        if group.deforms:
            field = group.stress(state)
            told.append(np.einsum("bmpi,mp->bi", field.gauss, field.weight / field.weight.sum()))
    return np.concatenate(told)


def apart(made: RunResult, exact: RunResult) -> float:
    """Distance of the mean stresses of two runs over their size."""
    shear = np.array([1, 1, 1, 2, 2, 2])
    difference, size = (np.sqrt((shear * a**2).sum()) for a in (means(made) - means(exact), means(exact)))
    return float(difference / size)


@pytest.mark.parametrize(("degree", "bound"), [(1, 0.03), (2, 0.02)])
def test_mean_stresses_of_a_wall_are_nearly_elastic(degree, bound):
    mesh = MeshSettings(divisions=(4, 2, 2))
    exact = solve_scene(scene(wall(6, 6), "elastic", mesh=mesh))
    made = solve_scene(scene(wall(6, 6), "reduced", degree, mesh=mesh))
    assert made.outcome == exact.outcome == "equilibrium"
    assert 0 < apart(made, exact) < bound


def test_mean_stresses_of_an_arch_are_nearly_elastic():
    arch = ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.2, voussoirs=11, depth=0.3)
    mesh = MeshSettings(divisions=(2, 2, 4))
    exact = solve_scene(scene(arch, "elastic", mesh=mesh))
    errors = [apart(solve_scene(scene(arch, "reduced", degree, mesh=mesh)), exact) for degree in (1, 3)]
    assert errors[0] < 0.07
    assert errors[1] < 0.01


def test_what_modes_leave_out_is_told_as_an_error_and_vanishes_in_the_mean():
    """The estimate is not below the true error of the stresses, nor far above that of the modes alone."""
    mesh = MeshSettings(divisions=(4, 2, 2))
    exact = solve_scene(scene(wall(4, 4), "elastic", mesh=mesh))
    for degree in (1, 2):
        made = solve_scene(scene(wall(4, 4), "reduced", degree, mesh=mesh))
        told, true, size = 0.0, 0.0, 0.0
        own = zip(made.built.model.groups, made.march.state.bodies, strict=True)
        others = zip(exact.built.model.groups, exact.march.state.bodies, strict=True)
        pairs = [(*one, *other) for one, other in zip(own, others, strict=True)]
        for group, state, other, there in pairs:
            if not group.deforms:
                continue
            left = group._recovery.gauss_stress(group.left_out(state))
            weight = group._recovery.weight
            assert (
                np.abs(np.einsum("bmpi,mp->bi", left, weight)).max()
                < 1e-9 * np.abs(left).max() * weight.sum()
            )
            apart = group.stress(state).gauss - other.stress(there).gauss
            density = energy_density(apart, group.operators.material)
            true += float(np.einsum("bmp,mp->", density, weight))
            told += float(group.stress_error(state).squares.sum())
            size += float(2 * other.strain_energy(there).sum())
        assert true < told < 2 * size


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_stone_has_as_many_modes_as_there_are_polynomials_and_they_are_orthonormal(dimension):
    d = dimension
    mesh = box_mesh("quad9" if d == 2 else "hexahedron27", (2,) * d, (0.0,) * d, (1.0, 0.4, 0.5)[:d], 0.0)
    (own,) = assemble_shapes([mesh], [ElasticMaterial(YOUNG, POISSON, DENSITY)], "strain" if d == 2 else None)
    rigid = rigid_modes(mesh.points, own.mass, np.arange(mesh.points.size))
    for degree, number in zip((1, 2, 3), NUMBERS[d], strict=True):
        basis = Basis.of(own, rigid, degree)
        count = len(basis.squares)
        assert count == number
        one = basis.modes.T @ (own.mass @ basis.modes)
        assert np.abs(one - np.eye(count)).max() < 1e-12
        stiff = basis.modes.T @ (own.stiffness @ basis.modes)
        assert np.abs(stiff - np.diag(basis.squares)).max() < 1e-12 * basis.squares[-1]
        assert (
            np.abs(rigid.momentum.T @ basis.modes).max() < 1e-12 * np.abs(rigid.modes).max() * own.mass.sum()
        )


def test_frequencies_of_a_free_stone_come_from_above_and_fall_with_the_degree():
    mesh = box_mesh("hexahedron27", (3, 2, 2), (0.0, 0.0, 0.0), (1.0, 0.4, 0.5), 0.0)
    (own,) = assemble_shapes([mesh], [ElasticMaterial(YOUNG, POISSON, DENSITY)], None)
    rigid = rigid_modes(mesh.points, own.mass, np.arange(mesh.points.size))
    mass, stiff = own.mass.toarray(), own.stiffness.toarray()
    root = np.linalg.inv(np.linalg.cholesky(mass))
    exact = np.sqrt(np.linalg.eigvalsh(root @ stiff @ root.T)[6:9])
    found = [np.sqrt(Basis.of(own, rigid, degree).squares[:3]) for degree in (2, 3, 4)]
    for coarse, fine in itertools.pairwise(found):
        assert (coarse >= fine * (1 - 1e-9)).all()
    assert (found[-1] >= exact * (1 - 1e-9)).all()
    assert found[-1] == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_pressed_column_has_its_exact_mean_stresses(dimension):
    """Mean stress of a stone is that of what lies on it and half its own weight, whatever its modes."""
    d = dimension
    column = StackStructure(name="s", material="stone", size=(1.0,) * d, count=4)
    made = solve_scene(scene(column, "reduced", dimension=d, mesh=MeshSettings(divisions=(2,) * d)))
    vertical = means(made)[:, d - 1]
    above = np.array([3.5, 2.5, 1.5, 0.5])
    assert vertical == pytest.approx(-DENSITY * G * above, rel=1e-8)


def test_a_tumbling_stone_keeps_energy_and_momentum():
    stone = StackStructure(name="s", material="stone", size=(1.0, 0.4, 0.5), count=1, ground=False)
    given = scene(
        stone,
        "reduced",
        mesh=MeshSettings(divisions=(2, 1, 1)),
        loads=Loads(),
        initial=(Initial(blocks="s.*", velocity=(1.0, 0.0, 0.5), spin=(3.0, 0.2, 1.0)),),
        analysis=Dynamics(step=1e-2, duration=4.0, theta=0.5),
    )
    made = solve_scene(given)
    (group,) = (group for group in made.built.model.groups if group.deforms)
    state = made.march.state.bodies[made.built.model.groups.index(group)]
    start = made.built.bodies[made.built.model.groups.index(group)]
    turn = group.motion(state)[0][0]
    assert np.trace(turn) < 2.0  # it has turned far
    energy = group.kinetic_energy(state) + group.strain_energy(state)
    assert energy == pytest.approx(group.kinetic_energy(start), rel=1e-4)
    before, after = group._momentum(start), group._momentum(state)
    assert after == pytest.approx(before, rel=1e-9, abs=1e-9 * np.abs(before).max())


def test_the_energy_of_a_march_is_told_to_rounding():
    given = scene(
        wall(3, 3),
        "reduced",
        mesh=MeshSettings(divisions=(2, 1, 1)),
        analysis=Dynamics(step=1e-3, duration=2e-2, theta=1.0),
    )
    energies = solve_scene(given).summary.energy
    assert abs(energies.error) < 1e-8 * energies.external_work


def test_reduced_stones_stand_beside_rigid_and_elastic_ones():
    overrides = (
        Override(blocks="wall.c1.*", fidelity="rigid"),
        Override(blocks="wall.c3.*", fidelity="elastic"),
    )
    mesh = MeshSettings(divisions=(4, 2, 2))
    made = solve_scene(scene(wall(4, 4), "reduced", mesh=mesh, overrides=overrides))
    assert made.outcome == "equilibrium"
    assert made.summary.certificate.natural_map < 1e-9


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("analysis", [Statics(), Dynamics(step=1e-3, duration=3e-3, theta=1.0)])
def test_modes_as_velocities_give_the_same_as_their_compliance(monkeypatch, analysis, degree):
    given = scene(wall(4, 4), "reduced", degree, mesh=MeshSettings(divisions=(4, 2, 2)), analysis=analysis)
    monkeypatch.setattr(modal, "CONTACTS", 1)
    velocities = solve_scene(given)
    monkeypatch.setattr(modal, "CONTACTS", 10**9)
    compliance = solve_scene(given)
    assert apart(velocities, compliance) < 1e-7


def test_many_stones_in_statics_are_solved_as_many_elastic_ones_are():
    """Newton's method searches along its steps and lets parts settle: full steps took 76."""
    mesh, loads = MeshSettings(divisions=(1, 1, 1)), Loads(gravity=(0.2 * G, 0.0, -G))
    told = solve_scene(scene(wall(20, 20), "reduced", mesh=mesh, loads=loads)).summary
    assert told.outcome == "equilibrium"
    assert (told.solver.method, told.solver.iterations < 30) == ("newton", True)


def test_a_factor_serves_until_contacts_change(monkeypatch):
    """With fewer factors than Newton steps the same state is reached."""
    monkeypatch.setattr(modal, "CONTACTS", 1)
    made, factors = [], []
    bare = Mumps.hold

    def counted(self, matrix):
        factors[-1] += self._held is not matrix
        bare(self, matrix)

    monkeypatch.setattr(Mumps, "hold", counted)
    analysis = Dynamics(step=1e-2, duration=6e-2, theta=1.0)
    given = scene(wall(5, 5), "reduced", mesh=MeshSettings(divisions=(2, 1, 1)), analysis=analysis)
    for share in (modal_system.SLOPE, 0.0):
        monkeypatch.setattr(modal_system, "SLOPE", share)
        factors.append(0)
        made.append(solve_scene(given))
        assert made[-1].summary.certificate.natural_map < 1e-10
    assert factors[0] < 0.9 * factors[1]
    assert apart(*made) < 1e-8


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_faces_of_few_modes_have_contacts_at_corners_and_centroid(degree):
    """Others have them at all nodes, nine and more; so have faces that an elastic stone touches."""
    overrides = (
        Override(blocks="wall.c2.*", fidelity="elastic"),
        Override(blocks="wall.c3.*", fidelity="rigid"),
    )
    mesh = MeshSettings(divisions=(4, 2, 2))
    model = build(scene(wall(2, 4), "reduced", degree, mesh=mesh, overrides=overrides), Path()).model
    course = [name.split(".")[1] if "." in name else "ground" for name in model.assembly.blocks.names]
    found: dict[frozenset[str], set[int]] = {}
    for number, count in enumerate(np.bincount(model.contacts.interface).tolist()):
        first, second = model.interfaces.blocks[number]
        found.setdefault(frozenset({course[first], course[second]}), set()).add(count)
    for few in ({"c1"}, {"c1", "ground"}, {"c3", "c4"}, {"c4"}):
        assert (found[frozenset(few)] == {5}) is (degree < 3)
    for many in ({"c1", "c2"}, {"c2"}, {"c2", "c3"}):
        assert min(found[frozenset(many)]) >= 9
    assert found[frozenset({"c3"})] == {4}


def test_rigid_stones_on_mortar_give_way_while_a_reduced_stone_falls():
    """No contact has a stone that deforms: mortar alone gives way, as beside a rigid one that falls."""
    size, keys = (0.5, 0.5, 0.5), {"material": "stone", "fidelity": "rigid"}
    tower = StackStructure(name="tower", size=size, count=2, **keys)
    made = []
    for fidelity in ("reduced", "rigid"):
        above = BlockStructure(
            name="above", material="stone", fidelity=fidelity, size=size, position=(0.0, 0.0, 2.0)
        )
        given = scene(
            (tower, above),
            "rigid",
            joints=(Joint(mortar=Mortar(normal_stiffness=1e8, tangential_stiffness=5e7)),),
            analysis=Dynamics(step=5e-3, duration=5e-2, theta=1.0),
            contact=Contact(update="fixed"),
        )
        made.append(solve_scene(given).march.state.gap)
    assert made[0].min() < -1e-4
    assert made[0] == pytest.approx(made[1], rel=1e-9)


def test_a_held_face_is_refused():
    given = scene(wall(3, 2), "reduced", supports=(Support(on="wall.c2.*/right"),))
    with pytest.raises(MasonryError, match="reduced and a support holds its face 'right'"):
        solve_scene(given)

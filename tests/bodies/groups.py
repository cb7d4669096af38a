"""Body groups that the conformance tests run over: one factory a kind and dimension.

Fidelities of stones that keep their shape join by themselves; those that deform are in ``tests/fem``.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from masonry_fem.bodies.base import BodyGroup, Sides
from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.bodies.rotation import exponential
from masonry_fem.build.material_law import material_law
from masonry_fem.fidelities import Given, deforms, fidelities, fidelity
from masonry_fem.scene.specs import Material, material_record
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose

DENSITY = 2400.0
# strong enough that nothing yields in a step from rest that is elastic
LAW = material_record("drucker_prager", cohesion=1e9, friction_angle=30.0)
STONE = Material(density=DENSITY, young=1e7, poisson=0.2, inelastic=LAW)


def bricks(dimension: int) -> Assembly:
    """Two bricks and a slab, turned in space, so that no axis of theirs is one of the world's."""
    low, high = (0.0, 0.0, 0.0), (0.5, 0.2, 0.3)
    brick = Shape("brick", Polytope.box(low[:dimension], high[:dimension]))
    slab = Shape("slab", Polytope.box((-1.0, -0.2, -0.1)[:dimension], (1.0, 0.0, 0.4)[:dimension]))
    turns = np.array([[0.0, 0.0, 0.0], [0.3, -0.5, 0.8], [-0.2, 0.9, 0.1]])
    turns = turns if dimension == 3 else turns[:, 2:]
    shifts = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, -0.5], [-3.0, 0.4, 1.0]])[:, :dimension]
    poses = [Pose(exponential(turn), shift) for turn, shift in zip(turns, shifts, strict=True)]
    blocks = tuple(Block(f"b{i}", (0, 0, 1)[i], pose) for i, pose in enumerate(poses))
    return Assembly(dimension, (brick, slab), blocks)


def made(
    name: str, assembly: Assembly, material: Material = STONE, *, lumped: bool = False, turns: bool = True
) -> BodyGroup:
    """What a fidelity makes of all blocks."""
    materials = dict.fromkeys(range(len(assembly.blocks)), material)
    (group,) = fidelity(name).groups(
        Given(assembly, materials, {}, "strain", lumped, turns, lambda stone: material_law(stone, Path()))
    )
    return group


def damped_rigid(assembly: Assembly) -> BodyGroup:
    return RigidGroup(assembly, range(len(assembly.blocks)), DENSITY, damping=np.array([0.5, 0.0, 2.0]))


def damped_spins(assembly: Assembly) -> BodyGroup:
    d = assembly.dimension
    damping = np.zeros((len(assembly.blocks), 3 * d - 3))
    damping[:, d:] = [[0.5], [0.0], [2.0]]
    return RigidGroup(assembly, range(len(assembly.blocks)), DENSITY, damping)


FREE_GROUPS: dict[str, Callable[[Assembly], BodyGroup]] = {
    **{name: partial(made, name) for name in fidelities() if not deforms(name)},
    "damped rigid": damped_rigid,
    "damped spins": damped_spins,
}


def sides_of(group: BodyGroup, assembly: Assembly, per_block: int = 4) -> Sides:
    """Contact sides at random points of faces, with random frames."""
    random, d = np.random.default_rng(7), assembly.dimension
    body, point = [], []
    for row, block in enumerate(group.blocks):
        solid = assembly.solid(int(block))
        for face in random.integers(len(solid.faces), size=per_block):
            corners = solid.face_points(int(face))
            point.append(random.dirichlet(np.ones(len(corners))) @ corners)
            body.append(row)
    count = len(body)
    vectors = random.uniform(-2, 2, (count, 1 if d == 2 else 3))
    return Sides(
        contact=np.arange(count),
        side=np.zeros(count, dtype=np.int64),
        body=np.array(body),
        point=np.array(point),
        facet=np.full(count, -1),
        frame=exponential(vectors),
    )

"""Contact sides of elastic blocks: G, its transpose, B = G Φ, and W_el shared by blocks that are alike."""

import numpy as np
import pytest
from scipy.linalg import block_diag

from masonry_fem.bodies.base import Scheme, Sides
from masonry_fem.bodies.rotation import exponential
from masonry_fem.fem.groups import elastic_groups
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import Pose
from tests.fem.meshes import box, box_mesh

STONE = ElasticMaterial(10e9, 0.2, 2400.0)
HIGH = (0.5, 0.25, 0.2)
# on the faces bottom and right, none at a node
LOCAL = np.array(
    [[0.11, 0.07, 0.0], [0.37, 0.21, 0.0], [0.29, 0.03, 0.0], [0.5, 0.13, 0.17], [0.5, 0.2, 0.04]]
)
SCHEMES = [Scheme(1e-3, 0.5), Scheme(2.0, 1.0), Scheme(1.0, 1.0, 0.0)]


@pytest.fixture(scope="module", params=["hexahedron", "tetra", "hexahedron27", "tetra10"])
def made(request):
    """Blocks 0 and 1 apart, 2 turned with its contacts, 3 touched elsewhere, 4 not at all."""
    poses = [Pose.at(0.1, 0.2, 0.3), Pose.at(7.7, -3.3, 1.1),
             Pose(exponential(np.array([0.3, -1.2, 0.7])), np.array([3.0, 2.0, 1.0])),
             Pose.at(0.0, 5.0, 0.0), Pose.at(0.0, 9.0, 0.0)]  # fmt: skip
    mesh = box_mesh(request.param, (3, 2, 2), (0.0, 0.0, 0.0), HIGH)
    shape = Shape("brick", box((0.0, 0.0, 0.0), HIGH), mesh)
    assembly = Assembly(3, (shape,), tuple(Block(f"b{i}", 0, pose) for i, pose in enumerate(poses)))
    (group,) = elastic_groups(assembly, dict.fromkeys(range(5), STONE))
    frame = exponential(
        np.array([[0.1, 0.2, 0.3], [1.0, 0.0, 0.5], [0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0, 1, 0]])
    )
    points, frames = [], []
    for body in range(4):
        own = LOCAL if body < 3 else LOCAL * [1.0, 0.9, 1.0]
        points.append(poses[body].to_world(own))
        frames.append(frame @ poses[body].rotation.T)
    count = 4 * len(LOCAL)
    shuffle = np.random.default_rng(0).permutation(count).reshape(4, -1)
    shuffle = np.argsort(np.sort(shuffle, axis=1).ravel())  # bodies mixed, order within each kept
    body = np.repeat(np.arange(4), len(LOCAL))
    sides = Sides(np.arange(count), np.zeros(count, int), body[shuffle], np.concatenate(points)[shuffle],
                  np.full(count, -1), np.concatenate(frames)[shuffle])  # fmt: skip
    return group, sides, group.attach(sides)


def test_spread_is_the_transpose_of_the_velocity(made):
    group, sides, attachment = made
    random = np.random.default_rng(1)
    impulses, field = random.normal(size=sides.point.shape), random.normal(size=group.no_force().shape)
    work = (attachment.elastic_velocity(field, sides.frame) * impulses).sum()
    nodal = attachment.spread(impulses, sides.frame)
    assert (nodal * field).sum() == pytest.approx(work, rel=1e-12)
    assert not nodal[4].any()


def test_rigid_map_is_the_velocity_of_the_modes(made):
    group, sides, attachment = made
    amplitudes = np.random.default_rng(2).normal(size=(5, 6))
    field = amplitudes @ group.modes.modes.T
    rigid = attachment.rigid_map(group.rest(), sides.point, sides.frame)
    velocity = np.einsum("kdm,km->kd", rigid, amplitudes[sides.body])
    np.testing.assert_allclose(velocity, attachment.elastic_velocity(field, sides.frame), atol=1e-13)


def test_points_follow_linear_fields_exactly(made):
    """Interpolation on facets, found by the point alone: x ↦ A x at the points."""
    group, sides, attachment = made
    A = np.random.default_rng(3).normal(size=(3, 3))
    field = np.tile((group.mesh.points @ A.T).ravel(), (5, 1))
    local = group.to_shape(sides.body, sides.point)
    expected = np.einsum("kij,kj->ki", sides.frame @ group.rotation[sides.body], local @ A.T)
    np.testing.assert_allclose(attachment.elastic_velocity(field, sides.frame), expected, atol=1e-12)


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_compliance_is_that_of_the_whole_block(made, scheme):
    group, sides, attachment = made
    n = group.mesh.points.size
    whole = group.factor(scheme).block(np.arange(n))
    answers = dict(zip(attachment.bodies.tolist(), attachment.compliance(scheme, sides.frame), strict=True))
    assert list(answers) == [0, 1, 2, 3]
    for body, (rows, matrix) in answers.items():
        assert (sides.body[rows] == body).all()
        G = np.empty((len(rows) * 3, n))
        for dof in range(n):
            field = np.zeros((5, n))
            field[body, dof] = 1.0
            G[:, dof] = attachment.elastic_velocity(field, sides.frame)[rows].ravel()
        expected = G @ whole @ G.T
        np.testing.assert_allclose(matrix, expected, atol=1e-10 * np.abs(expected).max())
        assert np.linalg.eigvalsh(matrix).min() >= -1e-12 * np.abs(matrix).max()
    assert answers[0][1] is answers[1][1]
    assert answers[0][1] is answers[2][1]
    assert answers[3][1] is not answers[0][1]


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_kinds_share_what_the_compliance_is_made_of(made, scheme):
    """Whatever frames the contacts have: here those of block 1 are turned, and its matrix stays that of 0."""
    _, sides, attachment = made
    frame = sides.frame.copy()
    frame[sides.body == 1] = exponential(np.array([0.2, 0.1, 0.7])) @ frame[sides.body == 1]
    kinds = attachment.kinds(scheme, frame)
    assert [len(rows) for rows, _, _ in kinds] == [3, 1]
    found = {
        tuple(own.tolist()): _turned(turn, matrix)
        for rows, turns, matrix in kinds
        for own, turn in zip(rows, turns, strict=True)
    }
    for rows, expected in attachment.compliance(scheme, frame):
        matrix = found.pop(tuple(rows.tolist()))
        np.testing.assert_allclose(matrix, expected, atol=1e-12 * np.abs(expected).max())
    assert not found


def _turned(turn, matrix):
    T = block_diag(*turn)
    return T @ matrix @ T.T


def test_a_group_without_contacts_has_no_compliance():
    mesh = box_mesh("quad", (2, 1), (0.0, 0.0), (1.0, 0.5))
    assembly = Assembly(
        2, (Shape("s", box((0.0, 0.0), (1.0, 0.5)), mesh),), (Block("b", 0, Pose.identity(2)),)
    )
    (group,) = elastic_groups(assembly, {0: STONE})
    nothing = np.zeros(0, dtype=np.int64)
    attachment = group.attach(
        Sides(nothing, nothing, nothing, np.zeros((0, 2)), nothing, np.zeros((0, 2, 2)))
    )
    assert not attachment.compliance(SCHEMES[0], np.zeros((0, 2, 2)))
    assert not attachment.spread(np.zeros((0, 2)), np.zeros((0, 2, 2))).any()
    assert attachment.displacements(group.rest()).shape == (0, 2)

"""Walls, arches and structured meshes for the contact tests."""

import numpy as np

from masonry_fem.importing.outline import outline
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.mesh import Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose

# VTK order on a 3-per-direction grid
_HEXAHEDRON27 = [
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1), (0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1),
    (1, 1, 0), (1, 1, 2), (1, 1, 1),
]  # fmt: skip
_HEXAHEDRON = _HEXAHEDRON27[:8]
_QUAD9 = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]


def turning(angle, axis=(0.3, -0.5, 0.8)):
    """Rotation matrix about an axis by an angle."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def turning_2d(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def moved(assembly, rotation, translation):
    """The whole assembly after a rigid motion."""
    blocks = tuple(
        Block(
            block.name,
            block.shape,
            Pose(rotation @ block.pose.rotation, rotation @ block.pose.translation + translation),
            block.groups,
            block.support,
        )
        for block in assembly.blocks
    )
    return Assembly(assembly.dimension, assembly.shapes, blocks)


def grid_mesh(low, high, cells, *, order=1, warp=None):
    """Structured quadrilaterals or hexahedra of a box whose faces are those of Polytope.box."""
    low, high, cells = np.array(low, float), np.array(high, float), np.array(cells)
    d, fine = len(cells), 2 if order == 2 else 1
    counts = cells * fine + 1
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, d)
    strides = np.array([int(np.prod(counts[k + 1 :])) for k in range(d)])
    corner = np.stack(np.meshgrid(*[np.arange(n) * fine for n in cells], indexing="ij"), axis=-1).reshape(
        -1, d
    )

    def numbers(offsets, at):
        steps = np.array(offsets) // (1 if order == 2 else 2)
        return ((at[:, None] + steps) * np.array(strides)).sum(axis=2)

    full = (_QUAD9 if d == 2 else _HEXAHEDRON27) if order == 2 else (_QUAD9[:4] if d == 2 else _HEXAHEDRON)
    kind = {(2, 1): "quad", (2, 2): "quad9", (3, 1): "hexahedron", (3, 2): "hexahedron27"}[d, order]
    facets, face = [], []
    for axis in range(d):
        for end in (0, 1):
            at = corner[corner[:, axis] == end * (counts[axis] - 1 - fine)]
            offsets = _side(d, axis, end, order)
            facets.append(numbers(offsets, at))
            face.append(np.full(len(at), 2 * axis + end))
    mesh = Mesh(points, kind, numbers(full, corner), np.concatenate(facets), np.concatenate(face))
    if warp is not None:
        mesh.points[:] = warp(mesh.points)
    return mesh


def _side(d, axis, end, order):
    """Nodes of one side of a cell, outward order, as offsets on the 3-per-direction grid."""
    if d == 2:
        # the solid lies on the left: right goes up, left down, bottom right, top left
        forward = (axis == 0) == (end == 1)
        path = [0, 2] if forward else [2, 0]
        nodes = [[2 * end if k == axis else t for k in range(2)] for t in (*path, 1)]
        return nodes if order == 2 else nodes[:2]
    flat = _QUAD9 if order == 2 else _QUAD9[:4]
    u, v = (axis + 1) % 3, (axis + 2) % 3
    nodes = []
    for p, q in flat:
        offset = [0, 0, 0]
        offset[axis] = 2 * end
        offset[u], offset[v] = (p, q) if end == 1 else (q, p)
        nodes.append(offset)
    return nodes


def split_in_triangles(mesh):
    """A mesh of hexahedra's boundary cut in triangles (the cells are of no use to contact)."""
    pieces = np.concatenate([mesh.facets[:, [0, 1, 2]], mesh.facets[:, [0, 2, 3]]])
    return Mesh(mesh.points, "tetra", np.zeros((0, 4), dtype=int), pieces, np.tile(mesh.facet_face, 2))


def box_shape(name, size, cells=None, low=None, **how):
    """A box, meshed where ``cells`` is given."""
    low = (0.0,) * len(size) if low is None else low
    high = tuple(np.add(low, size))
    mesh = None if cells is None else grid_mesh(low, high, cells, **how)
    return Shape(name, Polytope.box(low, high), mesh)


def wall(columns, courses, dimension=3, *, cells=None, floor=True):
    """Running bond of 0.5 × 0.25 × 0.25 m bricks with half bricks, on a floor."""
    length, depth, rise = 0.5, 0.25, 0.25

    def size(x):
        return (x, depth, rise) if dimension == 3 else (x, rise)

    half_cells = None if cells is None else (cells[0] // 2, *cells[1:])
    total = columns * length
    ground = (
        Polytope.box((-0.1, -0.1, -0.5), (total + 0.1, depth + 0.1, 0.0))
        if dimension == 3
        else Polytope.box((-0.1, -0.5), (total + 0.1, 0.0))
    )
    shapes = (
        box_shape("brick", size(length), cells),
        box_shape("half", size(length / 2), half_cells),
        Shape("floor", ground),
    )
    blocks = [Block("floor", 2, Pose.identity(dimension), support=True)] if floor else []
    for course in range(courses):
        lengths = (
            [length] * columns if course % 2 == 0 else [length / 2, *[length] * (columns - 1), length / 2]
        )
        x = 0.0
        for number, own in enumerate(lengths):
            at = (x, 0.0, course * rise) if dimension == 3 else (x, course * rise)
            blocks.append(Block(f"c{course}.b{number}", 0 if own == length else 1, Pose.at(*at)))
            x += own
    return Assembly(dimension, shapes, tuple(blocks))


def arch(voussoirs, dimension, *, radius=1.0, thickness=0.2, depth=0.3):
    """Semicircular arch of straight-sided voussoirs, all of one shape."""
    half = np.pi / voussoirs / 2
    outline = [
        (r * np.sin(angle), r * np.cos(angle))
        for r, angle in (
            (radius, -half),
            (radius, half),
            (radius + thickness, half),
            (radius + thickness, -half),
        )
    ]
    # clockwise angles from the crown: reverse for a counter-clockwise outline
    if dimension == 2:
        solid = Polytope(
            np.array(outline), ((0, 1), (1, 2), (2, 3), (3, 0)), (), ("", "radial", "", "radial")
        )
    else:
        vertices = np.array([(x, y, z) for y in (0.0, depth) for x, z in outline])
        loops = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
        solid = Polytope(vertices, loops, (), ("", "", "", "radial", "", "radial"))
    blocks = []
    for number in range(voussoirs):
        angle = np.pi / 2 - (2 * number + 1) * half
        rotation = turning_2d(angle) if dimension == 2 else turning(-angle, (0.0, 1.0, 0.0))
        blocks.append(Block(f"v{number}", 0, Pose(rotation, np.zeros(dimension))))
    return Assembly(dimension, (Shape("voussoir", solid),), tuple(blocks))


def pair(lower, upper, gap=0.0, shift=(0.0, 0.0)):
    """Two shapes, the upper one ``gap`` above the lower one's top at height zero."""
    d = lower.solid.dimension
    return Assembly(
        d,
        (lower, upper),
        (Block("lower", 0, Pose.identity(d)), Block("upper", 1, Pose.at(*shift[: d - 1], gap))),
    )


def ring_shape(name, radii, cells, *, angle=np.pi / 2, width=1.0, order=1, triangles=False):
    """A sector of a ring in straight facets, from the upright on; in 3D ``width`` long.

    ``cells`` along the arc, in 3D along the width, and across. Corners of the facets are on the circles.
    """
    d = len(cells)
    low, high = (0.0, *(0.0,) * (d - 2), radii[0]), (angle, *(width,) * (d - 2), radii[1])

    def bent(points):
        x, z = points[:, 0], points[:, -1]
        return np.stack([z * np.sin(x), *points[:, 1:-1].T, z * np.cos(x)], axis=1)

    mesh = grid_mesh(low, high, cells, order=order, warp=bent)
    if triangles:
        mesh = split_in_triangles(mesh)
    names = [f"side{face}" for face in mesh.facet_face]
    solid, face = outline(mesh.points, mesh.cell, mesh.facets, names, "")
    return Shape(name, solid, Mesh(mesh.points, mesh.cell, mesh.cells, mesh.facets, face))


def rings(inner, outer, *, radii=(0.8, 1.0, 1.2), shift=(), **how):
    """Two sectors of rings, one in the other."""
    shapes = (
        ring_shape("inner", radii[:2], inner, **how),
        ring_shape("outer", radii[1:], outer, **how),
    )
    d = len(inner)
    at = Pose.at(*shift) if shift else Pose.identity(d)
    return Assembly(d, shapes, (Block("inner", 0, Pose.identity(d)), Block("outer", 1, at)))

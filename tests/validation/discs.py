"""Bodies with round faces for the contact tests: Gmsh geometries of half discs and of a ball's octant.

Their arcs and spheres become facets as fine as the mesh.
"""

from __future__ import annotations

import numpy as np

RADIUS = 0.1
MODULUS = 10e9 / (1 - 0.2**2)  # E/(1 − ν²) of the stone in tests.validation.scenes


def line_contact(force: float) -> tuple[float, float]:
    """Half width [m] and peak pressure [Pa] of a cylinder pressed on a rigid plane by a force [N/m]."""
    half_width = np.sqrt(4 * force * RADIUS / np.pi / MODULUS)
    return half_width, 2 * force / np.pi / half_width


def point_contact(force: float) -> tuple[float, float, float]:
    """Radius [m], peak pressure [Pa] and approach [m] of a ball pressed on a rigid plane by a force [N]."""
    radius = (3 * force * RADIUS / 4 / MODULUS) ** (1 / 3)
    return radius, 1.5 * force / np.pi / radius**2, radius**2 / RADIUS


def half_discs(
    names: tuple[str, ...],
    half_width: float,
    per_half_width: int | tuple[int, ...],
    fine: float,
    halves: tuple[int, ...] = (-1, 1),
) -> str:
    """Half discs that touch at the origin: the first stands on it, the second hangs below.

    Each is named as given, its round side ``<name>_arc``, its flat side ``<name>_flat`` and, where only
    the right half is kept, the cut ``<name>_cut``. Elements are ``half_width / per_half_width`` long over
    ``fine`` half widths of the arc; a number for all, or one for each.
    """
    reach = fine * half_width
    angle = np.arcsin(reach / RADIUS)
    elements = (per_half_width,) * len(names) if isinstance(per_half_width, int) else per_half_width
    lines, faces = [], []
    for number, (name, per) in enumerate(zip(names, elements, strict=True)):
        size, count = half_width / per, int(np.ceil(fine * per)) + 1
        up, base = 1 - 2 * number, 100 * (number + 1)
        places = {
            1: (0.0, 0.0, size),
            2: (0.0, up * 2.5 * half_width, 1.5 * size),
            3: (0.0, up * RADIUS, RADIUS / 8),
        }
        for side in halves:
            own = 5 if side > 0 else 7
            places[own] = (side * reach, up * RADIUS * (1 - np.cos(angle)), size)
            places[own + 1] = (side * RADIUS, up * RADIUS, RADIUS / 8)
        lines += [f"Point({base + k}) = {{{x}, {y}, 0, {h}}};" for k, (x, y, h) in places.items()]
        lines.append(f"Line({base + 1}) = {{{base + 1}, {base + 2}}};")
        lines.append(f"Line({base + 2}) = {{{base + 2}, {base + 3}}};")
        surfaces, arcs, flats = [], [], []
        for side in halves:
            own = 5 if side > 0 else 7
            curve = base + 10 * own
            lines.append(f"Circle({curve}) = {{{base + 1}, {base + 3}, {base + own}}};")
            lines.append(f"Circle({curve + 1}) = {{{base + own}, {base + 3}, {base + own + 1}}};")
            lines.append(f"Line({curve + 2}) = {{{base + own + 1}, {base + 3}}};")
            lines.append(f"Transfinite Curve{{{curve}}} = {count};")
            loop = [curve, curve + 1, curve + 2, -base - 2, -base - 1]
            if side * up < 0:  # counter-clockwise
                loop = [-tag for tag in reversed(loop)]
            lines.append(f"Curve Loop({curve}) = {{{_listed(loop)}}}; Plane Surface({curve}) = {{{curve}}};")
            surfaces.append(curve)
            arcs += [curve, curve + 1]
            flats.append(curve + 2)
        cut = [base + 1, base + 2] if len(halves) == 1 else []
        faces.append(f'Physical Surface("{name}") = {{{_listed(surfaces)}}};')
        for kind, curves in (("arc", arcs), ("flat", flats), ("cut", cut)):
            if curves:
                faces.append(f'Physical Curve("{name}_{kind}") = {{{_listed(curves)}}};')
    return "\n".join([*lines, *faces]) + "\n"


def foundation(half_width: float, per_half_width: int, fine: float) -> str:
    """The right half of a block below the origin, as wide and as deep as the discs' radius, of such elements.

    It is named ``ground``, its upper side ``ground_top``, the lower ``ground_base``, the cut ``ground_cut``.
    """
    size, r, reach = half_width / per_half_width, RADIUS, fine * half_width
    coarse = r / 8
    return f"""Point(901) = {{0, 0, 0, {size}}}; Point(902) = {{{reach}, 0, 0, {size}}};
Point(903) = {{{r}, 0, 0, {coarse}}}; Point(904) = {{{r}, {-r}, 0, {coarse}}};
Point(905) = {{0, {-r}, 0, {coarse}}}; Point(906) = {{0, {-2.5 * half_width}, 0, {1.5 * size}}};
Line(901) = {{901, 902}}; Line(902) = {{902, 903}}; Line(903) = {{903, 904}}; Line(904) = {{904, 905}};
Line(905) = {{905, 906}}; Line(906) = {{906, 901}};
Transfinite Curve{{901}} = {int(np.ceil(fine * per_half_width)) + 1};
Curve Loop(901) = {{-906, -905, -904, -903, -902, -901}}; Plane Surface(901) = {{901}};
Physical Surface("ground") = {{901}};
Physical Curve("ground_top") = {{901, 902}};
Physical Curve("ground_base") = {{904}};
Physical Curve("ground_cut") = {{905, 906}};
"""


def _listed(tags: list[int]) -> str:
    return ", ".join(map(str, tags))


def ball_octant(radius: float, per_radius: int) -> str:
    """The part x > 0, y > 0 of the lower half of a ball that stands on the origin; cuts ``cut_x``, ``cut_y``.

    Elements are ``radius / per_radius`` long in and near a contact of that radius.
    """
    r, e = RADIUS, 1e-6
    return f"""SetFactory("OpenCASCADE");
Sphere(1) = {{0, 0, {r}, {r}, -Pi/2, 0, Pi/2}};
Physical Volume("ball") = {{1}};
top() = Surface In BoundingBox{{-{e}, -{e}, {r - e}, {r + e}, {r + e}, {r + e}}};
x() = Surface In BoundingBox{{-{e}, -{e}, -{e}, {e}, {r + e}, {r + e}}};
y() = Surface In BoundingBox{{-{e}, -{e}, -{e}, {r + e}, {e}, {r + e}}};
Physical Surface("ball_flat") = {{top()}};
Physical Surface("cut_x") = {{x()}};
Physical Surface("cut_y") = {{y()}};
Field[1] = MathEval;
Field[1].F = "{radius / per_radius} + 0.2 * Max(0, Sqrt(x*x + y*y + z*z) - {1.3 * radius})";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeMax = {r / 6};
"""

"""Picture: PNG sheets of a structure: deformed shape, von Mises, principal stresses, reactions.

    scenery = Scenery.of(model, state, title="Arch of 11 voussoirs")
    paths = draw_all(scenery, Path("out/pictures"))

Pictures are drawn from the named arrays that the field files hold, so that a results folder can
be drawn again without its model (``view``).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.phases import phase
from masonry_fem.march.state import BONDED, OPEN, SLIP, STICK
from masonry_fem.output import fields
from masonry_fem.output.arrows import add_arrows, interface_resultants, legend_sample, reactions
from masonry_fem.output.backdrop import GHOST, draw_pale, title_of
from masonry_fem.output.joint_map import draw_opening, draw_sliding
from masonry_fem.output.marks import mark_ties
from masonry_fem.output.overview import draw_overview
from masonry_fem.output.principal_picture import COMPRESSION, draw_principal
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import (
    HELD,
    LINE,
    STRESS_COLOURS,
    ColourBar,
    Key,
    Sheet,
    colour_end,
    prefix_of,
    quantity,
)
from masonry_fem.output.stone_pictures import draw_error, draw_measure, draw_utilisation, measures_of
from masonry_fem.output.thrust import draw_thrust

FloatArray = NDArray[np.float64]

STATUS_COLOURS = {OPEN: "#9aa2ab", STICK: "#1b7f5c", SLIP: "#e07b1a", BONDED: "#7a4fa3"}
STATUS_WORDS = {OPEN: "open", STICK: "stick", SLIP: "slip", BONDED: "bonded"}
SEEN = 1e-2  # of the greatest force: arrows that are shorter are not seen
FRICTION = STATUS_COLOURS[SLIP]
DISPLACEMENT_COLOURS = "YlGnBu"
DAMAGE_COLOURS = "inferno_r"


def draw_all(
    scenery: Scenery, directory: Path, amplification: float | None = None,
    only: Collection[str] | None = None,
) -> list[Path]:  # fmt: skip
    """Draw the pictures that the scenery has data for.

    Parameters
    ----------
    scenery : What to draw.
    directory : Folder for the pictures.
    amplification : Of displacements; None to choose one.
    only : Names of the wanted ones, as in ``output.pictures`` of a scene; None for all.

    Returns
    -------
    Paths of the pictures.
    """
    folder = Path(directory)
    drawn = [one for one in _drawers(scenery, amplification) if only is None or _kind(one[0]) in only]
    paths = []
    with phase("pictures", len(drawn)) as at:
        for number, (name, draw) in enumerate(drawn):
            at(number, name)
            paths.append(draw(folder / f"{name}.png"))
    return paths


def drawable(scenery: Scenery) -> list[str]:
    """Names of the pictures that the scenery has data for, as in ``output.pictures`` of a scene."""
    return list(dict.fromkeys(_kind(name) for name, _ in _drawers(scenery, None)))


def _kind(name: str) -> str:
    """What a scene calls a picture: ``stone`` is each ``stone_...``."""
    return "stone" if name.startswith("stone_") else name


def _drawers(scenery: Scenery, amplification: float | None) -> Iterator[tuple[str, Callable[[Path], Path]]]:
    """Names of the pictures that there is data for, and what draws them."""
    magnified = [
        ("deformed", draw_deformed), ("von_mises", draw_von_mises), ("utilisation", draw_utilisation),
        ("overview", draw_overview), ("opening", draw_opening), ("sliding", draw_sliding),
    ]  # fmt: skip
    drawers: dict[str, Callable[[Path], Path]] = {
        name: partial(draw, scenery, amplification=amplification) for name, draw in magnified
    }
    yield "deformed", drawers["deformed"]
    if fields.VON_MISES in scenery.blocks.point_data:
        yield "von_mises", drawers["von_mises"]
        yield "principal_stresses", partial(draw_principal, scenery)
        if fields.UTILISATION in scenery.blocks.point_data:
            yield "utilisation", drawers["utilisation"]
        if fields.STRESS_ERROR in scenery.blocks.cell_data:
            yield "stress_error", partial(draw_error, scenery)
        for measure in measures_of(scenery.blocks):
            draw = partial(draw_measure, scenery, measure, amplification=amplification)
            yield f"stone_{measure}", draw
        if scenery.contacts is not None:
            yield "overview", drawers["overview"]
    if scenery.contacts is not None:
        yield "reactions", partial(draw_reactions, scenery)
        yield "resultants", partial(draw_resultants, scenery)
        if np.isfinite(_adhesion(scenery.contacts)).any():
            yield "damage", partial(draw_damage, scenery)
    if scenery.interfaces is not None:
        yield "thrust", partial(draw_thrust, scenery)
        yield "opening", drawers["opening"]
        yield "sliding", drawers["sliding"]


def draw_deformed(scenery: Scenery, path: Path, amplification: float | None = None) -> Path:
    """Deformed shape coloured by displacement, over the outline of the reference."""
    shape = DeformedShape(scenery, amplification)
    size = np.linalg.norm(shape.surface.point_data[fields.DISPLACEMENT], axis=1)
    factor, prefix = prefix_of(float(size.max(initial=0.0)))
    shape.surface["_size"] = size / factor if shape.moves else 0 * size
    limits = (0.0, max(float(size.max(initial=0.0)) / factor, 1e-12))
    sheet = Sheet(title_of(scenery.title, "deformed shape"), shape.caption())
    if shape.moves:
        sheet.bar = ColourBar(f"displacement [{prefix}m]", DISPLACEMENT_COLOURS, limits)
        sheet.keys.append(Key("undeformed", GHOST, "line", 44))
    stage = Stage(View.of(shape.extent(), scenery.dimension), sheet.image_width, scenery.length)
    stage.surface(shape.deformed(), scalars="_size", cmap=DISPLACEMENT_COLOURS, clim=limits)
    stage.lines(shape.deformed_outline(), LINE, 1.5, rank=1)
    stage.lines(shape.outline, GHOST, 1.3, rank=2)
    mark_ties(stage, sheet, scenery, shape, shape.factor)
    return sheet.save(path, stage)


def draw_von_mises(scenery: Scenery, path: Path, amplification: float | None = None) -> Path:
    """Von Mises stress, smoothed to the nodes, on the deformed shape."""
    shape = DeformedShape(scenery, amplification)
    mises = np.asarray(shape.surface.point_data[fields.VON_MISES])
    top, limit, over = colour_end(mises)
    factor, prefix = prefix_of(limit)
    shape.surface["_mises"] = mises / factor
    limits = (0.0, max(limit / factor, 1e-12))
    sheet = Sheet(
        title_of(scenery.title, "von Mises stress"),
        f"{shape.caption()}; stress smoothed to the nodes, greatest there {quantity(top, 'Pa')}"
        + (f", colours end at {quantity(limit, 'Pa')}" if over else ""),
    )
    sheet.bar = ColourBar(f"von Mises\nat nodes [{prefix}Pa]", STRESS_COLOURS, limits, over)
    if np.isnan(mises).any():
        sheet.keys.append(Key("rigid, no stress", HELD))
    stage = Stage(View.of(shape.extent(), scenery.dimension), sheet.image_width, scenery.length)
    options = {"cmap": STRESS_COLOURS, "clim": limits, "nan_color": HELD, "n_colors": 256}
    stage.surface(shape.deformed(), scalars="_mises", **options)
    stage.lines(shape.deformed_elements(), LINE, 0.9, opacity=0.45)
    stage.lines(shape.deformed_outline(), LINE, 1.6)
    return sheet.save(path, stage)


def draw_reactions(scenery: Scenery, path: Path) -> Path:
    """Reaction of each contact point on the upper block, coloured by status."""
    contacts = scenery.contacts
    force = reactions(contacts)
    status = np.asarray(contacts.point_data[fields.STATUS])
    told = (STICK, SLIP, OPEN) if fields.ADHESION not in contacts.point_data else (STICK, SLIP, BONDED, OPEN)
    counts = ", ".join(f"{int((status == s).sum())} {STATUS_WORDS[s]}" for s in told)
    sheet = Sheet(
        title_of(scenery.title, "contact reactions"),
        f"{len(force)} contact points: {counts}; forces on the upper block; displacements × 1; "
        f"greatest {quantity(_top(force), scenery.force_unit)}",
    )
    parts = [(STATUS_COLOURS[s], status == s) for s in told[:-1]]
    keys = [Key(STATUS_WORDS[s], STATUS_COLOURS[s]) for s in told[:-1]]
    return _draw_arrows(scenery, sheet, path, contacts.points, force, parts, keys)


def draw_resultants(scenery: Scenery, path: Path) -> Path:
    """Resultant of each interface at its centre of pressure, and the friction in it."""
    points, force, friction = interface_resultants(scenery.contacts)
    joints = "the loaded interface" if len(force) == 1 else f"each of {len(force)} loaded interfaces"
    sheet = Sheet(
        title_of(scenery.title, "joint resultants"),
        f"Resultant of {joints} at its centre of pressure, on the upper block; displacements × 1; "
        f"greatest {quantity(_top(force), scenery.force_unit)}",
    )
    arrows, at = np.concatenate([force, friction]), np.concatenate([points, points])
    of_friction = np.repeat([False, True], len(force))
    parts = [(COMPRESSION, ~of_friction), (FRICTION, of_friction)]
    keys = [Key("of it friction", FRICTION)] if _top(friction) > SEEN * _top(force) else []
    return _draw_arrows(scenery, sheet, path, at, arrows, parts, keys, 1.0)


def draw_damage(scenery: Scenery, path: Path) -> Path:
    """Damage 1 − β of the joints at their contact points, dry ones left out."""
    import pyvista as pv  # noqa: PLC0415

    contacts = scenery.contacts
    damage = 1.0 - _adhesion(contacts)
    cohesive = np.isfinite(damage)
    damage = damage[cohesive]
    broken = int((damage >= 1).sum())
    sheet = Sheet(
        title_of(scenery.title, "damage of the joints"),
        f"{len(damage)} contact points: {int((damage <= 0).sum())} intact, {broken} without adhesion; "
        "displacements × 1",
    )
    sheet.bar = ColourBar("damage 1 − β [-]", DAMAGE_COLOURS, (0.0, 1.0))
    shape = DeformedShape(scenery, 1.0)
    area = np.asarray(contacts.point_data[fields.AREA], float)[cohesive]
    reach = 0.12 * float(np.median(np.sqrt(area) if scenery.dimension == 3 else area))
    points = np.asarray(contacts.points, float)[cohesive]
    view = View.of(shape.deformed().points, scenery.dimension)
    rims = [points + side * reach * axis for axis in view.axes[:2] for side in (-1, 1)]
    view = View.of(np.concatenate([shape.deformed().points, *rims]), scenery.dimension)
    stage = Stage(view, sheet.image_width, scenery.length)
    draw_pale(stage, shape.deformed(), shape.deformed_outline())
    radius = max(reach, 2.0 / stage.scale)
    cloud = pv.PolyData(points)
    cloud["damage"] = damage
    ball = pv.Sphere(radius=radius, theta_resolution=16, phi_resolution=12)
    balls = cloud.glyph(geom=ball, scale=False, orient=False)
    stage.surface(balls, scalars="damage", cmap=DAMAGE_COLOURS, clim=(0.0, 1.0))
    return sheet.save(path, stage)


def _adhesion(contacts: Any) -> FloatArray:
    """β of the contact points, NaN where a joint has no cohesion, shape (c,)."""
    if fields.ADHESION not in contacts.point_data:
        return np.full(contacts.n_points, np.nan)
    return np.asarray(contacts.point_data[fields.ADHESION], float)


def _draw_arrows(
    scenery: Scenery, sheet: Sheet, path: Path, points: FloatArray, force: FloatArray,
    parts: list[tuple[str, NDArray[np.bool_]]], keys: list[Key], longest: float = 0.8,
) -> Path:  # fmt: skip
    shape = DeformedShape(scenery, 1.0)
    top = _top(force) or 1.0
    vectors = force * (longest * scenery.length / top)
    extent = np.concatenate([shape.deformed().points, points + vectors])
    stage = Stage(View.of(extent, scenery.dimension), sheet.image_width, scenery.length)
    draw_pale(stage, shape.deformed(), shape.deformed_outline())
    mark_ties(stage, sheet, scenery, shape, 1.0)
    for colour, mask in parts:
        shown = mask & (np.linalg.norm(force, axis=1) > 1e-6 * top)
        add_arrows(stage, points[shown], vectors[shown], colour, fine=len(points) < 500)
    sample, pixels = legend_sample(top, longest * scenery.length * stage.scale)
    sheet.keys += [Key(quantity(sample, scenery.force_unit), parts[0][0], "arrow", pixels), *keys]
    return sheet.save(path, stage)


def _top(force: FloatArray) -> float:
    return float(np.linalg.norm(force, axis=1).max(initial=0.0))

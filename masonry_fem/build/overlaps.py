"""Overlaps at the start: deep ones are refused, small ones are reported in a warning."""

from __future__ import annotations

from masonry_fem.build.stones import Stones
from masonry_fem.contact.depth import overlapping, thickness
from masonry_fem.contact.detection import THROUGH, default_reach
from masonry_fem.errors import SceneError
from masonry_fem.records.remark import first_few, remark

SHOWN = 5  # pairs of blocks that a message names

Overlap = tuple[int, int, float]  # two blocks, and how deep they penetrate each other [m]


def refuse_overlaps(stones: Stones, reach: float | None) -> None:
    """Refuse blocks that overlap by more than the contact's reach; warn of smaller overlaps.

    An overlap of half a block's thickness is refused even with a larger reach, since it is no longer clear
    on which side of the other block the thinner one belongs.

    Parameters
    ----------
    stones : Blocks of the scene.
    reach : Reach of contact [m]; None for the default.

    Raises
    ------
    SceneError : Blocks overlap too deeply.
    """
    found = overlapping(stones.assembly)
    if not found:
        return
    far = default_reach(stones.assembly) if reach is None else reach
    refused = [overlap for overlap in found if overlap[2] > far]
    if refused:
        raise SceneError(
            f"structures: blocks overlap: {_named(stones, refused)}; expected blocks that touch, "
            f"stand apart, or overlap by no more than contact.reach ({far:.3g} m); move or resize them"
        )
    swallowed = [overlap for overlap in found if overlap[2] > THROUGH * _thinner(stones, overlap)]
    if swallowed:
        raise SceneError(
            f"structures: blocks overlap: {_named(stones, swallowed)}, which is half of the thinner one or "
            "more; expected blocks that touch, stand apart, or overlap by less; move or resize them"
        )
    remark(
        "overlap",
        f"blocks overlap by up to {max((depth for _, _, depth in found)):.3g} m, within "
        f"contact.reach: {_named(stones, found)}; they stay where they are, and the overlap "
        "stays too, unless contact.expulsion drives them apart",
    )


def _thinner(stones: Stones, overlap: Overlap) -> float:
    return min(thickness(stones.assembly.solid(block)) for block in overlap[:2])


def _named(stones: Stones, found: list[Overlap]) -> str:
    blocks = stones.assembly.blocks
    pairs = [f"'{blocks[a].name}' and '{blocks[b].name}' by {depth:.3g} m" for a, b, depth in found]
    return first_few(pairs, SHOWN, noun="pairs")

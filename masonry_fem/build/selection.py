"""Selection: the blocks of a scene that a pattern names, all names at once.

select_blocks("wall.c5.*", stones.assembly.blocks, "supports.0.on")     # [40, 41, ...]
matching("wall", blocks)      # a mask: those of which the name or a group matches
"""

from __future__ import annotations

import re
from fnmatch import translate

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.scene.selector import matches, nothing_selected
from masonry_fem.solid.assembly import Blocks

Mask = NDArray[np.bool_]


def matching(pattern: str, blocks: Blocks) -> Mask:
    """Whether a pattern matches the name or a group of each block, shape (b,).

    Parameters
    ----------
    pattern : Shell-style. blocks : All blocks.
    """
    if pattern == "*":
        return np.ones(len(blocks), dtype=bool)
    of_groups = np.array([matches(pattern, groups) for groups in blocks.groupings], dtype=bool)
    match = re.compile(translate(pattern)).match
    found: Mask = of_groups[blocks.grouping] | np.fromiter(map(bool, map(match, blocks.names)), bool)
    return found


def select_blocks(selector: str, blocks: Blocks, what: str) -> list[int]:
    """Numbers of the blocks that a selector names.

    Parameters
    ----------
    selector : Pattern. blocks : All blocks. what : The key that holds the selector, for the message.

    Raises
    ------
    SceneError : Where nothing is selected; it lists the nearest names.
    """
    chosen: list[int] = np.flatnonzero(matching(selector, blocks)).tolist()
    if not chosen:
        names = [name for block in blocks for name in (block.name, *block.groups)]
        raise SceneError(nothing_selected(selector, names, what))
    return chosen

"""glTF with the field that matters most and a suitable amplification; ``view --gltf`` lets both be chosen."""

from __future__ import annotations

from pathlib import Path

from masonry_fem.output.viewing.gltf import write_gltf
from masonry_fem.output.viewing.look import Look, checked_field, suited_factor
from masonry_fem.output.viewing.recorded import Recorded


def write(recorded: Recorded, place: int, path: Path) -> list[Path]:
    """Write a step.

    Parameters
    ----------
    recorded : The steps. place : Which, from 0 on. path : The file.
    """
    blocks = recorded.blocks(place)
    look = Look(checked_field(blocks, None), suited_factor([blocks]))
    return [write_gltf(recorded, place, look, path)]

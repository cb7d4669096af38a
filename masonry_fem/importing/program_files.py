"""Program files: the files that a gmsh program (``.geo``) reads, as far as their names stand in it.

read_by(Path("vault.geo"))          # [Path("sizes.geo"), Path("stone.step")]
"""

from __future__ import annotations

import re
from pathlib import Path

from masonry_fem.importing import PROGRAMS

# texts and comments are taken first, so that a mark within a text begins no comment
PIECES = re.compile(r'"(?:[^"\n]*)"|//[^\n]*|/\*.*?(?:\*/|\Z)', re.DOTALL)
READS = re.compile(r'\b(?:Include|Merge|MergeWithBoundingBox|ShapeFromFile)\s*\(?\s*"([^"\n]+)"')


def read_by(path: Path) -> list[Path]:
    """Files that a program includes or merges, and those that these do; names that it computes are not found.

    Parameters
    ----------
    path : The program. A relative name is relative to the folder of the program in which it stands.
    """
    found: dict[Path, None] = {}
    _follow(path, found)
    return list(found)


def _follow(path: Path, found: dict[Path, None]) -> None:
    text = PIECES.sub(
        lambda piece: piece[0] if piece[0][0] == '"' else " ",
        path.read_text(encoding="utf-8", errors="replace"),
    )
    for name in READS.findall(text):
        other = path.parent / name
        try:
            known = not other.is_file() or other.resolve() in found
        except (OSError, ValueError):  # too long, or with a null character
            continue
        if known:
            continue
        found[other.resolve()] = None
        if other.suffix.lower() in PROGRAMS or not other.suffix:
            _follow(other, found)

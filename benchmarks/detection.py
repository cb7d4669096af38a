"""Detection: time to find and place the contacts of walls and piles of more and more blocks.

python -m benchmarks.detection            # all sizes, and the table of docs/detection.md on the screen
python -m benchmarks.detection --quick    # up to 4 000 blocks
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from masonry_fem.contact.contacts import Interface
from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures import build_structure
from masonry_fem.structures.wall import WallStructure

SIZES = (1_000, 2_000, 4_000, 10_000, 20_000, 40_000)
QUICK = 4_000
COLUMNS = (
    "structure",
    "blocks",
    "interfaces",
    "contacts",
    "overlaps [s]",
    "detect [s]",
    "place [s]",
    "growth",
)


@dataclass(frozen=True, slots=True)
class Timing:
    """CPU seconds of the phases for one structure."""

    blocks: int
    interfaces: int
    contacts: int
    overlaps: float
    detect: float
    place: float


def wall(count: int) -> Assembly:
    """A running-bond wall of about that many bricks of 0.4 × 0.2 × 0.2 m, four times as long as high."""
    courses = max(1, round(np.sqrt(count / 2)))
    spec = WallStructure(
        name="wall",
        material="stone",
        brick=(0.4, 0.2, 0.2),
        columns=max(1, count // courses),
        courses=courses,
    )
    return build_structure(spec, 3, Path(), MeshSettings())


def turned(assembly: Assembly) -> Assembly:
    """All of it turned about a skew axis: no face is along an axis of the world."""
    axis, angle = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8]), 0.7
    cross = np.cross(np.eye(3), axis)
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    blocks = tuple(
        replace(block, pose=Pose(rotation @ block.pose.rotation, rotation @ block.pose.translation))
        for block in assembly.blocks
    )
    return replace(assembly, blocks=blocks)


def pile(count: int) -> Assembly:
    """Cubes stacked in a cube, each course shifted by half a cube: thick masonry."""
    side = round(count ** (1 / 3))
    cube = Shape("cube", Polytope.box((0.0, 0.0, 0.0), (0.2, 0.2, 0.2)))
    places = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)[:, ::-1]
    at = 0.2 * places + 0.1 * (places[:, 2:] % 2) * [1, 1, 0]
    blocks = tuple(Block(f"c{k}", 0, Pose.at(*row)) for k, row in enumerate(at.tolist()))
    return Assembly(3, (cube,), blocks)


def leaning(count: int) -> Assembly:
    """Threes of cubes, edge across edge: no two faces meet, all pairs are searched for edges."""
    cube = Shape("cube", Polytope.box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)))
    tip = np.sqrt(2) * 0.1
    skew = np.array([[np.sqrt(0.5), 0.0, -np.sqrt(0.5)], [0.0, 1.0, 0.0], [np.sqrt(0.5), 0.0, np.sqrt(0.5)]])
    across = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) @ skew
    side = max(1, round(np.sqrt(count / 3)))
    blocks = []
    for row, column in np.ndindex(side, side):
        x, y = 0.5 * row, 0.5 * column
        for level, turn in enumerate((skew, across, skew)):
            blocks.append(Block(f"s{row}.{column}.{level}", 0, Pose(turn, np.array([x, y, 2 * level * tip]))))
    return Assembly(3, (cube,), tuple(blocks))


CASES: dict[str, Callable[[int], Assembly]] = {
    "wall": wall,
    "wall, turned": lambda count: turned(wall(count)),
    "pile": pile,
    "edge on edge": leaning,
}


def timed(assembly: Assembly) -> Timing:
    """CPU time of what a build does with an assembly."""
    marks = [time.process_time()]
    overlapping(assembly)
    marks.append(time.process_time())
    interfaces: tuple[Interface, ...] = detect(assembly)
    marks.append(time.process_time())
    contacts = place(assembly, interfaces, [Rule()] * len(interfaces))
    marks.append(time.process_time())
    overlaps, found, placed = np.diff(marks).tolist()
    return Timing(len(assembly.blocks), len(interfaces), contacts.count, overlaps, found, placed)


def growth(timings: list[Timing]) -> float:
    """Exponent p of seconds ~ blocks^p, by least squares over all sizes."""
    blocks = np.log([timing.blocks for timing in timings])
    seconds = np.log([timing.overlaps + timing.detect + timing.place for timing in timings])
    return float(np.polyfit(blocks, seconds, 1)[0])


def rows(sizes: tuple[int, ...]) -> Iterator[tuple[str, ...]]:
    """One row a structure and size; the last of a structure tells how its time grows."""
    for name, make in CASES.items():
        timed(make(100))  # compiles
        timings: list[Timing] = []
        for size in sizes:
            timings.append(timed(make(size)))
            last = timings[-1]
            yield (
                name,
                f"{last.blocks}",
                f"{last.interfaces}",
                f"{last.contacts}",
                f"{last.overlaps:.2f}",
                f"{last.detect:.2f}",
                f"{last.place:.2f}",
                f"n^{growth(timings):.2f}" if size == sizes[-1] else "",
            )


def main() -> None:
    parser = argparse.ArgumentParser(description="Time detection for growing structures.")
    parser.add_argument("--quick", action="store_true", help="only the small ones")
    given = parser.parse_args()
    sizes = tuple(size for size in SIZES if not given.quick or size <= QUICK)
    table, console = Table(*COLUMNS), Console(width=None if sys.stdout.isatty() else 120)
    made = []
    for row in rows(sizes):
        table.add_row(*row)
        made.append(row)
    console.print(table)
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + " --- |" * len(COLUMNS)]
    console.print("\n".join([*lines, *("| " + " | ".join(row) + " |" for row in made)]), soft_wrap=True)


if __name__ == "__main__":
    main()

"""Write meshes/window_bay.csv, a survey of a window bay in an ashlar façade that was never built.

    python meshes/window_bay.py

7.2 m wide, 8 m high, courses of 32 cm, stones of 40 to 80 cm; a window of 1.6 m under a segmental arch of
nine voussoirs whose extrados is level, and a relieving course of skew stones above it. The corners of each
stone's face carry a noise of 2 mm along each axis. Right of the window the ground has sunk by up to 5 mm,
and a crack climbs from the arch to the top, where it is 18 mm wide.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

TARGET = Path(__file__).with_suffix(".csv")
WIDTH, COURSE, COURSES = 7.2, 0.32, 25  # [m]
LEFT, RIGHT = 2.8, 4.4  # the window's jambs [m]
SILL, SPRINGING, CROWN = 6, 15, 17  # courses below the window, its arch and the relieving course
RISE = 0.2  # of the arch [m]
CENTRE = np.array([3.6, SPRINGING * COURSE + RISE - (0.8**2 + RISE**2) / (2 * RISE)])
VOUSSOIRS, RELIEVING = 9, 6
BOND = 0.12  # least distance of head joints in courses one on another [m]


def stones(seed: int = 1) -> dict[str, np.ndarray]:
    """Faces as they were built: corners along the wall and up it, counter-clockwise, shape (4, 2) [m]."""
    rng = np.random.default_rng(seed)
    made: dict[str, np.ndarray] = {}
    below: list[float] = []
    for course in range(COURSES):
        low, high = course * COURSE, (course + 1) * COURSE
        joints: list[float] = []
        count = 0
        for start, end in _stretches(course):
            cuts = _cuts(start[0], end[0], below, rng)
            joints += cuts[1:-1]
            lower = [start[0], *cuts[1:-1], end[0]]
            upper = [start[1], *cuts[1:-1], end[1]]
            for at in range(len(cuts) - 1):
                count += 1
                made[f"c{course + 1:02d}s{count:02d}"] = np.array(
                    [[lower[at], low], [lower[at + 1], low], [upper[at + 1], high], [upper[at], high]]
                )
        below = joints
    return made | _arch() | _relief()


def _stretches(course: int) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Where a course has stones of its own: its left and right ends, each at its bottom and its top."""
    whole = ((0.0, 0.0), (WIDTH, WIDTH))
    if course == SILL - 1:  # one long stone under the window
        return [((0.0, 0.0), (2.6, 2.6)), ((2.6, 2.6), (4.6, 4.6)), ((4.6, 4.6), (WIDTH, WIDTH))]
    if SILL <= course < SPRINGING:
        return [((0.0, 0.0), (LEFT, LEFT)), ((RIGHT, RIGHT), (WIDTH, WIDTH))]
    if SPRINGING <= course <= CROWN:
        low, high = (_skew(level * COURSE, course) for level in (course, course + 1))
        return [((0.0, 0.0), low[:1] + high[:1]), (low[1:] + high[1:], (WIDTH, WIDTH))]
    return [whole]


def _skew(height: float, course: int) -> tuple[float, float]:
    """Ends of the arch (or of the relieving course) at a height, along radii."""
    half = 0.8 * (height - CENTRE[1]) / (SPRINGING * COURSE - CENTRE[1])
    half += 0.25 if course == CROWN else 0.0
    return float(CENTRE[0] - half), float(CENTRE[0] + half)


def _cuts(start: float, end: float, below: list[float], rng: np.random.Generator) -> list[float]:
    """Head joints of a stretch, its ends included, away from those of the course below."""
    if (start, end) == (2.6, 4.6):
        return [start, end]
    count = max(1, round((end - start) / 0.6))
    best, distance = [start, end], -1.0
    for _ in range(200):
        lengths = rng.uniform(0.4, 0.8, count)
        cuts = [start, *(start + np.cumsum(lengths)[:-1] * (end - start) / lengths.sum()), end]
        apart = min((abs(a - b) for a in cuts[1:-1] for b in below), default=1.0)
        if apart > distance:
            best, distance = [float(cut) for cut in cuts], apart
        if apart > BOND:
            break
    return best


def _arch() -> dict[str, np.ndarray]:
    """Voussoirs: chords of the intrados, radial joints up to the level extrados."""
    top = CROWN * COURSE
    half = np.arctan2(0.8, SPRINGING * COURSE - CENTRE[1])
    angles = np.linspace(-half, half, VOUSSOIRS + 1)
    radius = np.hypot(0.8, SPRINGING * COURSE - CENTRE[1])
    lower = CENTRE + radius * np.column_stack([np.sin(angles), np.cos(angles)])
    upper = np.column_stack([CENTRE[0] + np.tan(angles) * (top - CENTRE[1]), np.full(len(angles), top)])
    return {
        f"arch{at + 1}": np.array([lower[at], lower[at + 1], upper[at + 1], upper[at]])
        for at in range(VOUSSOIRS)
    }


def _relief() -> dict[str, np.ndarray]:
    """Skew stones of the course over the arch, their joints towards one point."""
    low, high = CROWN * COURSE, (CROWN + 1) * COURSE
    ends = [np.linspace(*_skew(height, CROWN), RELIEVING + 1) for height in (low, high)]
    return {
        f"relief{at + 1}": np.array(
            [[ends[0][at], low], [ends[0][at + 1], low], [ends[1][at + 1], high], [ends[1][at], high]]
        )
        for at in range(RELIEVING)
    }


def settled(
    faces: dict[str, np.ndarray], sinking: float = 0.005, crack: float = 0.018
) -> dict[str, np.ndarray]:
    """The faces after the right part sank, and the stones right of the crack moved aside [m]."""
    made = {}
    base, height = (CROWN + 1) * COURSE, COURSE * COURSES
    for name, face in faces.items():
        moved = face.copy()
        moved[:, 1] -= sinking * np.clip((face[:, 0] - RIGHT) / (WIDTH - RIGHT), 0.0, 1.0)
        x, z = face.mean(axis=0)
        climb = (z - base) / (height - base)
        if climb > 0 and x > 4.3 + 1.2 * climb:
            moved[:, 0] += crack * climb
        made[name] = moved
    return made


def measured(faces: dict[str, np.ndarray], noise: float = 0.002, seed: int = 2) -> dict[str, np.ndarray]:
    """Corners in space, x along the wall, y into it, z up, with Gaussian noise [m], shape (k, 3)."""
    rng = np.random.default_rng(seed)
    return {
        name: np.column_stack([face[:, 0], np.zeros(len(face)), face[:, 1]])
        + noise * rng.normal(size=(len(face), 3))
        for name, face in faces.items()
    }


def write(path: Path, corners: dict[str, np.ndarray]) -> None:
    """Write a survey."""
    lines = [
        "# synthetic survey of a window bay, in metres, made by meshes/window_bay.py",
        "stone,vertex,x,y,z",
    ]
    for name, face in corners.items():
        lines += [f"{name},{at},{x:.4f},{y:.4f},{z:.4f}" for at, (x, y, z) in enumerate(face, start=1)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write(TARGET, measured(settled(stones())))

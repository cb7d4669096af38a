"""Shaking: an elastic column against Duhamel's integral, and the pulses that overturn a rigid block.

References
----------
Zhang and Makris, Rocking response of free-standing blocks under cycloidal pulses, J. Eng. Mech. 127 (2001).
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, solve_ivp

from masonry_fem.analyses.incremental import incremental
from masonry_fem.analyses.run import solve_scene
from masonry_fem.analyses.single_run import run_once
from masonry_fem.scene import loads

G, YOUNG, DENSITY, LENGTH = 9.81, 1e7, 2000.0, 4.0
COLUMN = f"""
dimension = 2
fidelity = "elastic"
materials.stone = {{ density = {DENSITY}, young = {YOUNG}, poisson = 0.0 }}
mesh = {{ element = "Q2", divisions = [1, 16] }}
structures = [{{ kind = "block", name = "column", material = "stone", size = [0.5, {LENGTH}] }}]
supports = [{{ on = "column/bottom" }}]
probes = [{{ name = "top", block = "column", point = [0.25, {LENGTH}] }}]
analysis = {{ kind = "dynamics", step = 0.001, duration = 1.0, theta = 0.5 }}
loads.accelerograms = [{{ y = "record.csv", acts = "ACTS" }}]
"""
BLOCK = """
dimension = 2
fidelity = "rigid"
materials.stone.density = 2000
structures = [{ kind = "stack", name = "pier", material = "stone", size = [0.5, 2.0], count = 1 }]
joints = [{ friction = 5.0, form = "velocity" }]
loads = { gravity = [0, -9.81], accelerograms = [{ x = "pulse.csv", acts = "ACTS" }] }
analysis = { kind = "dynamics", step = 0.004, duration = DURATION, theta = 0.5 }
"""
ALPHA, RADIUS = float(np.arctan(0.25)), float(np.hypot(0.25, 1.0))
FREQUENCY = float(np.sqrt(0.75 * G / RADIUS))  # p of the block [1/s]
KEPT = 1 - 1.5 * np.sin(ALPHA) ** 2  # of the angular velocity, in an impact
UPLIFT = G * float(np.tan(ALPHA))  # acceleration that lifts it [m/s²]


class Top:
    """Observer that keeps how far the top has gone relative to the ground [m]."""

    def __init__(self) -> None:
        self.time: list[float] = []
        self.way: list[float] = []

    def record(self, model, state, report) -> None:
        self.time.append(report.time)
        self.way.append(report.probes["top"][1] - model.ground.shift(report.time)[1])


def record() -> tuple[np.ndarray, np.ndarray]:
    """One second of four frequencies between 3 and 17 Hz that swell and die away."""
    time = np.arange(0.0, 1.0, 0.002)
    waves = [(3.0, 0.7, 0.2), (7.0, -1.3, 2.0), (11.0, 0.9, 4.0), (17.0, 0.5, 1.0)]
    swell = 2 * np.sin(np.pi * time / time[-1]) ** 2
    return time, swell * sum(size * np.sin(2 * np.pi * f * time + phase) for f, size, phase in waves)


def duhamel(time: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Way of the end of a clamped bar relative to the ground, by its first 40 modes."""
    fine = np.linspace(0.0, time[-1], 20001)
    felt, way = np.interp(fine, time, values), np.zeros(20001)
    for k in range(40):
        odd = 2 * k + 1
        turn = odd * np.pi * np.sqrt(YOUNG / DENSITY) / (2 * LENGTH)
        even, uneven = np.cos(turn * fine), np.sin(turn * fine)
        first = cumulative_trapezoid(felt * even, fine, initial=0.0)
        second = cumulative_trapezoid(felt * uneven, fine, initial=0.0)
        way -= 4 * (-1) ** k / (odd * np.pi * turn) * (uneven * first - even * second)
    return np.interp(at, fine, way)


@pytest.mark.parametrize("acts", ["inertia", "ground"])
def test_an_elastic_column_follows_duhamel(tmp_path: Path, acts: str) -> None:
    """At every instant to 1 % of the greatest way, on the ground and as inertia alike."""
    time, values = record()
    np.savetxt(tmp_path / "record.csv", np.column_stack([time, values]), delimiter=",")
    seen = Top()
    solve_scene(loads(COLUMN.replace("ACTS", acts), base=tmp_path), tmp_path, (seen,))
    at = np.array(seen.time)
    within = at <= time[-1]
    exact = duhamel(time, values, at[within])
    assert len(exact) > 990
    assert np.abs(np.array(seen.way)[within] - exact).max() < 0.01 * np.abs(exact).max()


def fate(size: float, turn: float, cycles: float) -> tuple[bool, int]:
    """Whether a sine pulse overturns the block, and after how many impacts.

    Parameters
    ----------
    size, turn : Of the pulse, [m/s²] and [rad/s]. cycles : Its length.
    """
    end = 2 * np.pi * cycles / turn
    now, last = float(np.arcsin(UPLIFT / size)) / turn, end + 12 / FREQUENCY
    side, state, impacts = -1.0, [0.0, 0.0], 0

    def moves(time: float, here: np.ndarray) -> list[float]:
        pushed = size * np.sin(turn * time) / G if time < end else 0.0
        tilt = ALPHA * side - here[0]
        return [here[1], -(FREQUENCY**2) * (np.sin(tilt) + pushed * np.cos(tilt))]

    def lands(time: float, here: np.ndarray) -> float:
        return float(here[0] * side)

    def lies(time: float, here: np.ndarray) -> float:
        return float(abs(here[0]) - np.pi / 2)

    lands.terminal, lands.direction, lies.terminal = True, -1, True
    while impacts < 30:
        for until in (end, last):
            if until <= now:
                continue
            arc = solve_ivp(
                moves, (now, until), state, events=(lands, lies), rtol=1e-9, atol=1e-12, max_step=0.02
            )
            now, state = float(arc.t[-1]), arc.y[:, -1].tolist()
            if arc.status == 1:
                break
        if len(arc.t_events[1]):
            return True, impacts
        if not len(arc.t_events[0]) or abs(state[1]) < 1e-6:
            return False, impacts
        impacts, side, state = impacts + 1, -side, [0.0, KEPT * state[1]]
    return False, impacts


@cache
def boundary(low: float, high: float, turn: float, cycles: float, mode: int) -> float:
    """Least pulse that overturns the block in a mode: 1 with an impact, 2 without.

    Parameters
    ----------
    low, high : Pulses that do not and that do, over that which lifts the block.
    turn, cycles : Of the pulse. mode : Of overturning.
    """
    for _ in range(12):
        middle = 0.5 * (low + high)
        falls, impacts = fate(middle * UPLIFT, turn, cycles)
        if falls and (impacts == 0 if mode == 2 else impacts > 0):
            high = middle
        else:
            low = middle
    return high * UPLIFT


@pytest.mark.slow
@pytest.mark.parametrize("acts", ["inertia", "ground"])
@pytest.mark.parametrize(
    ("share", "cycles", "mode", "low", "high"),
    [
        (1.5, 1.0, 1, 1.1, 1.5), (2.0, 1.0, 1, 1.1, 1.6), (3.0, 1.0, 1, 1.2, 2.0), (4.0, 1.0, 1, 1.4, 2.5),
        (3.0, 1.0, 2, 3.6, 4.0), (4.0, 1.0, 2, 5.15, 5.6), (5.0, 1.0, 2, 7.0, 7.6),
        (2.0, 0.5, 2, 1.2, 2.5), (3.0, 0.5, 2, 1.5, 3.0), (4.0, 0.5, 2, 2.0, 4.0),
    ],
)  # fmt: skip
def test_a_block_overturns_where_housner_says(
    tmp_path: Path, acts: str, share: float, cycles: float, mode: int, low: float, high: float
) -> None:
    """It stands under 0.98 of the least pulse that overturns it, and falls under 1.02 of it.

    Pulses of a sine overturn it with an impact (mode 1) or without (mode 2), with a range between where it
    stands; half a sine only without.
    """
    turn = share * FREQUENCY
    least, end = boundary(low, high, turn, cycles, mode), 2 * np.pi * cycles / turn
    assert low * 1.001 < least / UPLIFT < high
    time = np.linspace(0.0, end, 201)
    scene = BLOCK.replace("ACTS", acts).replace("DURATION", str(end + 9 / FREQUENCY))
    for factor, verdict in ((0.98, "stands"), (1.02, "falls")):
        pulse = factor * least * np.sin(turn * time)
        np.savetxt(tmp_path / "pulse.csv", np.column_stack([time, pulse]), delimiter=",")
        assert run_once(loads(scene, base=tmp_path), tmp_path).verdict == verdict, factor


@pytest.mark.slow
def test_the_fragility_of_a_block_is_housners_boundary(tmp_path: Path) -> None:
    """Pulses of half a sine of three lengths, scaled: each overturns it between 0.98 and 1.02 of the least.

    Records that differ only in size make a step, as intensity is that of the scaled record.
    """
    (tmp_path / "block.toml").write_text(BLOCK.replace("ACTS", "inertia").replace("DURATION", "3.5"))
    least, files = {}, []
    for share, low, high in ((2.0, 1.2, 2.5), (3.0, 1.5, 3.0), (4.0, 2.0, 4.0)):
        turn = share * FREQUENCY
        least[f"pulse{share:g}"] = boundary(low, high, turn, 0.5, 2)
        time = np.linspace(0.0, np.pi / turn, 201)
        files.append(tmp_path / f"pulse{share:g}.csv")
        np.savetxt(files[-1], np.column_stack([time, 0.1 * np.sin(turn * time)]), delimiter=",")
    levels = sorted(factor * one for one in least.values() for factor in (0.98, 1.02))
    made = incremental(tmp_path / "block.toml", files, levels=levels, out=tmp_path / "out", workers=1)
    told = made.told.fragilities[0]
    assert {one.record: (one.stands, one.passes) for one in told.capacities} == {
        name: (0.98 * one, 1.02 * one) for name, one in least.items()
    }
    assert told.outcome == "fitted"
    assert told.median == pytest.approx(np.exp(np.log(list(least.values())).mean()), rel=0.01)

    time, turn = np.linspace(0.0, np.pi / (3 * FREQUENCY), 201), 3 * FREQUENCY
    like = []
    for size in (0.5, 2.0):
        like.append(tmp_path / f"size{size:g}.csv")
        np.savetxt(like[-1], np.column_stack([time, size * np.sin(turn * time)]), delimiter=",")
    levels = [factor * least["pulse3"] for factor in (0.9, 0.98, 1.02)]
    made = incremental(tmp_path / "block.toml", like, levels=levels, out=tmp_path / "step", workers=1)
    assert made.told.fragilities[0].outcome == "step"
    assert made.told.fragilities[0].median_range == (levels[1], levels[2])

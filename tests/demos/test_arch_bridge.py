"""The arch bridge: the load at failure with and without the strength of the fill, and the mechanism."""

from __future__ import annotations

import numpy as np
import pytest

from demos import arch_bridge
from masonry_fem.analyses.collapse import collapse
from masonry_fem.analyses.limit import analyse
from masonry_fem.scene import load


def test_fill_as_load_weighs_what_it_weighs() -> None:
    scene = load(arch_bridge.SCENE)
    loads = arch_bridge.fill_as_load(scene).loads
    bridge = scene.structures[0]
    outer = bridge.radius + bridge.thickness / 2
    half = outer * np.sin(bridge.half)
    chords = 24 * outer**2 * np.sin(2 * bridge.half / 24) / 2  # the fan over the chords
    below = chords - half * (outer * np.cos(bridge.half))
    level = outer * (1 - np.cos(bridge.half)) + bridge.cover
    weight = (2 * half * level - below) * scene.materials["soil"].density * 9.81
    assert sum(one.vector[1] for one in loads.points) == pytest.approx(-weight, rel=1e-9)
    strip = [one.vector[1] * (one.end[0] - one.start[0]) for one in loads.lines]
    assert sum(strip) == pytest.approx(-1.0, rel=1e-12)


def test_simulation_and_limit_analysis_agree_where_the_fill_is_a_load_only() -> None:
    scene = arch_bridge.fill_as_load(load(arch_bridge.SCENE))
    dead = ("points.*",)
    found = analyse(scene, dead=dead)
    assert found.multiplier is not None
    assert "4 hinges" in found.mechanism.sentence
    told = collapse(scene, dead=dead).summary
    assert told.stands < found.multiplier < told.falls < 1.02 * told.stands
    assert arch_bridge.WIDTH * found.multiplier == pytest.approx(123e3, rel=0.01)


@pytest.mark.slow
def test_the_bridge_fails_at_the_load_of_the_test() -> None:
    found = arch_bridge.main(steps=4)
    (curve,) = found.curves
    assert curve.outcome == "equilibrium"
    assert curve.peak == pytest.approx(arch_bridge.TEST, rel=0.2)
    assert curve.load[-1] < 0.99 * curve.peak
    assert found.as_load < 0.6 * curve.peak
    below, beyond = (place for place in curve.hinges if abs(place) < 2.0)
    assert below == pytest.approx(-1.6, abs=0.3)  # the strip ends at −1.49 m
    assert 0.0 < beyond < 1.0

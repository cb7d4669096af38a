"""Blocks that overlap or stand apart at the start: refused, borne, and told of."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.scene.specs import Contact, Material, Scene
from masonry_fem.structures.block import BlockStructure


def two_cubes(gap: float, **contact: float) -> Scene:
    """A cube above a support, ``gap`` m apart."""
    return Scene(
        fidelity="rigid",
        materials={"stone": Material(density=2000.0)},
        structures=(
            BlockStructure(name="low", material="stone", size=(1.0, 1.0, 1.0), support=True),
            BlockStructure(
                name="high", material="stone", size=(1.0, 1.0, 1.0), position=(0.2, 0.0, 1.0 + gap)
            ),
        ),
        contact=Contact(**contact),
    )


@pytest.mark.parametrize("gap", [-5e-4, -2e-6])
def test_overlap_within_the_reach_is_borne_and_named(gap: float, caplog: pytest.LogCaptureFixture) -> None:
    built = build(two_cubes(gap), Path())
    assert built.model.contacts.gap == pytest.approx(gap)
    assert f"'low' and 'high' by {-gap:.3g} m" in caplog.text
    assert "they stay where they are" in caplog.text


@pytest.mark.parametrize("gap", [0.0, 1e-6])
def test_blocks_that_touch_need_no_word(gap: float, caplog: pytest.LogCaptureFixture) -> None:
    assert build(two_cubes(gap), Path()).model.contacts.gap == pytest.approx(gap)
    assert caplog.text == ""


def test_deeper_overlap_is_refused_with_what_is_allowed() -> None:
    with pytest.raises(SceneError, match=r"'low' and 'high' by 0.002 m.*contact.reach \(0.001 m\)"):
        build(two_cubes(-2e-3), Path())
    assert build(two_cubes(-2e-3, reach=3e-3), Path()).model.contacts.count == 4


def test_open_joints_are_told(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="masonry_fem"):
        build(two_cubes(5e-4), Path())
    assert "1 of 1 joints are open at the start, by up to 0.0005 m ('high' and 'low')" in caplog.text

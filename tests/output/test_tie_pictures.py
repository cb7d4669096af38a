"""Ties in pictures: what the legend tells of them, in a run and of the files that it has written."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from masonry_fem.analyses.run import run
from masonry_fem.output import fields, marks
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import Sheet
from masonry_fem.output.view import read_scenery
from masonry_fem.scene import loads

pytest.importorskip("pyvista")

# bars of one length, side by side, hold a block that is pulled over a bed without friction
SCENE = """
title = "bars"
dimension = 2
fidelity = "rigid"
joints = [{ friction = 0.0 }]
output = { pictures = false }
materials.stone = { density = 2000.0 }
loads = { gravity = [0.0, -10.0], points = [{ block = "stone", vector = [4e3, 0.0], point = [3.0, 0.0] }] }
[[structures]]
kind = "block"
name = "ground"
material = "stone"
size = [4.0, 0.5]
position = [0.0, -0.5]
support = true
[[structures]]
kind = "block"
name = "stone"
material = "stone"
size = [1.0, 1.0]
position = [2.0, 0.0]
"""
BAR = """
[[ties]]
name = "{name}"
points = [{{ block = "ground", point = [0.0, 0.0] }}, {{ block = "stone", point = [2.0, 0.0] }}]
young = 2e11
section = {section}
{more}
"""


def scene(*bars: tuple[str, float, str]) -> str:
    made = [BAR.format(name=name, section=area, more=more) for name, area, more in bars]
    return SCENE + "".join(made)


def sceneries(text: str, folder: Path) -> tuple[Scenery, Scenery]:
    """What pictures show at the end of a run, and when it is read from its files."""
    made = run(loads(text), folder)
    return Scenery.of(made.built.model, made.march.state), read_scenery(folder)


def legend(scenery: Scenery, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is said of the ties, without drawing them."""
    monkeypatch.setattr(marks, "bands", lambda *_: None)
    stage: Any = SimpleNamespace(view=None, scale=1.0, mark=lambda *_, **__: None)
    page = Sheet("", "")
    marks.mark_ties(stage, page, scenery, DeformedShape(scenery, 1.0), 1.0)
    return [key.text for key in page.keys]


def test_the_legend_tells_force_elongation_and_utilisation_of_a_tie(tmp_path, monkeypatch):
    """T = 4 kN/m; T L/(E A) = 4e3 · 2/(2e11 · 1e-4) = 0.4 mm; T/(f_y A) = 4e3/(1e8 · 1e-4) = 0.4."""
    text = scene(("bar", 1e-4, "yield_stress = 1e8"))
    for one in sceneries(text, tmp_path):
        assert legend(one, monkeypatch) == ["bar: 4 kN/m, longer by 400 µm, 40 % of yield"]


def test_of_many_ties_the_most_used_are_named_in_their_order(tmp_path, monkeypatch):
    """The force is shared as stiffness is, 1 : 2 : 1 : 1; the weak one has half the strength of others."""
    strong, weak = "yield_stress = 1e8", "yield_stress = 5e7"
    bars = [("a", 1e-4, strong), ("thick", 2e-4, strong), ("weak", 1e-4, weak), ("free", 1e-4, "")]
    for one in sceneries(scene(*bars), tmp_path):
        assert legend(one, monkeypatch) == [
            "weak: 800 N/m, longer by 80 µm, 16 % of yield",
            "thick: 1.6 kN/m, longer by 80 µm, 8 % of yield",
            "2 more, none used more",
        ]


def test_files_of_earlier_versions_tell_the_force(tmp_path, monkeypatch):
    _, old = sceneries(scene(("bar", 1e-4, "")), tmp_path)
    old.ties.field_data.remove("tie_names")
    for name in (fields.TIE_ELONGATION, fields.TIE_UTILISATION):
        old.ties.point_data.remove(name)
    assert legend(old, monkeypatch) == ["tie: 4 kN/m"]

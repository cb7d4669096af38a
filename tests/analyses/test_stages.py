"""Stages: histories of structures, stage after stage."""

from __future__ import annotations

import csv
import json

import pytest

from masonry_fem.analyses.run import run
from masonry_fem.scene import loads

COURSES = """
dimension = 2
fidelity = "elastic"
mesh = {{ element = "Q1", size = 0.25 }}
loads.gravity = [0.0, -10.0]
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.2 }}
structures = [
  {{ kind = "wall", name = "wall", material = "stone", brick = [0.5, 0.25], columns = 3, courses = 4 }},
]
joints = [{{ friction = 0.6 }}]
output = {{ pictures = false }}
{stages}
"""
BUILT = "\n".join(
    f'[[stages]]\nname = "course{k}"\nwithout = [{", ".join(repr(f"wall.c{j}") for j in range(k + 1, 5))}]'
    for k in range(1, 5)
)


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_wall_built_in_courses_bears_the_weight(tmp_path):
    made = run(loads(COURSES.format(stages=BUILT)), tmp_path)
    assert made.outcome == "equilibrium"
    weight = 2000.0 * 10.0 * 0.5 * 0.25 * 3
    for number, stage in enumerate(made.summary.stages, 1):
        told = json.loads((tmp_path / stage.name / "summary.json").read_text(encoding="utf-8"))
        force = told["supports"]["wall.ground"]["force"]
        assert force == pytest.approx([0.0, number * weight], rel=1e-9, abs=1e-9 * weight)
    at_once = run(loads(COURSES.format(stages="")), tmp_path / "at once")
    ups = [one.summary.supports["wall.ground"].force for one in (made, at_once)]
    assert ups[0] == pytest.approx(ups[1], rel=1e-9, abs=1e-9 * weight)

"""Stones that are set down on what has moved: flush, and without stress."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import run
from masonry_fem.analyses.run.reopening import begun
from masonry_fem.build import build
from masonry_fem.scene import check, loads

WALL = """
dimension = {d}
fidelity = "{fidelity}"
loads.gravity = {gravity}
materials.stone = {{ density = 2000.0, young = 2e9, poisson = 0.2, degree = 2 }}
mesh = {{ element = "Q1", size = 0.25 }}
structures = [
  {{ kind = "wall", name = "wall", material = "stone", brick = {brick}, columns = 3, courses = 4 }},
]
joints = [{{ friction = 0.7 }}]
contact.update = "{update}"
analysis = {{ kind = "statics", load_steps = 4, new_stones = "{new}" }}
output = {{ pictures = false, fields = false, checkpoint_steps = 1 }}

[[supports]]
on = "wall.ground"
motion = {{ displacement = {down}, rotation = {turn}, pivot = {pivot} }}
[[stages]]
name = "first"
without = ["wall.c[234]"]

[[stages]]
name = "second"
without = ["wall.c4"]
supports = []

[[stages]]
name = "third"
without = []
"""
TURN, DOWN = 0.03, -0.04


def wall(d: int, fidelity: str, new: str, update: str = "moving") -> str:
    flat = d == 2
    return WALL.format(
        d=d, fidelity=fidelity, new=new, update=update,
        gravity=[0.0, -10.0] if flat else [0.0, 0.0, -10.0],
        brick=[0.5, 0.25] if flat else [0.5, 0.25, 0.25],
        down=[0.0, DOWN] if flat else [0.0, 0.0, DOWN],
        turn=TURN if flat else [0.0, -TURN, 0.0],
        pivot=[0.75, 0.0] if flat else [0.75, 0.1, 0.0],
    )  # fmt: skip


def motions(made):
    """R and t of each block by name."""
    model, state = made.march.model, made.march.state
    found = {}
    for group, own in zip(model.groups, state.bodies, strict=True):
        turn, shift = group.motion(own)
        for body, block in enumerate(group.blocks):
            found[model.assembly.blocks[block].name] = turn[body], shift[body]
    return found


@pytest.mark.parametrize(
    ("d", "fidelity"), [(2, "rigid"), (3, "rigid"), (2, "elastic"), (2, "reduced"), (3, "elastic")]
)
def test_a_wall_that_is_built_on_settled_ground_stays_flush(d, fidelity, tmp_path):
    """Each course lies on the one below it, as if all had been there when the ground went and turned."""
    made = run(loads(wall(d, fidelity, "moved")), tmp_path)
    assert [stage.outcome for stage in made.summary.stages] == ["equilibrium"] * 3
    found = motions(made)
    turn, shift = found["wall.ground"]
    rough = 1e-10 if fidelity == "rigid" else 2e-5  # stones give way by their weight
    assert abs(turn[-1, 0]) == pytest.approx(np.sin(TURN), rel=1e-12)
    for name, (own_turn, own_shift) in found.items():
        assert np.abs(own_turn - turn).max() <= rough, name
        assert np.abs(own_shift - shift).max() <= rough, name
    assert abs(made.march.state.gap[made.march.model.contacts.blocks.min(axis=1) >= 0]).max() <= 2e-5
    weight = 3 * 4 * 2000.0 * 10.0 * 0.5 * 0.25 * (0.25 if d == 3 else 1.0)
    assert made.summary.supports["wall.ground"].force[-1] == pytest.approx(weight, rel=1e-6)


def second_stage(folder, new):
    """What the second stage begins with: its model, and the state of the start."""
    run(loads(wall(2, "elastic", new)), folder)
    base = folder / "second"
    scene = check(loads((base / "as_run.toml").read_text(encoding="utf-8"), base=base), base=base)
    built, start = begun(scene, build(scene, base), base)
    return built.model, start


def bed_gaps(model, start):
    beds = np.array([one.label == "bed" for one in model.interfaces])
    return np.abs(start.gap[beds[model.contacts.interface]])


def test_they_begin_without_stress_where_the_others_are(tmp_path):
    model, start = second_stage(tmp_path, "moved")
    names = [block.name for block in model.assembly.blocks]
    for group, own in zip(model.groups, start.bodies, strict=True):
        field = group.stress(own)
        if field is None:
            continue
        for body, block in enumerate(group.blocks):
            stressed = np.abs(field.gauss[body]).max() > 1e-6  # Pa; rounding of turns strains by 1e-16
            assert stressed == (not names[block].startswith(("wall.c2", "wall.c3"))), names[block]
    assert bed_gaps(model, start).max() <= 1e-6


@pytest.mark.slow
def test_in_the_reference_they_hang_over_what_has_sunk(tmp_path):
    model, start = second_stage(tmp_path, "reference")
    assert bed_gaps(model, start).max() > 0.04


def test_small_turns_where_contacts_are_fixed(tmp_path):
    keys = ["supports.0.motion.rotation=1e-4", "supports.0.motion.displacement=[0.0, -1e-4]"]
    made = run(loads(wall(2, "elastic", "moved", "fixed"), keys), tmp_path)
    assert [stage.outcome for stage in made.summary.stages] == ["equilibrium"] * 3
    found = motions(made)
    for name in ("wall.c1.b2", "wall.c3.b1", "wall.c4.b2"):
        assert found[name][0][1, 0] == pytest.approx(1e-4, abs=1.5e-5)

"""Contacts found anew during a march: blocks that slide off, fall, land and topple."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import run
from masonry_fem.bodies.base import by_block
from masonry_fem.errors import SceneError
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Initial,
    Joint,
    Loads,
    Material,
    Scatter,
    Scene,
    Solver,
    Statics,
    law_record,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from tests.validation.scenes import STONE, solved
from tests.validation.tape import Tape, taped

G = 9.81
FLOOR = BlockStructure(name="floor", material="stone", size=(6.0, 0.5), position=(-1.0, -0.5), support=True)
GROUND = BlockStructure(
    name="floor", material="stone", size=(6.0, 6.0, 0.5), position=(-3.0, -3.0, -0.5), support=True
)


def block(name: str, size: tuple[float, ...], at: tuple[float, ...], support: bool = False) -> BlockStructure:
    return BlockStructure(name=name, material="stone", size=size, position=at, support=support)


def rigid(
    *blocks: BlockStructure,
    initial: Initial | None = None,
    friction: float = 0.5,
    step: float = 2e-3,
    duration: float = 1.0,
    every: int = 1,
    update: str = "redetect",
    **keys: Any,
) -> tuple[Tape, Any]:
    d = len(blocks[0].size)
    fields: dict[str, Any] = {
        "dimension": d,
        "fidelity": "rigid",
        "materials": {"stone": Material(density=2000.0)},
        "structures": blocks,
        "initial": () if initial is None else (initial,),
        "joints": (Joint(friction=friction),),
        "loads": Loads(gravity=(*(0.0,) * (d - 1), -G)),
        "analysis": Dynamics(step=step, duration=duration),
        "contact": Contact(update=update, every=every),
        "solver": Solver(tolerance=1e-10),
    }
    return taped(**(fields | keys))[:2]


def corners(made: Any, name: str) -> np.ndarray:
    """Where a block's corners are at the end."""
    for group, state in zip(made.model.groups, made.state.bodies, strict=True):
        for number, places in zip(group.blocks, by_block(group, group.positions(state)), strict=True):
            if made.model.assembly.blocks[number].name == name:
                return places
    raise AssertionError(name)


def energy(tape: Tape) -> np.ndarray:
    """Kinetic energy less the work of loads: what contact has taken is missing [J]."""
    kinetic = np.array([report.kinetic_energy for report in tape.reports])
    return kinetic - np.cumsum([report.external_work for report in tape.reports])


@pytest.mark.slow
@pytest.mark.parametrize(("step", "every"), [(4e-3, 2), (1e-3, 5)])
def test_a_block_slides_off_a_table_and_lands_on_another(step: float, every: int) -> None:
    """Contacts vanish and appear; all the energy goes in friction and in the impact."""
    tape, made = rigid(
        FLOOR,
        block("table", (1.0, 0.5), (0.0, 0.0), support=True),
        block("mover", (0.4, 0.2), (0.55, 0.5)),
        block("third", (1.0, 0.2), (1.3, 0.0)),
        initial=Initial(blocks="mover", velocity=(2.5, 0.0)),
        friction=0.3,
        step=step,
        every=every,
        duration=1.2,
    )
    mover, third = corners(made, "mover"), corners(made, "third")
    assert mover[:, 1].min() == pytest.approx(0.2, abs=1e-6)  # on top of the third
    assert mover[:, 1].max() == pytest.approx(0.4, abs=1e-6)
    assert third[:, 1].min() == pytest.approx(0.0, abs=1e-6)
    assert tape.reports[-1].kinetic_energy < 1e-10
    assert np.diff(energy(tape)).max() < 1e-9 * abs(energy(tape)).max()
    assert max(report.max_penetration for report in tape.reports) < 1e-6
    named = {made.model.assembly.blocks[k].name for one in made.model.interfaces for k in one.blocks}
    assert named == {"floor", "mover", "third"}


def test_without_it_the_block_slides_on_in_the_air() -> None:
    _, made = rigid(
        FLOOR,
        block("table", (1.0, 0.5), (0.0, 0.0), support=True),
        block("mover", (0.4, 0.2), (0.55, 0.5)),
        initial=Initial(blocks="mover", velocity=(2.5, 0.0)),
        friction=0.0,
        duration=0.4,
        update="moving",
    )
    assert corners(made, "mover")[:, 0].min() > 1.0
    assert corners(made, "mover")[:, 1].min() == pytest.approx(0.5)


@pytest.mark.slow
@pytest.mark.parametrize("every", [pytest.param(1, marks=pytest.mark.slow), 10])
def test_a_tall_block_topples_and_lies_on_its_side(every: int) -> None:
    tape, made = rigid(
        FLOOR,
        block("tall", (0.3, 1.5), (0.0, 0.0)),
        initial=Initial(blocks="tall", spin=-3.0),
        friction=0.8,
        duration=2.0,
        every=every,
    )
    at = corners(made, "tall")
    assert at[:, 1].min() == pytest.approx(0.0, abs=1e-6)
    assert at[:, 1].max() == pytest.approx(0.3, abs=1e-6)
    assert np.ptp(at[:, 0]) == pytest.approx(1.5, abs=1e-6)
    assert tape.reports[-1].kinetic_energy < 1e-10


@pytest.mark.slow
def test_energy_of_a_fall_rises_by_no_more_than_the_steps_turn() -> None:
    """A step takes the lever arms that it starts with: an error of the square of the step, no more."""
    rises = []
    for step in (4e-3, 2e-3):
        tape, _ = rigid(
            FLOOR,
            block("tall", (0.3, 1.5), (0.0, 0.0)),
            initial=Initial(blocks="tall", spin=-3.0),
            friction=0.8,
            duration=1.4,
            step=step,
        )
        rises.append(np.diff(energy(tape)).max() / np.ptp(energy(tape)))
    assert rises[1] < 1e-4
    assert rises[1] < 0.35 * rises[0]


@pytest.mark.slow
def test_small_motions_are_the_same_as_with_contacts_that_stay() -> None:
    """A block that rocks: the same path whether its contacts stay or are found anew each step."""
    paths = [
        rigid(
            FLOOR,
            block("tall", (0.3, 1.5), (0.0, 0.0)),
            initial=Initial(blocks="tall", spin=-0.5),
            friction=0.8,
            duration=0.6,
            update=update,
        )[0].energy
        for update in ("moving", "redetect")
    ]
    # faces tilted by less than 1e-5 share a normal that lies between theirs
    assert paths[1] == pytest.approx(paths[0], rel=2e-4, abs=1e-6)


@pytest.mark.slow
def test_a_block_tumbles_and_comes_to_rest_in_space() -> None:
    """Corners, edges and faces in turn, in 3D."""
    tape, made = rigid(
        GROUND,
        block("stone", (0.4, 0.5, 0.6), (0.0, 0.0, 0.5)),
        initial=Initial(blocks="stone", velocity=(1.0, 0.3, 0.0), spin=(3.0, 5.0, 2.0)),
        duration=2.5,
    )
    at = corners(made, "stone")
    assert at[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert min(abs(np.ptp(at[:, 2]) - side) for side in (0.4, 0.5, 0.6)) < 1e-6
    assert tape.reports[-1].kinetic_energy < 1e-10
    assert np.diff(energy(tape)).max() < 1e-6 * np.ptp(energy(tape))
    assert max(report.max_penetration for report in tape.reports) < 1e-6


@pytest.mark.slow
def test_a_corbel_slides_and_falls() -> None:
    """Three slabs of a stepped stack, the uppermost beyond balance: it falls to the ground."""
    tape, made = rigid(
        FLOOR,
        block("a", (1.0, 0.2), (0.0, 0.0)),
        block("b", (1.0, 0.2), (0.45, 0.2)),
        block("c", (1.0, 0.2), (0.95, 0.4)),
        friction=0.4,
        every=5,
        duration=1.5,
    )
    assert corners(made, "c")[:, 1].min() == pytest.approx(0.0, abs=1e-4)
    assert corners(made, "a")[:, 1].max() == pytest.approx(0.2, abs=1e-4)
    assert tape.reports[-1].kinetic_energy < 1e-3
    assert np.diff(energy(tape)).max() < 1e-4 * np.ptp(energy(tape))


def test_reactions_go_over_from_old_contacts_to_new() -> None:
    """A stack at rest: found anew each step, it needs no more iterations than with contacts that stay."""
    stack = StackStructure(name="s", material="stone", size=(1.0, 0.4), count=5)
    work = {}
    for update in ("moving", "redetect"):
        result = solved(
            dimension=2,
            fidelity="rigid",
            structures=(stack,),
            analysis=Dynamics(step=1e-2, duration=0.1),
            contact=Contact(update=update),
        )
        work[update] = result.summary.solver.iterations
        assert result.summary.supports["s.ground"].force[1] == pytest.approx(5 * 0.4 * 2400.0 * G)
    assert work["redetect"] <= work["moving"]


@pytest.mark.slow
def test_mortar_holds_its_contacts_and_new_ones_have_none() -> None:
    """A block glued to a wall hangs there; one that falls on it is not glued to it."""
    glued = Joint(
        law=law_record("mohr_coulomb", cohesion=1e6, tensile_strength=5e5),
        friction=0.6,
        between=("wall", "held"),
    )
    tape, made = rigid(
        block("wall", (0.5, 3.0), (-0.5, 0.0), support=True),
        block("held", (0.5, 0.5), (0.0, 1.0)),
        block("falls", (0.2, 0.2), (0.1, 1.8)),
        joints=(
            Joint(friction=0.6, law=law_record("mohr_coulomb", cohesion=1e5, tensile_strength=5e4)),
            glued,
        ),
        duration=0.5,
        every=2,
    )
    pair = np.sort(made.model.contacts.blocks, axis=1)
    old = (pair == [0, 1]).all(axis=1)
    assert old.any()
    assert not made.state.joints.broken[old].all()
    new = (pair == [1, 2]).all(axis=1)
    assert new.any()
    assert made.state.joints.broken[new].all()
    assert corners(made, "held")[:, 1].min() == pytest.approx(1.0, abs=1e-6)
    assert corners(made, "falls")[:, 1].min() == pytest.approx(1.5, abs=1e-4)
    assert tape.reports[-1].kinetic_energy < 1e-6


def test_what_cannot_be_found_anew_is_refused() -> None:
    stack = StackStructure(name="s", material="stone", size=(1.0, 0.4), count=2)
    with pytest.raises(SceneError, match="'redetect', expected rigid blocks"):
        solved(dimension=2, structures=(stack,), contact=Contact(update="redetect"))
    scattered = Joint(scatter=Scatter(seed=1, variation={"friction": 0.1}))
    with pytest.raises(SceneError, match="beside a joint with scatter"):
        solved(
            dimension=2,
            fidelity="rigid",
            structures=(stack,),
            joints=(scattered,),
            contact=Contact(update="redetect"),
            analysis=Statics(),
        )


@pytest.mark.slow
def test_results_are_written_for_contacts_that_change(tmp_path: Any) -> None:
    made = run(
        Scene(
            dimension=2,
            fidelity="rigid",
            materials={"stone": STONE},
            structures=(FLOOR, block("falls", (0.3, 0.3), (0.0, 0.05))),
            loads=Loads(gravity=(0.0, -G)),
            analysis=Dynamics(step=1e-2, duration=0.2),
            contact=Contact(update="redetect", every=3),
        ),
        tmp_path,
    )
    assert made.outcome == "finished"
    assert made.summary.supports["floor"].force[1] == pytest.approx(0.09 * 2400 * G, rel=1e-6)

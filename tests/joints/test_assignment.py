"""Several laws in one model."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import Assignment, Bed, Bilinear, Dry, MohrCoulomb
from tests.joints.samples import FRACTURE, SAMPLES, wander


def test_mixture_is_each_law_alone():
    """Every sample law has its own contact points, shuffled."""
    rng = np.random.default_rng(1)
    order = rng.permutation(3 * len(SAMPLES))
    parts = tuple((law, order[3 * i : 3 * i + 3]) for i, law in enumerate(SAMPLES))
    joints, c = Assignment(parts), len(order)
    area, step = rng.uniform(0.1, 1, c), 0.5
    state = committed = joints.initial(c, 3)
    alone = {i: law.initial(3, 3) for i, (law, _) in enumerate(parts)}
    start = np.zeros((c, 3))
    for velocity in wander(2, 3, steps=4, points=c) / step:
        reaction = rng.normal(size=(c, 3)) * 1e4
        joints.reduce(state, start, area, step)
        state = joints.update(committed, committed, start, reaction, velocity, area, step)
        reduction = joints.reduce(state, start, area, step)
        force, energy = joints.adhesive_reaction(state, area), joints.stored(state, area)
        for i, (law, own) in enumerate(parts):
            args = start[own], reaction[own], velocity[own], area[own], step
            single = law.update(alone[i], alone[i], *args)
            for name, values in single.arrays().items():
                assert (getattr(state, name)[own] == values).all(), (law.name, name)
            part = law.reduce(single, start[own], area[own], step)
            assert (reduction.offset[own] == part.offset).all()
            assert (reduction.stiffness[own] == part.stiffness).all()
            assert (reduction.friction[own] == part.friction).all()
            assert (reduction.closure[own] == part.closure).all()
            assert (force[own] == law.adhesive_reaction(single, area[own])).all()
            assert (energy[own] == law.stored(single, area[own])).all()
            alone[i] = single.committed()
        committed, start = state.committed(), start + step * velocity


def test_scattered_strengths_follow_their_points():
    strengths = np.array([0.1e6, 0.2e6, 0.3e6])
    weak = MohrCoulomb(cohesion=strengths, friction=0.5)
    joints = Assignment(((Dry(0.3), np.array([0, 2])), (weak, np.array([4, 1, 3]))))
    reduction = joints.reduce(joints.initial(5, 2), np.zeros((5, 2)), np.full(5, 2.0), 1.0)
    assert reduction.offset[:, 0] == pytest.approx([0, 0.8e6, 0, 1.2e6, 0.4e6])
    assert reduction.friction.tolist() == [0.3, 0.5, 0.3, 0.5, 0.5]


@pytest.mark.parametrize(
    ("members", "match"),
    [
        (([0, 1], [1, 2]), "contact 1 has 2 laws"),
        (([0], [2]), "contact 1 has no law"),
        (([0], [1]), "the model has 3"),
    ],
)
def test_each_contact_has_one_law(members, match):
    laws = (Dry(), Bilinear(**FRACTURE))
    parts = tuple((law, np.array(points)) for law, points in zip(laws, members, strict=True))
    with pytest.raises(LawError, match=match):
        Assignment(parts).initial(3, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Faulty(Dry):
    """A law of one's own with slips in it."""

    name: ClassVar[str] = "faulty"

    def reduce(self, *step):
        raise ValueError("operands could not be broadcast")

    def stored(self, state, area):
        return area[:, None]


@pytest.mark.parametrize("parts", [[[0, 1, 2]], [[0], [1, 2]]], ids=["one", "two"])
@pytest.mark.parametrize(
    ("method", "given"), [("reduce", (np.zeros((3, 2)), np.ones(3), 1.0)), ("stored", (np.ones(3),))]
)
def test_what_goes_wrong_in_a_law_of_ones_own_is_told_as_its_own(method, given, parts):
    joints = Assignment(tuple((Bed(Faulty(), 1e9, 1e9), np.array(points)) for points in parts))
    told = rf"joint law 'Faulty': {method} failed with ValueError: .*could not .*; correct it"
    with pytest.raises(LawError, match=told):
        getattr(joints, method)(joints.initial(3, 2), *given)

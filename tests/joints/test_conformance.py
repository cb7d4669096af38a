"""The conformance of a law: nothing is found in the package's, and what is wrong is named."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from masonry_fem.joints import Dry, Elastic, MohrCoulomb, violations
from tests.joints.samples import ALL, STIFFNESS, label


@pytest.mark.slow
@pytest.mark.parametrize("law", ALL, ids=label)
def test_nothing_is_found_in_the_laws_of_the_package(law):
    assert violations(law) == []


@dataclass(frozen=True, slots=True, eq=False)
class Healing(Elastic):
    name: ClassVar[str] = "healing"

    def update(self, state, *step):
        after = Elastic.update(self, state, *step)
        return replace(after, adhesion=np.where(state.adhesion == 1.0, 0.5, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class Forgetful(Elastic):
    """Does not tell what its springs store."""

    name: ClassVar[str] = "forgetful"

    def stored(self, state, area):
        return np.zeros(state.count)


@dataclass(frozen=True, slots=True, eq=False)
class Generous(Elastic):
    """Stores more than was put in."""

    name: ClassVar[str] = "generous"

    def stored(self, state, area):
        return 2.0 * Elastic.stored(self, state, area)


@dataclass(frozen=True, slots=True, eq=False)
class Skew(Elastic):
    """Stiffer along one of the tangents."""

    name: ClassVar[str] = "skew"

    def springs(self, state):
        return Elastic.springs(self, state) * ([1.0, 1.0, 2.0][: state.dimension])


@dataclass(frozen=True, slots=True, eq=False)
class Pointwise(MohrCoulomb):
    """Forgets that strengths are per area."""

    name: ClassVar[str] = "pointwise"

    def adhesive_reaction(self, state, area):
        return MohrCoulomb.adhesive_reaction(self, state, np.ones_like(area))

    def reduce(self, state, jump, area, step):
        return MohrCoulomb.reduce(self, state, jump, np.ones_like(area), step)


@dataclass(frozen=True, slots=True, eq=False)
class Sticky(MohrCoulomb):
    """Pulls on once broken."""

    name: ClassVar[str] = "sticky"

    def _threshold(self, state):
        return self.apex(state.count)


@dataclass(frozen=True, slots=True, eq=False)
class Careless(Dry):
    """Writes into the committed state."""

    name: ClassVar[str] = "careless"

    def update(self, state, *step):
        after = Dry.update(self, state, *step)
        state.slip[:] = after.slip + 1.0
        return after


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (Healing(**STIFFNESS), "adhesion grows by 0.5 in a step"),
        (Forgetful(**STIFFNESS), "energy vanishes"),
        (Generous(**STIFFNESS), "energy appears"),
        (Skew(**STIFFNESS), "how the tangent frame is turned"),
        (Pointwise(cohesion=0.2e6, friction=0.7, critical_slip=1e-4), "reaction is not proportional"),
        (Sticky(cohesion=0.2e6, friction=0.7), "a broken joint pulls"),
        (Careless(), "changes slip of the committed state"),
    ],
    ids=lambda one: getattr(one, "name", None),
)
def test_what_is_wrong_is_named(law, words):
    assert any(words in sentence for sentence in violations(law)), violations(law)

"""Every kind of analysis, by the example in its docstring: a new file in the folder is tested here, too."""

import tomllib

import pytest
from msgspec.inspect import type_info

from masonry_fem.march.equilibrium import kinds
from masonry_fem.records.docstring import example, meanings
from masonry_fem.scene.fitting import fitted

KINDS = kinds()
every = pytest.mark.parametrize("name", KINDS)


def strategy(name):
    """What the example says."""
    keys = tomllib.loads(example(KINDS[name]))
    assert keys.get("kind") == name, (
        f"give a table of a scene file under Examples in {KINDS[name].__module__}"
    )
    return fitted(keys, type_info(KINDS[name]), (), None)


@every
def test_its_keys_are_explained(name):
    assert set(meanings(KINDS[name])) == set(KINDS[name].__struct_fields__)


@every
def test_its_example_has_no_fault(name):
    assert list(strategy(name).faults(3)) == []


@every
def test_its_steps_follow_each_other_to_its_end(name):
    made = strategy(name)
    steps = list(made.schedule())
    assert len(steps) * made.parts == made.steps
    time = 0.0
    for scheme, until in steps:
        assert until - time == pytest.approx(scheme.step, rel=1e-9)
        assert (scheme.inertia > 0) == made.inertia
        time = until
    assert time == pytest.approx(made.end, rel=1e-9)
    assert 0.0 < made.ramp <= made.end


@every
def test_what_is_kept_of_velocities_is_a_share(name):
    assert 0.0 <= strategy(name).kept <= 1.0

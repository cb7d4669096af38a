"""The parts of summary.json that come from the fields."""

import json

import numpy as np
import pytest

from masonry_fem.output.strength import principal, von_mises
from masonry_fem.records.told import write
from masonry_fem.results.blocks import (
    _greatest_principal,
    status_counts,
    stress_summary,
    weighted_quantile,
)


def test_stress_summary_finds_extremes_and_their_blocks(elastic):
    model, state = elastic
    stones, field = model.groups[1], state.bodies[1].stress
    mises = von_mises(field.gauss)
    found = stress_summary(model, state)
    where = np.unravel_index(mises.argmax(), mises.shape)[0]
    assert found.max_von_mises.value == pytest.approx(mises.max())
    assert found.max_von_mises.block == model.assembly.blocks[stones.blocks[where]].name
    nodal = von_mises(field.nodal)
    assert found.max_von_mises_nodal.value == pytest.approx(nodal.max())
    highest = stones.blocks[np.unravel_index(nodal.argmax(), nodal.shape)[0]]
    assert found.max_von_mises_nodal.block == model.assembly.blocks[highest].name
    values, _ = principal(field.gauss)
    assert found.min_principal.value == pytest.approx(values.min())
    assert found.max_principal.value == pytest.approx(values.max())
    assert found.p95_von_mises == pytest.approx(np.quantile(mises, 0.95), rel=0.02)
    heavy = [block.von_mises for block in found.blocks]
    assert heavy == sorted(heavy, reverse=True)
    assert found.p95_von_mises <= found.max_von_mises.value
    mean = (field.gauss[:, :, 0] * field.weight[None]).sum(axis=1) / field.weight.sum()
    assert heavy[0] == pytest.approx(von_mises(mean).max())


def test_rigid_structures_have_no_stress(rigid):
    assert stress_summary(*rigid) is None


def test_status_counts_name_all_four(elastic):
    model, state = elastic
    counts = status_counts(state)
    assert set(counts) == {"open", "stick", "slip", "bonded"}
    assert sum(counts.values()) == model.contacts.count
    assert counts["open"] == 1


def test_quantile_is_weighted_by_volume():
    values, weight = np.array([3.0, 1.0, 2.0]), np.array([0.04, 0.5, 0.46])
    assert weighted_quantile(values, weight, 0.95) == 2.0
    assert weighted_quantile(values, weight, 0.97) == 3.0


def test_summary_is_plain_json_and_replaced_whole(tmp_path):
    path = tmp_path / "out" / "summary.json"
    write(path, {"old": 1})
    write(
        path,
        {"a": np.float64(0.1), "b": np.arange(2), "c": float("inf"), "d": {"é": (np.int64(3), None, True)},
         "p": tmp_path},
    )  # fmt: skip
    read = json.loads(path.read_text(encoding="utf-8"))
    assert read == {"a": 0.1, "b": [0, 1], "c": None, "d": {"é": [3, None, True]}, "p": str(tmp_path)}
    assert [p.name for p in path.parent.iterdir()] == ["summary.json"]


@pytest.mark.parametrize("shift", [0.0, -30.0, 30.0])
def test_the_greatest_principal_stress_is_found_among_few(shift):
    rng = np.random.default_rng(3)
    sigma = rng.normal(size=(400, 6))
    sigma[:, :3] += shift
    sigma[200:] = sigma[:200, [1, 2, 0, 4, 5, 3]]  # the same in other axes
    values = principal(sigma)[0]
    for sign, expected in ((1, values.max()), (-1, values.min())):
        number, found = _greatest_principal(sigma, von_mises(sigma), sign)
        assert found == expected
        assert expected in values[number]

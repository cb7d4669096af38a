"""Tree: what is packed comes back bit for bit, and nothing else does."""

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.joints.state import JointState
from masonry_fem.records.remark import Remark
from masonry_fem.records.tree import TreeError, contiguous, differences, packed, unpacked

VALUES = (
    None, True, 3, -0.0, 1 / 3, math.inf, -math.inf, "µ", [1, [2.5]], (), ((1,), "a"),
    {"a": (1, {"b": None})},
    Remark(code="a", sentence="b", blocks=("c",)), np.float64(0.1), np.int8(3),
)  # fmt: skip


def through_json(value):
    node, arrays = packed(value)
    return unpacked(json.loads(json.dumps(node)), arrays)


@pytest.mark.parametrize("value", VALUES, ids=str)
def test_values_come_back(value):
    back = through_json(value)
    assert type(back) is type(value)
    assert repr(back) == repr(value)


def test_no_number_comes_back():
    assert math.isnan(through_json(math.nan))


def test_arrays_come_back():
    for array in (np.arange(3.0), np.zeros((0, 2), np.int64), np.array([[True], [False]]), np.array(2.0)):
        back = through_json(array)
        assert back.dtype == array.dtype
        assert back.tobytes() == array.tobytes()
    matrix = sparse.csr_array(np.array([[0.0, 1.5], [2.5, 0.0]]))
    assert (through_json(matrix) != matrix).nnz == 0


def test_what_is_one_array_stays_one():
    array = np.arange(3.0)
    node, arrays = packed((array, [array]))
    assert len(arrays) == 1
    first, (second,) = unpacked(node, arrays)
    assert first is second


def test_a_record_comes_back():
    state = JointState.intact(4, 2, 1)
    back = through_json(state)
    assert type(back) is JointState
    for name, values in state.arrays().items():
        assert getattr(back, name).tobytes() == values.tobytes()


@dataclass(frozen=True)
class Foreign:
    """No record of the package."""


FOREIGN = {
    "function": len,
    "object": object(),
    "record": Foreign(),
    "numbered": {1: 2},
    "objects": np.array([object()]),
    "set": {1, 2},
}


@pytest.mark.parametrize("value", FOREIGN.values(), ids=FOREIGN)
def test_nothing_else_is_packed(value):
    with pytest.raises(TreeError, match="expected"):
        packed(value)


@pytest.mark.parametrize(
    "node",
    [
        {"os:system": {"command": "true"}},
        {"..os:System": {}},
        {"host.atomic:write_atomic": {}},
        {"march.witness:Worst": {}},  # a record, but of another module
        {"march.clock:Clock": {}},  # of the package, but no record
        {"march.state:Nothing": {}},
        {"no_room:State": {}},
        {"joints.state:JointState": {"adhesion": 1.0}},
        {"array": 7},
        {"tuple": 1},
        {"float": "one"},
        {"unknown": 1},
        {"array": 0, "tuple": []},
    ],
    ids=str,
)
def test_nothing_else_is_made(node):
    with pytest.raises(TreeError):
        unpacked(node, [])


def test_contiguous_makes_what_would_be_read():
    view = np.arange(12.0).reshape(3, 4)[:, 1]
    whole = np.arange(3.0)
    made = contiguous((view, [whole], "a"))
    assert made[0].flags.c_contiguous
    assert made[0].tobytes() == view.tobytes()
    assert made[1][0] is whole
    kept = (whole, None)
    assert contiguous(kept) is kept


def test_differences_are_told():
    one = JointState.intact(4, 2)
    assert differences(one, JointState.dry(4, 2), "joints") == []
    told = differences(one, JointState.intact(5, 2), "joints")
    assert (
        "joints.adhesion is an array float64 of shape (4,), expected an array float64 of shape (5,)" in told
    )
    assert differences((1.0, None), (1.0, one), "it") == ["it.1 is nothing, expected a JointState"]
    assert differences((1,), (1, 2), "it") == ["it has 1 parts, expected 2"]

"""Tables of a run in Python: what their files hold, as arrays."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from masonry_fem import run
from masonry_fem.errors import OutputError
from masonry_fem.scene import loads

STACK = """
dimension = 2
fidelity = "rigid"
materials.stone = { density = 2000, compressive_strength = "10 MPa", tensile_strength = "1 MPa" }
structures = [{ kind = "stack", name = "s", material = "stone", size = [1.0, 1.0], count = 3 }]
joints = [{ friction = 0.5 }]
loads.gravity = [0.0, -10.0]
output = { pictures = false, interfaces = true }
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run(loads(STACK), tmp_path_factory.mktemp("out"))


def test_tables_are_arrays_with_the_files_headings(result):
    stones = result.table("stones")
    assert list(stones["block"]) == ["s.b1", "s.b2", "s.b3"]
    np.testing.assert_allclose(stones["volume [m2]"], 1.0)
    assert stones["volume [m2]"].dtype == float
    joints = result.table("interfaces")
    (force,) = [values for head, values in joints.items() if head.startswith("normal_force")]
    np.testing.assert_allclose(np.sort(force), [20e3, 40e3, 60e3])
    assert set(result.table("history")) > {"time", "step"}


def test_a_table_that_is_not_there_is_named_with_those_that_are(result):
    with pytest.raises(OutputError, match=r"no table 'determinacy'.*'history', 'interfaces', 'stones'"):
        result.table("determinacy")
    with pytest.raises(OutputError, match=r"output.determinacy = true"):
        result.table("determinacy")
    with pytest.raises(OutputError, match=r"no table 'stnes'.*; did you mean 'stones'\?$"):
        result.table("stnes")


def test_a_data_frame_has_the_same_columns_or_says_what_to_install(result):
    if importlib.util.find_spec("pandas") is None:
        with pytest.raises(OutputError, match="pandas is not installed"):
            result.table("stones", frame=True)
    else:
        assert list(result.table("stones", frame=True)) == list(result.table("stones"))


def test_empty_cells_of_numbers_are_nan(result):
    stones = result.table("stones")
    assert np.isnan(stones["utilisation_greatest [-]"]).all()  # of rigid stones only the mean is known
    assert np.isfinite(stones["utilisation_of_mean [-]"]).all()

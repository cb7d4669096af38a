"""Which blocks get finer elements, and how the scene says so."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.analyses.marking import LEAST, MOST, halved, marked, mesh_overrides
from masonry_fem.scene.selector import select
from masonry_fem.scene.specs import MeshSettings
from tests.fem.meshes import box_mesh

SQUARES = st.lists(st.floats(0, 1e6), min_size=1, max_size=30).filter(lambda values: sum(values) > 1e-3)


@given(SQUARES, st.floats(0, 1))
def test_marked_blocks_have_their_part_of_the_error(squares, allowed):
    square = np.array(squares)
    chosen = marked(square, np.ones(len(square)), allowed * square.sum())
    part = np.clip((1 - allowed) / 0.75, LEAST, MOST)
    assert square[chosen].sum() >= part * square.sum() * (1 - 1e-9)
    if not chosen.all():
        assert square[chosen].min() >= square[~chosen].max()


def test_blocks_alike_are_marked_alike():
    square = np.array([1.0, 1.001, 1.0, 0.2, 0.2, 0.0])
    assert marked(square, np.ones(6), 3.0).tolist() == [True] * 3 + [False] * 3


def test_many_elements_count_against_a_block():
    """The same error costs less to halve where there are few elements."""
    assert marked(np.array([1.0, 1.0]), np.array([64.0, 8.0]), 1.5).tolist() == [False, True]


def test_elements_without_error_stay():
    assert not marked(np.zeros(3), np.ones(3), 0.0).any()


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (MeshSettings(divisions=(4, 2)), MeshSettings(divisions=(8, 4))),
        (MeshSettings(size=0.25, element="Q2"), MeshSettings(size=0.125, element="Q2")),
        (MeshSettings(), MeshSettings(divisions=(4, 4))),
    ],
)
def test_elements_are_halved(settings, expected):
    mesh = box_mesh("quad", (2, 2), (0.0, 0.0), (1.0, 0.5))
    assert halved(settings, mesh, 0.5) == expected


def test_unstructured_elements_get_half_their_mean_size():
    mesh = box_mesh("triangle", (5, 5), (0.0, 0.0), (1.0, 1.0))
    assert halved(MeshSettings(element="P1"), mesh, 1.0).size == pytest.approx(
        0.5 * np.sqrt(1 / 50), rel=1e-3
    )


def test_overrides_name_whole_groups_and_give_each_block_its_elements():
    coarse, fine = MeshSettings(size=0.5), MeshSettings(size=0.25)
    groups = {f"w.c{c}.b{b}": ("w", f"w.c{c}") for c in (1, 2) for b in (1, 2)}
    wanted = {"w.c1.b1": fine, "w.c1.b2": fine, "w.c2.b1": coarse, "w[1]": coarse}
    groups["w[1]"] = ()
    made = mesh_overrides(wanted, groups)
    assert made[0].blocks == "w.c1"
    names = [(name, *own) for name, own in groups.items()]
    given_to = {names[i][0]: one.mesh for one in made for i in select(one.blocks, names, "")}
    assert given_to == wanted
    assert msgspec.structs.asdict(made[0])["fidelity"] is None

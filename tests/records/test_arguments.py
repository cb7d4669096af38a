"""What scripts pass to functions in other forms than were meant."""

import pytest

from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.records.record import check_share
from masonry_fem.scene.overrides import apply, texts


def test_one_text_is_as_good_as_a_list_of_one():
    assert texts("a=1") == texts(["a=1"]) == ("a=1",)
    one, other = {}, {}
    assert apply(one, "mesh.size=0.1") == apply(other, ["mesh.size=0.1"])
    assert one == other == {"mesh": {"size": 0.1}}


def test_a_pair_is_no_override():
    with pytest.raises(SceneError, match=r"override \('a', 1\), expected a text key=value"):
        apply({}, [("a", 1)])


@pytest.mark.parametrize("value", ["5%", 0.0, 1.0, float("nan")])
def test_a_share_is_a_number_between_0_and_1(value):
    with pytest.raises(MasonryError, match=r"target is .*, expected a number between 0 and 1"):
        check_share("target", value)

"""tools/docstrings.py: which public things say what their parameters are, and what they raise."""

import importlib.util

import pytest

# rooms in which all do; this list only grows
DONE = [
    "analyses",
    "bodies",
    "build",
    "cli",
    "contact",
    "fem",
    "fidelities",
    "host",
    "importing",
    "joints",
    "limit",
    "march",
    "meshing",
    "nscd",
    "output",
    "records",
    "results",
    "scene",
    "solid",
    "structures",
]


@pytest.fixture(scope="module")
def docstrings(repository):
    """The module tools/docstrings.py."""
    spec = importlib.util.spec_from_file_location("docstrings", repository / "tools/docstrings.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def undescribed(docstrings, repository):
    """Room and place of what in the package does not say it."""
    return docstrings.bare(repository / "masonry_fem")


@pytest.mark.parametrize("room", DONE)
def test_public_things_of_a_room_say_what_they_take_and_raise(undescribed, repository, room):
    assert (repository / "masonry_fem" / room).is_dir()
    assert [line for where, line in undescribed if where == room] == []


def test_what_others_use_and_does_not_say_it_is_found(docstrings, tmp_path):
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "one.py").write_text(
        '''
def bare(a, b): """One line."""
def told(a, b):
    """One line.

    Parameters
    ----------
    a, b : Numbers.
    """
def alone(a, b): """Used by nobody."""
def single(a): """One parameter."""
class Pair:
    """Two fields."""
    a: int
    b: int
class Made:
    """Two parameters."""
    def __init__(self, a, b): ...
def refuses(a):
    """Raises, in a block of its own, and does not say so."""
    if a:
        raise ValueError(a)
def passes_on(a):
    """Raises what others have made."""
    try:
        single(a)
    except ValueError:
        raise
    raise AssertionError("never")
class Shape(Protocol):
    """Nobody makes it."""
    a: int
    b: int
'''
    )
    (tmp_path / "two.py").write_text(
        "from room.one import bare, told, single, Pair, Shape, refuses, passes_on\nroom.one.Made\n"
    )
    found = docstrings.bare(tmp_path)
    assert {room for room, _ in found} == {"room"}
    assert [line.split(": ", 1)[1] for _, line in found] == [
        "bare: Parameters", "Pair: Parameters", "Made: Parameters", "refuses: Raises",
    ]  # fmt: skip

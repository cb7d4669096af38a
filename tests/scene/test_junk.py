"""Junk anywhere in a scene is refused in words that name the place, never with a traceback."""

import contextlib
import tomllib

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.errors import SceneError
from masonry_fem.scene import loads
from masonry_fem.scene.misfit import path_text

JUNK = st.sampled_from(
    [None, True, -1, 0, 1e400, float("nan"), 10**400, "", "{0}", "10 kg", "1 m/", "[", [], [1], [[]], {},
     {"a": 1}, [{}], [{"name": "x"}], "*", "/", "é\n", 2**70, -0.0]
)  # fmt: skip


def places(tree, path=()):
    """Every path of a tree."""
    if path:
        yield path
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, item in items:
        yield from places(item, (*path, key))


@settings(max_examples=150)
@given(st.data())
def test_junk_is_refused_or_harmless(everything_tree, data):
    tree, base = everything_tree
    tree = tomllib.loads(tomli_w.dumps(tree))  # a copy
    path = data.draw(st.sampled_from(list(places(tree))))
    junk = data.draw(JUNK)
    inner = tree
    for key in path[:-1]:
        inner = inner[key]
    if junk is None:
        del inner[path[-1]]
    elif data.draw(st.booleans()) and isinstance(inner, dict):
        inner["surprise"] = junk
        path = (*path[:-1], "surprise")
    else:
        inner[path[-1]] = junk
    text = tomli_w.dumps(tree)
    try:
        loads(text, base=base, source="junk")
    except SceneError as error:
        sentence = str(error)
        assert sentence.startswith("junk")
        assert "\n" not in sentence.replace("é\n", "")
        assert "surprise" in sentence if path[-1] == "surprise" else ": " in sentence


@pytest.fixture(scope="module")
def everything_tree(everything):
    return tomllib.loads(everything.read_text()), everything.parent


@settings(max_examples=300)
@given(st.data())
def test_cut_text_is_refused_or_harmless(arch, data):
    start = data.draw(st.integers(0, len(arch)))
    end = data.draw(st.integers(start, min(len(arch), start + 30)))
    with contextlib.suppress(SceneError):
        loads(arch[:start] + data.draw(st.sampled_from(["", "[", '"', "=", ".", "\n", "0"])) + arch[end:])


@settings(max_examples=200)
@given(st.text(alphabet="abz019.=[]{}\"' -", max_size=20))
def test_any_override_is_refused_or_harmless(arch, text):
    with contextlib.suppress(SceneError):
        loads(arch, (text, f"structures.{text}", f"loads.gravity={text}"))


def test_paths_are_told_as_overrides_take_them():
    tree = {"structures": [{"name": "a"}, {"name": "b"}, {"name": "b"}, {}]}
    told = [path_text(("structures", index, "size", 0), tree) for index in range(4)]
    assert told == [
        "structures.a.size.0",
        "structures.1.size.0",
        "structures.2.size.0",
        "structures.3.size.0",
    ]

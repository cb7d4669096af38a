"""Writing scenes: what is written reads back to an equal scene, whatever the scene."""

import math
import typing

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec import inspect

from masonry_fem.scene import check, dumps, load, loads, save
from masonry_fem.scene.expectation import bare, tables_of
from masonry_fem.scene.fitting import LARGEST, fitted
from masonry_fem.scene.specs import Scene


def values(kind: inspect.Type, dimension: int) -> st.SearchStrategy[object]:  # noqa: PLR0911
    """Plain values that fit an annotation."""
    whole, (kind, _) = kind, bare(kind)
    match kind:
        case inspect.FloatType():
            return numbers(kind)
        case inspect.IntType():
            return st.integers(kind.ge, 10**6 if kind.le is None else kind.le)
        case inspect.BoolType():
            return st.booleans()
        case inspect.LiteralType():
            return st.sampled_from(kind.values)
        case inspect.StrType() if kind.pattern and "/" in kind.pattern:
            return st.from_regex(kind.pattern, fullmatch=True)
        case inspect.StrType() if kind.pattern and kind.pattern.startswith("^[a-z]"):
            return st.from_regex(r"[a-z][a-z_]{0,8}(\.[a-z]{1,8})?", fullmatch=True)
        case inspect.StrType() if kind.pattern:
            return st.from_regex(r"[a-zA-Zµé][a-zA-Z0-9_-]{0,8}", fullmatch=True)
        case inspect.StrType():
            return st.text(min_size=kind.min_length or 0, max_size=20)
        case inspect.VarTupleType() if kind.max_length == 3:
            size = dimension if kind.min_length == 2 else 3
            return st.lists(values(kind.item_type, dimension), min_size=size, max_size=size)
        case inspect.VarTupleType():
            return st.lists(values(kind.item_type, dimension), min_size=kind.min_length or 0, max_size=2)
        case inspect.TupleType():
            return st.tuples(*(values(one, dimension) for one in kind.item_types)).map(list)
        case inspect.DictType():
            items = (values(kind.key_type, dimension), values(kind.value_type, dimension))
            return st.dictionaries(*items, max_size=2)
        case inspect.UnionType():
            parts = [one for one in kind.types if not isinstance(one, inspect.NoneType)]
            return st.one_of(*(values(one, dimension) for one in parts))
        case inspect.StructType():
            return st.one_of(*(tables(one(), dimension) for one in tables_of(whole).values()))
    raise AssertionError(f"no strategy for {kind}")


def numbers(kind: inspect.FloatType) -> st.SearchStrategy[float]:
    low = kind.gt if kind.gt is not None else kind.ge
    high = kind.lt if kind.lt is not None else kind.le
    if kind.multiple_of is not None:
        return st.integers(math.ceil(low / kind.multiple_of), 99).map(lambda n: n * kind.multiple_of)
    low, high = -LARGEST if low is None else low, LARGEST if high is None else high
    return st.floats(
        low, high, exclude_min=kind.gt is not None, exclude_max=kind.lt is not None,
        allow_nan=False, allow_infinity=False, allow_subnormal=False,
    )  # fmt: skip


def tables(kind: inspect.StructType, dimension: int) -> st.SearchStrategy[dict[str, object]]:
    fields = {field.encode_name: values(field.type, dimension) for field in kind.fields}
    if kind.cls is Scene:
        fields["dimension"] = st.just(dimension)
    needed = {name: fields[name] for name in fields if name in required(kind)}
    free = {name: fields[name] for name in fields if name not in required(kind)}
    tag = {kind.tag_field: st.just(kind.tag)} if kind.tag_field else {}
    return st.fixed_dictionaries({**tag, **needed}, optional=free)


def required(kind: inspect.StructType) -> set[str]:
    names = {field.encode_name for field in kind.fields if field.required}
    return names | ({"dimension"} if kind.cls is Scene else set())


SCENE = typing.cast(inspect.StructType, inspect.type_info(Scene))
SCENES = st.sampled_from([2, 3]).flatmap(lambda dimension: tables(SCENE, dimension))


@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large], max_examples=20)
@given(SCENES)
def test_any_scene_survives_writing_and_reading(tree):
    scene = fitted(tree, SCENE, (), tree["dimension"])
    assert fitted(msgspec.toml.decode(dumps(scene)), SCENE, (), scene.dimension) == scene


def test_the_scene_with_every_record_survives(everything, tmp_path):
    scene = load(everything)
    assert loads(dumps(scene), base=everything.parent) == scene
    assert check(scene, base=everything.parent) == scene
    save(scene, tmp_path / "scene.toml")
    for name in ("quake.csv", "rubble.msh"):
        (tmp_path / name).write_bytes((everything.parent / name).read_bytes())
    assert load(tmp_path / "scene.toml") == scene


def test_what_is_default_is_not_written(arch):
    text = dumps(loads(arch))
    assert "poisson" not in text
    assert "joints" not in text
    assert "gravity = [0.0, -9.81]" in text


@pytest.mark.parametrize("title", ['say "x"', "x = [\n1,\n]", "é µ\t\\", "[\n    'a',\n]", ""])
def test_odd_texts_survive(arch, title):
    scene = msgspec.structs.replace(loads(arch), title=title)
    assert loads(dumps(scene)) == scene

"""Mutation: scenes and files changed a little, so that they are wrong in ways that nobody thought of.

    text = mutated_scene(trees, random.Random("0:17"))       # TOML
    data = mutated_file(".stl", data, random.Random("0:17"))   # bytes

The same random numbers make the same change.
"""

from __future__ import annotations

import copy
import io
import json
import re
from collections.abc import Callable, Iterator
from random import Random
from typing import Any

import numpy as np
import tomli_w

Tree = dict[str, Any]

NUMBERS = (
    0, -1, 1, 2, 3, 1e-300, 1e-12, 1e-3, 1e3, 1e6, 1e15, 1e300, 5e-324, -1e-9, -0.0, float("nan"),
    float("inf"), -float("inf"), 2**31, 2**63, 10**30, 0.5, 90, 360, 1e9,
)  # fmt: skip
TEXTS = (
    "", "*", "/", "*/*", "a", "[", "[!a]*", "?", "..", "../..", ".", "x" * 3000, "é\n", "\u202e", "\x01",
    "{0}", "%s", "nan", "inf", "5 mm", "3 Pa", "10 kg", "1e400 m", "-2 m", "m", "1/m", "1 m m m", "0 GPa",
    "1e9 GPa", "2 min", "1e-30 s", "10**9**9 m", "4 GB", "no slip", "../../etc/passwd", "/dev/zero",
    "/dev/null", "scene.toml", "aux.csv",
)  # fmt: skip
JUNK: tuple[Any, ...] = (True, False, [], {}, [[]], [{}], [1], [1, 2], [1, 2, 3], {"kind": "x"}, {"a": 1})
WORDS = (
    "nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "0", "-1", "1", "2", "7", "99999999999999999999",
    "4294967296", "2147483648", "-2147483649", "1e999", "x", "", "1,5", '"', "é", "\\", "0x10", "1_0", "#1",
    "*", "$",
)  # fmt: skip


# --- scenes -----------------------------------------------------------------------------------


def mutated_scene(trees: list[Tree], random: Random) -> str:
    """One of the scenes with one to four changes, as text."""
    tree = copy.deepcopy(random.choice(trees))
    for _ in range(_few(random)):
        _change(tree, trees, random)
    try:
        text = tomli_w.dumps(tree)
    except (TypeError, ValueError, OverflowError):  # what TOML has no form for
        text = tomli_w.dumps(random.choice(trees))
    return _torn(text, random) if random.random() < 0.08 else text


def _few(random: Random) -> int:
    count = 1
    while count < 4 and random.random() < 0.3:
        count += 1
    return count


def _places(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if path:
        yield path
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, inner in items:
        yield from _places(inner, (*path, key))


def _at(tree: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        tree = tree[key]
    return tree


def _change(tree: Tree, trees: list[Tree], random: Random) -> None:
    places = list(_places(tree))
    if not places:
        return
    path = random.choice(places)
    owner, key = _at(tree, path[:-1]), path[-1]
    how = random.random()
    if how < 0.12:
        del owner[key]
    elif how < 0.22:
        _repeat(owner, key, random)
    elif how < 0.32 and isinstance(owner, dict):
        _rename(owner, key, random)
    elif how < 0.50:
        other = random.choice(trees)
        found = [one for one in _places(other) if one[-1] == key]
        if found:
            owner[key] = copy.deepcopy(_at(other, random.choice(found)))
        elif isinstance(owner, dict):
            donor = random.choice(list(_places(other)))
            owner[str(donor[-1])] = copy.deepcopy(_at(other, donor))
    else:
        owner[key] = _other(owner[key], random)


def _repeat(owner: Any, key: Any, random: Random) -> None:
    if isinstance(owner, list):
        owner.extend(copy.deepcopy(owner[key]) for _ in range(random.choice((1, 1, 1, 40))))
    else:
        other = random.choice(list(owner))
        owner[key], owner[other] = owner[other], owner[key]


def _rename(owner: Tree, key: str, random: Random) -> None:
    at = random.randrange(len(key) + 1)
    name = random.choice((key[:at] + "x" + key[at:], key[:at] + key[at + 1 :], key.upper(), "kind", ""))
    owner[name] = owner.pop(key)


def _other(value: Any, random: Random) -> Any:
    """A value in place of another, mostly of the same kind."""
    if random.random() < 0.15:
        return copy.deepcopy(random.choice((*JUNK, *NUMBERS, *TEXTS)))
    if isinstance(value, int | float):
        return _number(value, random)
    torn = random.random() < 0.5
    if isinstance(value, str):
        return _torn(value, random) if value and torn else random.choice(TEXTS)
    if isinstance(value, list):
        return [*value, *value[:1]] if torn else value[:-1]
    return copy.deepcopy(random.choice((*JUNK, *NUMBERS)))


def _number(value: float, random: Random) -> Any:
    if isinstance(value, bool):
        return not value
    if random.random() < 0.5:
        return random.choice(NUMBERS)
    return type(value)(value * random.choice((10, 0.1, 2, 0.5, -1, 1 + 1e-15, 1.1, 1e3, 1e-3)))


def _torn(text: str, random: Random) -> str:
    """Text with a piece left out, doubled or replaced."""
    start = random.randrange(len(text) + 1)
    end = min(len(text), start + int(random.expovariate(0.1)))
    middle = random.choice(("", text[start:end] * 2, *TEXTS, "[", "]", '"', "=", "\n", "0", "'''"))
    return text[:start] + middle + text[end:]


# --- files ------------------------------------------------------------------------------------


def mutated_file(ending: str, data: bytes, random: Random) -> bytes:
    """The file with one to four changes, each by a way that its kind has."""
    ways = [*WAYS, *OWN_WAYS.get(ending, ())]
    for _ in range(_few(random)):
        data = random.choice(ways)(data, random)
    return data


def _flipped(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(random.choice((1, 1, 4, 32)) if data else 0):
        changed[random.randrange(len(data))] = random.randrange(256)
    return bytes(changed)


def _cut(data: bytes, random: Random) -> bytes:
    return data[: random.randrange(len(data) + 1)]


def _pieced(data: bytes, random: Random) -> bytes:
    """A piece left out, doubled, or put elsewhere."""
    start = random.randrange(len(data) + 1)
    end = min(len(data), start + int(random.expovariate(0.01)))
    place = random.randrange(len(data) + 1)
    piece, left = data[start:end], data[:start] + data[end:]
    return random.choice((left, data[:place] + piece + data[place:], left[:place] + piece + left[place:]))


def _lined(data: bytes, random: Random) -> bytes:
    """Lines left out, doubled or changed for each other."""
    lines = data.split(b"\n")
    one, two = random.randrange(len(lines)), random.randrange(len(lines))
    how = random.randrange(3)
    if how == 0:
        del lines[one]
    elif how == 1:
        lines.insert(two, lines[one])
    else:
        lines[one], lines[two] = lines[two], lines[one]
    return b"\n".join(lines)


def _numbered(data: bytes, random: Random) -> bytes:
    """Numbers in the text changed for others."""
    found = list(re.finditer(rb"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", data))
    for one in sorted(
        random.sample(found, min(len(found), random.choice((1, 1, 2, 8)))), key=_end, reverse=True
    ):
        word = random.choice((random.choice(WORDS).encode(), random.choice(found)[0]))
        data = data[: one.start()] + word + data[one.end() :]
    return data


def _end(found: re.Match[bytes]) -> int:
    return found.end()


def _emptied(data: bytes, random: Random) -> bytes:
    return random.choice(
        (b"", b"\n", b"\x00" * 100, b"\xff\xfe" + data, b"\xef\xbb\xbf" + data, data + data, b" " + data)
    )


def _retreed(data: bytes, random: Random) -> bytes:
    """A change of the tree in JSON."""
    try:
        tree = json.loads(data)
    except (ValueError, RecursionError):
        return data
    if random.random() < 0.05:
        return b"[" * 100_000 + b"]" * 100_000
    if isinstance(tree, dict):
        _change(tree, [tree], random)
    return json.dumps(tree).encode()


def _programmed(data: bytes, random: Random) -> bytes:
    """Statements that a program may hold."""
    line = random.choice((
        "For i In {1:1e12}\n  a = i;\nEndFor", 'SystemCall "touch ran";', "Exit;", "Abort;", "Error('x');",
        "Mesh 3;",
        'Merge "nothing.msh";', 'Include "nothing.geo";', 'Save "ran.msh";', "Mesh.Algorithm3D = 99;",
        "Delete All;",
        "Box(1) = {0, 0, 0, 0, 0, 0};", "Sphere(9) = {0, 0, 0, 1e300};", "Mesh.MeshSizeMax = 1e-9;",
        "Point(1) = {1/0, 0, 0};",
        'Physical Volume("a/b*?") = {1};', "Recombine Surface {:};", "Mesh.ElementOrder = 7;",
        "General.NumThreads = 64;",
    ))  # fmt: skip
    lines = data.split(b"\n")
    lines.insert(random.randrange(len(lines) + 1), line.encode())
    return b"\n".join(lines)


def _reworded(data: bytes, random: Random) -> bytes:
    """A word of a program in the place of another."""
    words = list(re.finditer(rb"[A-Za-z_]+", data))
    if not words:
        return data
    one, other = random.choice(words), random.choice(words)
    return data[: one.start()] + other[0] + data[one.end() :]


def _rearranged(data: bytes, random: Random) -> bytes:
    """A change of one array of an ``.npz`` file."""
    try:
        with np.load(io.BytesIO(data)) as file:
            arrays = {name: file[name] for name in file.files}
    except Exception:
        return data
    name = random.choice(sorted(arrays))
    one = arrays.pop(name)
    flat = np.array(one, dtype=one.dtype).ravel()
    if flat.size and flat.dtype.kind in "fiu":
        flat[random.randrange(flat.size)] = random.choice(
            (0, 1, -1, 2**31 - 1) if flat.dtype.kind in "iu" else NUMBERS[:18]
        )
    numbers = one.dtype.kind in "fiu"
    choices: tuple[Any, ...] = (
        None, flat.reshape(one.shape), flat, one[..., None], one.T, one[:1] if one.ndim else one[None],
        one.astype(np.float32) if numbers else one, one.astype(complex) if numbers else one,
        np.zeros(0), np.array("text"), np.array([{"a": 1}], dtype=object),
    )  # fmt: skip
    put = random.choice(choices)
    if put is not None:
        arrays[name] = put
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


Way = Callable[[bytes, Random], bytes]
WAYS: tuple[Way, ...] = (_flipped, _cut, _pieced, _lined, _numbered, _numbered, _numbered, _emptied)
OWN_WAYS: dict[str, tuple[Way, ...]] = {
    ".json": (_retreed,) * 6,
    ".geo": (_programmed,) * 4,
    ".py": (_reworded,) * 12,
    ".npz": (_rearranged,) * 12,
}

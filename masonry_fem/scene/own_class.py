"""Own class: what a user wrote in a Python file beside the scene, made with the scene's parameters.

    JOINT_LAW = Kind(Law, "joint law", "masonry_fem.joints.Law", LawError)
    own = OwnClass("cork.py", "Cork", "law")
    law = made(JOINT_LAW, own, base, key, lambda accepted: parameters)

The file is run as a module of its own, outside the package, each time a scene is built.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
import zlib
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, override

from masonry_fem.errors import SceneError
from masonry_fem.scene.misfit import listed, nearest


@dataclass(frozen=True, slots=True)
class Kind[T]:
    """What a class is to be.

    Attributes
    ----------
    base : It derives from this. name : What messages call it. path : Where users import ``base`` from.
    refusal : Error by which it refuses its parameters.
    """

    base: type[T]
    name: str
    path: str
    refusal: type[Exception]


@dataclass(frozen=True, slots=True)
class OwnClass:
    """Where a class stands.

    Attributes
    ----------
    file : A ``.py`` file, relative to the scene. name : Of the class. key : Of the scene, that has the name.
    """

    file: str
    name: str
    key: str


def made[T](
    kind: Kind[T],
    own: OwnClass,
    base: Path,
    key: str,
    parameters: Callable[[Collection[str]], Mapping[str, Any]],
) -> T:
    """What a class in a file makes of the scene's parameters.

    Parameters
    ----------
    kind : What it is to be. own : Where it stands.
    base : Folder of the scene file. key : Where its record stands in the scene, for messages.
    parameters : Gives its keywords, told the names of those that it takes.

    Raises
    ------
    SceneError : Where the file cannot be run, has no such class, or the class refuses its parameters.
    """
    path = base / own.file
    found = _class(kind, _run(path, key), own, path, key)
    accepted, others = _parameters(found)
    given = parameters(accepted)
    if not others:
        _refuse_unknown(given, accepted, own, path, key)
    _refuse_missing(given, accepted, own, path, key)
    try:
        return found(**given)
    except kind.refusal as error:
        raise SceneError(f"{key}: {error}") from error
    except Exception as error:  # the user's code may raise anything
        raise SceneError(
            f"{key}: {own.name}({', '.join(f'{name}={value!r}' for name, value in given.items())}) of "
            f"'{path}' failed with {type(error).__name__}: {error}; expected a law (numbers without quotes, "
            "in SI units); correct the parameters or the class"
        ) from error


class _FreshLoader(SourceFileLoader):
    """Compiles the file as it is now and leaves no bytecode beside it."""

    @override
    def get_code(self, fullname: str) -> CodeType:
        return self.source_to_code(self.get_data(self.path), self.path)


def _run(path: Path, key: str) -> ModuleType:
    if not path.is_file():
        raise SceneError(f"{key}.file: '{path}' does not exist, expected a Python file with the law's class")
    # the name must be unique, so it contains the folder; dataclasses look their module up by it
    name = f"masonry_fem_law_{path.stem}_{zlib.crc32(str(path.resolve()).encode()):08x}"
    loader = _FreshLoader(name, str(path))
    origin = importlib.util.spec_from_file_location(name, path, loader=loader)
    assert origin is not None  # as a loader is given
    module = importlib.util.module_from_spec(origin)
    sys.modules[name] = module
    try:
        loader.exec_module(module)
    except Exception as error:  # the user's code may raise anything
        del sys.modules[name]
        line = _line_in(path, error)
        raise SceneError(
            f"{key}.file: '{path}'{line} failed with {type(error).__name__}: {error}; expected a file that "
            "Python imports; correct it"
        ) from error
    return module


def _line_in(path: Path, error: Exception) -> str:
    """``, line 12`` of the user's file, the innermost that the error went through."""
    if isinstance(error, SyntaxError):
        return ""  # its text has the line
    lines = []
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(path):
            lines.append(trace.tb_lineno)
        trace = trace.tb_next
    return f", line {lines[-1]}," if lines else ""


def _class[T](kind: Kind[T], module: ModuleType, own: OwnClass, path: Path, key: str) -> type[T]:
    found = getattr(module, own.name, None)
    if isinstance(found, type) and issubclass(found, kind.base):
        _check_class(kind, found, own, path, key)
        return found
    there = [
        name
        for name, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, kind.base) and value.__module__ == module.__name__
    ]
    if found is not None:
        shown = "a class" if isinstance(found, type) else f"a {type(found).__name__}"
        raise SceneError(
            f"{key}.{own.key}: '{own.name}' of '{path}' is {shown} that is no {kind.name}, expected one that "
            f"derives from {kind.path}{'; there is ' + listed(there) if there else ''}"
        )
    known = f"one of its laws {listed(there)}" if there else f"a class derived from {kind.path}"
    raise SceneError(
        f"{key}.{own.key} is '{own.name}', which '{path}' does not have, expected {known}"
        f"{nearest(own.name, there)}"
    )


def _check_class[T](kind: Kind[T], found: type[T], own: OwnClass, path: Path, key: str) -> None:
    """Refuse a class that lacks methods of its kind."""
    lacking = sorted(getattr(found, "__abstractmethods__", ()))
    if not isinstance(getattr(found, "name", None), str):
        lacking.insert(0, "name")
    if lacking:
        raise SceneError(
            f"{key}.{own.key}: '{own.name}' of '{path}' lacks {listed(lacking)}, expected all that "
            f"{kind.path} asks for; write it"
        )


def _parameters(found: type[Any]) -> tuple[dict[str, Any], bool]:
    """What the class takes as keywords, each with its default, and whether it takes any others, too."""
    taken = inspect.signature(found).parameters.values()
    named = {inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY}
    others = any(one.kind is inspect.Parameter.VAR_KEYWORD for one in taken)
    return {one.name: one.default for one in taken if one.kind in named}, others


def _refuse_unknown(
    given: Collection[str], accepted: Collection[str], own: OwnClass, path: Path, key: str
) -> None:
    unknown = [name for name in given if name not in accepted]
    if unknown:
        raise SceneError(
            f"{key}.parameters: unknown key {listed(unknown)} of '{own.name}' in '{path}', expected "
            f"{listed(accepted) or 'none'}{nearest(unknown[0], accepted)}"
        )


def _refuse_missing(
    given: Collection[str], accepted: Mapping[str, Any], own: OwnClass, path: Path, key: str
) -> None:
    needed = [name for name, default in accepted.items() if default is inspect.Parameter.empty]
    missing = [name for name in needed if name not in given]
    if missing:
        raise SceneError(
            f"{key}.parameters lacks {listed(missing)}, which '{own.name}' of '{path}' needs; give "
            f"{'it' if len(missing) == 1 else 'them'}"
        )

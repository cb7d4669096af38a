"""Law file: a joint law that a user wrote beside his scene, as a class of a Python file.

    spec = PythonLaw(file="cork.py", law="Cork", trusted=True, parameters={"stiffness": 1e9})
    law = law_of_file(spec, 0.6, base, key)

The file is run as a module of its own, outside the package, each time a scene is built.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
import zlib
from collections.abc import Collection, Mapping
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, override

from masonry_fem.errors import LawError, SceneError
from masonry_fem.joints.law import Law
from masonry_fem.joints.parameters import Parameter
from masonry_fem.scene import specs
from masonry_fem.scene.misfit import listed, nearest


def law_of_file(
    spec: specs.PythonLaw, friction: Parameter, base: Path, key: str, arrays: Mapping[str, Any] | None = None
) -> Law:
    """The law that a class in a file makes of the scene's parameters.

    Parameters
    ----------
    spec : File, class and parameters. friction : The joint's, for classes that take one.
    base : Folder of the scene file. key : Where the law stands in the scene, for messages.
    arrays : Parameters in the place of the scene's own, such as those that scatter.

    Raises
    ------
    SceneError : Where the file is not trusted, cannot be run, has no such law, or the law refuses its
        parameters.
    """
    for fault, expected in spec.faults():  # none, if the scene has been checked
        raise SceneError(f"{key}.{fault} is {getattr(spec, fault)!r}, expected {expected}")
    path = base / spec.file
    kind = _class(_run(path, key), spec, path, key)
    given: dict[str, Any] = {**(spec.parameters or {}), **(arrays or {})}
    accepted, others = _parameters(kind)
    if "friction" in accepted:
        given.setdefault("friction", friction)
    if not others:
        _refuse_unknown(given, accepted, spec, path, key)
    _refuse_missing(given, accepted, spec, path, key)
    try:
        return kind(**given)
    except LawError as error:
        raise SceneError(f"{key}: {error}") from error
    except Exception as error:  # the user's code may raise anything
        raise SceneError(
            f"{key}: {spec.law}({', '.join(f'{name}={value!r}' for name, value in given.items())}) of "
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


def _class(module: ModuleType, spec: specs.PythonLaw, path: Path, key: str) -> type[Law]:
    found = getattr(module, spec.law, None)
    if isinstance(found, type) and issubclass(found, Law):
        _check_class(found, spec, path, key)
        return found
    own = [
        name
        for name, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, Law) and value.__module__ == module.__name__
    ]
    if found is not None:
        shown = "a class" if isinstance(found, type) else f"a {type(found).__name__}"
        raise SceneError(
            f"{key}.law: '{spec.law}' of '{path}' is {shown} that is no joint law, expected one that derives "
            f"from masonry_fem.joints.Law{'; there is ' + listed(own) if own else ''}"
        )
    known = f"one of its laws {listed(own)}" if own else "a class derived from masonry_fem.joints.Law"
    raise SceneError(
        f"{key}.law is '{spec.law}', which '{path}' does not have, expected {known}{nearest(spec.law, own)}"
    )


def _check_class(kind: type[Law], spec: specs.PythonLaw, path: Path, key: str) -> None:
    """Refuse a class that lacks methods of ``Law``."""
    lacking = sorted(getattr(kind, "__abstractmethods__", ()))
    if not isinstance(getattr(kind, "name", None), str):
        lacking.insert(0, "name")
    if lacking:
        raise SceneError(
            f"{key}.law: '{spec.law}' of '{path}' lacks {listed(lacking)}, expected all that "
            "masonry_fem.joints.Law asks for; write it"
        )


def _parameters(kind: type[Law]) -> tuple[dict[str, Any], bool]:
    """What the class takes as keywords, each with its default, and whether it takes any others, too."""
    taken = inspect.signature(kind).parameters.values()
    named = {inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY}
    others = any(one.kind is inspect.Parameter.VAR_KEYWORD for one in taken)
    return {one.name: one.default for one in taken if one.kind in named}, others


def _refuse_unknown(
    given: Collection[str], accepted: Collection[str], spec: specs.PythonLaw, path: Path, key: str
) -> None:
    unknown = [name for name in given if name not in accepted]
    if unknown:
        raise SceneError(
            f"{key}.parameters: unknown key {listed(unknown)} of '{spec.law}' in '{path}', expected "
            f"{listed(accepted) or 'none'}{nearest(unknown[0], accepted)}"
        )


def _refuse_missing(
    given: Collection[str], accepted: Mapping[str, Any], spec: specs.PythonLaw, path: Path, key: str
) -> None:
    needed = [name for name, default in accepted.items() if default is inspect.Parameter.empty]
    missing = [name for name in needed if name not in given]
    if missing:
        raise SceneError(
            f"{key}.parameters lacks {listed(missing)}, which '{spec.law}' of '{path}' needs; give "
            f"{'it' if len(missing) == 1 else 'them'}"
        )

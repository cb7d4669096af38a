"""Discovery: what stands in the files of a folder, one thing a file.

    names(folders)                                                               # of the files, none loaded
    discovered("masonry_fem.structures", "wall", Structure, "structure").kind    # WallStructure

A file has one class derived from that of its room, and scene files call it by the name of the file. Folders
within the folder hold what several files share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from inspect import get_annotations
from pkgutil import iter_modules
from types import ModuleType, NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from msgspec import Struct

from masonry_fem.errors import ExtensionError


def names(folders: Iterable[str]) -> tuple[str, ...]:
    """Files of a folder, by name; none of them is loaded."""
    return tuple(file.name for file in iter_modules(folders) if not file.ispkg)


def function(module: str, signature: str, does: str) -> Any:
    """The function that a file owes, such as ``points(patch: Patch) -> Spots``.

    Parameters
    ----------
    module : Name of the file's module. signature : Of the function. does : What it does, for messages.

    Raises
    ------
    ExtensionError : The file does not have it.
    """
    file, name = import_module(module), signature.partition("(")[0]
    found = getattr(file, name, None)
    if not callable(found):
        raise ExtensionError(
            f"{file.__file__} has no function {name}, expected one that {does}; write def {signature}"
        )
    return found


@dataclass(frozen=True, slots=True)
class Found:
    """What a file holds.

    Attributes
    ----------
    kind : Its class. module : The file as Python imported it.
    """

    kind: Any
    module: ModuleType

    @property
    def file(self) -> str:
        """Where it stands."""
        return str(self.module.__file__)


def tag_of(record: Any) -> str | None:
    """The name of a record in scene files; None where it has none of its own."""
    tag = record.__struct_config__.tag
    return None if tag == record.__name__ else tag  # which msgspec takes where nothing is said


def discovered(
    package: str,
    name: str,
    base: Any,
    noun: str,
    name_of: Callable[[Any], object] = tag_of,
    naming: str = 'write class {kind}({base}, frozen=True, kw_only=True, tag="{name}")',
) -> Found:
    """What a file of a package holds.

    Parameters
    ----------
    package, name : Of the package and of the file. base : What its class derives from.
    noun : What it is, for messages. name_of : The name that the class has. naming : How it is given one.

    Raises
    ------
    ExtensionError : The file lacks its class or a method, or the class does not have the file's name.
    """
    module = import_module(f"{package}.{name}")
    one = Found(_only(module, base, noun), module)
    own = name_of(one.kind)
    if own != name:
        fault = "no name" if own is None else f"the name {own!r}"
        raise ExtensionError(
            f"{one.file}: {one.kind.__name__} has {fault}, expected {name!r}, that of its file, by which "
            f"scene files call it; {naming.format(kind=one.kind.__name__, base=base.__name__, name=name)}"
        )
    lacking = [key for key in dir(one.kind) if _owed(getattr(one.kind, key))]
    lacking += [key for key in get_annotations(base) if not hasattr(one.kind, key)]
    if lacking:
        raise ExtensionError(
            f"{one.file}: {one.kind.__name__} lacks {', '.join(lacking)}, expected all that "
            f"{base.__name__} asks for; write it"
        )
    if issubclass(one.kind, Struct):
        check_keys(one.kind, one.file)
    return one


def check_keys(record: type[Struct], file: str) -> None:
    """Refuse a record with a key that no scene file can fill.

    Parameters
    ----------
    record : What a scene says of a thing. file : Where the thing stands, for messages.

    Raises
    ------
    ExtensionError : The type of a key is not known, or is none of those that TOML has values of.
    """
    try:
        hints = get_type_hints(record, include_extras=True)
        fault = next((f"'{key}' is a {_word(hints[key])}" for key in record.__struct_fields__
                      if not _fillable(hints[key])), "")  # fmt: skip
    except (NameError, TypeError) as error:
        fault = str(error)
    if fault:
        raise ExtensionError(
            f"{file}: {record.__name__} gives no table of a scene file ({fault}), expected keys of types "
            "such as Length (masonry_fem/records/record.py), float, str, bool, Literal or tuple[float, ...]; "
            "give it one"
        )


def _fillable(hint: Any) -> bool:
    """Whether TOML has values of a type."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _fillable(parts[0])
    if origin in {Union, UnionType, tuple, dict}:
        return all(part is Ellipsis or _fillable(part) for part in parts)
    plain = hint in {float, int, str, bool, NoneType}
    return plain or origin is Literal or (isinstance(hint, type) and issubclass(hint, Struct))


def _word(hint: Any) -> str:
    return hint.__name__ if isinstance(hint, type) else str(hint)


def _owed(member: Any) -> bool:
    """Whether a method or a property was left abstract."""
    return getattr(member, "__isabstractmethod__", False) is True


def _only(module: ModuleType, base: Any, noun: str) -> Any:
    """The class of a file that derives from ``base``."""
    own = [
        one
        for one in vars(module).values()
        if isinstance(one, type) and issubclass(one, base) and one.__module__ == module.__name__
    ]
    if len(own) != 1:
        raise ExtensionError(
            f"{module.__file__} has {len(own)} classes of a {noun} "
            f"({', '.join(one.__name__ for one in own) or 'none'}), expected one, derived from "
            f"{base.__name__}; put each into a file of its own, and what is no {noun} into the folder 'parts'"
        )
    return own[0]

"""Discovery: the structures of a folder, found by importing its files.

    discovered("masonry_fem.structures", folders)["wall"].build(spec, 3)

A file has one record, whose ``kind`` is its name in scene files, and a function ``build`` that makes its
blocks. Subfolders are not searched.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

from masonry_fem.errors import ExtensionError
from masonry_fem.records.structure import Structure
from masonry_fem.solid.assembly import Assembly


@dataclass(frozen=True, slots=True)
class Kind:
    """A structure that scene files can ask for.

    Attributes
    ----------
    record : What a scene file says of it. file : Where record and ``build`` stand.
    build : Makes its blocks from record and dimension; with a ``source`` from folder and mesh settings, too.
    """

    record: type[Structure]
    build: Callable[..., Assembly]
    file: str


def discovered(package: str, folders: Iterable[str]) -> Mapping[str, Kind]:
    """Kinds of structures in a package by name, in the order of their files.

    Parameters
    ----------
    package : Its dotted name.
    folders : Folders that hold its files (``__path__``).

    Raises
    ------
    ExtensionError : A file lacks its record, its kind or its ``build``, or has the kind of another.
    """
    found: dict[str, Kind] = {}
    for file in iter_modules(folders):
        if file.ispkg:
            continue
        name, kind = _kind(import_module(f"{package}.{file.name}"))
        if name in found:
            raise ExtensionError(
                f"{kind.file} and {found[name].file} both have the kind '{name}', expected a kind of its own "
                "for each; give one of the records another tag"
            )
        found[name] = kind
    return found


def _kind(module: ModuleType) -> tuple[str, Kind]:
    """The structure of a file, and its name."""
    file = str(module.__file__)
    records = [
        one
        for one in vars(module).values()
        if isinstance(one, type) and issubclass(one, Structure) and one.__module__ == module.__name__
    ]
    if len(records) != 1:
        names = ", ".join(one.__name__ for one in records) or "none"
        raise ExtensionError(
            f"{file} has {len(records)} records of a structure ({names}), expected one: a class derived from "
            "Structure; put each into a file of its own, and what is no structure into the folder 'parts'"
        )
    (record,) = records
    name = record.__struct_config__.tag
    if name == record.__name__:  # msgspec's default if the record gives no tag
        raise ExtensionError(
            f"{file}: {name} has no kind, expected the name that scene files call it by; write "
            f'class {name}(Structure, frozen=True, kw_only=True, tag="name")'
        )
    build = getattr(module, "build", None)
    if not callable(build):
        raise ExtensionError(
            f"{file} has no function build, expected one that makes the blocks of a {record.__name__}; write "
            f"def build(spec: {record.__name__}, dimension: int) -> Assembly"
        )
    return str(name), Kind(record, build, file)

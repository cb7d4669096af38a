"""Reading: from TOML text, or from Python objects, to a scene that has been checked.

    scene = load("arch.toml", overrides=("structures.arch.voussoirs=21",))
    scene = check(Scene(materials=..., structures=...))

Both make the same two checks: each value against its annotation (``fitting``), then the parts of the scene
against each other (``checks``).
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from msgspec import inspect

from masonry_fem.errors import SceneError
from masonry_fem.records.remark import remark
from masonry_fem.scene.checks import cross_check, doubts
from masonry_fem.scene.fitting import fitted
from masonry_fem.scene.lines import KeyPath, key_lines, line_of
from masonry_fem.scene.misfit import MisfitError, path_text
from masonry_fem.scene.overrides import apply
from masonry_fem.scene.problem_file import with_conditions
from masonry_fem.scene.specs import Scene
from masonry_fem.scene.writing import plain

DEEPEST = 100  # nested tables and lists; scenes have a handful of levels
_DEEP_KEY = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}")


def load(path: str | Path, overrides: Iterable[str] = ()) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : TOML file; paths in it are relative to its folder.
    overrides : Texts ``dotted.key=value`` that replace or add values, such as ``"joints.0.friction=0.4"``.

    Raises
    ------
    SceneError : The file cannot be read, or describes something impossible.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise SceneError(f"{path}: no such scene file; expected a TOML file") from error
    except IsADirectoryError as error:
        raise SceneError(f"{path}: is a folder; expected a TOML file") from error
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read as UTF-8 text ({error})") from error
    return loads(text, overrides, base=path.parent, source=str(path))


def loads(
    text: str, overrides: Iterable[str] = (), *, base: str | Path = ".", source: str = "scene"
) -> Scene:
    """Read a scene from TOML text.

    Parameters
    ----------
    text : TOML.
    overrides : Texts ``dotted.key=value``.
    base : Folder that relative paths in the scene start from.
    source : What messages call the text.

    Raises
    ------
    SceneError : The text is no TOML, or no scene.
    """
    deep = f"{source}: tables or lists within one another, expected at most {DEEPEST}; write it plainly"
    if _DEEP_KEY.search(text):  # tomllib would take minutes
        raise SceneError(deep)
    try:
        tree = tomllib.loads(text)
        changed = apply(tree, overrides)
        return _scene(tree, _Origin(source, text, changed), Path(base))
    except RecursionError as error:
        raise SceneError(deep) from error
    except ValueError as error:  # TOMLDecodeError, and numbers of thousands of digits
        raise SceneError(f"{source}: not valid TOML: {error}{_line(text, error)}; correct it") from error


def _line(text: str, error: ValueError) -> str:
    """The line that the TOML reader stopped in, where it names one."""
    found = re.search(r"\(at line (\d+)", str(error))
    return f": {text.split('\n')[int(found[1]) - 1].strip()[:60]!r}" if found else ""


def check(scene: Scene, *, base: str | Path = ".", source: str = "scene") -> Scene:
    """Check a scene made in Python as a scene file is checked, and return it with its values converted.

    A scene made in Python may hold texts such as ``"10 GPa"``, lists and NumPy values; the one returned has
    SI numbers and tuples. Supports, friction and loads of problem files that the scene names become part of
    it. What is allowed but seldom meant is logged as a warning.

    Parameters
    ----------
    scene : The scene.
    base : Folder that its paths are relative to.
    source : Name of the scene in messages.

    Raises
    ------
    SceneError : It is no ``Scene``, or describes something impossible.
    """
    _refuse_other(scene)
    checked = _scene(plain(scene), _Origin(source), Path(base))
    completed = with_conditions(checked, Path(base))
    if completed is not checked:
        checked = _scene(plain(completed), _Origin(f"{source} with what its problem files say"), Path(base))
    for doubt in doubts(checked):
        remark(
            "scene",
            f"{source}: {doubt}",
        )
    return checked


def of_keys(keys: Mapping[str, Any]) -> Scene:
    """A scene by its keys, each as in a file or a record.

    Parameters
    ----------
    keys : With their values.

    Raises
    ------
    SceneError : A key is unknown or lacks, or a value is not what its key expects.
    """
    return _scene(plain(dict(keys)), _Origin("scene"), Path())


def of_records(scene: Scene, *, base: str | Path = ".") -> Scene:
    """The same scene, made of records where it was made of dicts and lists.

    Parameters
    ----------
    scene : The scene. base : Folder that its paths are relative to.

    Raises
    ------
    SceneError : It is no Scene, or a value is not what its key expects.
    """
    _refuse_other(scene)
    rough = any(_rough(key, getattr(scene, key)) for key in scene.__struct_fields__)
    return _scene(plain(scene), _Origin("scene"), Path(base)) if rough else scene


def _rough(key: str, value: Any) -> bool:
    """Whether a value of a scene has dicts or lists in the place of records and tuples."""
    named = key == "materials" and isinstance(value, dict)
    inner = value.values() if named else value if isinstance(value, tuple) else ()
    return (
        isinstance(value, list)
        or (isinstance(value, dict) and not named)
        or any(isinstance(one, dict) for one in inner)
    )


def _refuse_other(scene: Any) -> None:
    """Refuse what is no scene.

    Raises
    ------
    SceneError : It is none.
    """
    if not isinstance(scene, Scene):
        raise SceneError(f"scene is {scene!r:.60}, expected a Scene; read a file with masonry_fem.load")


@dataclass(frozen=True, slots=True)
class _Origin:
    """Where a tree came from, to say so in messages."""

    source: str
    text: str = ""
    changed: Mapping[KeyPath, str] = field(default_factory=dict)

    def error(self, misfit: MisfitError, tree: Any) -> SceneError:
        """The user's error for a misfit."""
        sentence = misfit.sentence.format(path=path_text(misfit.path, tree))
        return SceneError(f"{self.source}{self._place(misfit.line_path)}: {sentence}")

    def _place(self, path: KeyPath) -> str:
        for length in range(len(path), 0, -1):
            if path[:length] in self.changed:
                return f" with --set {self.changed[path[:length]]}"
        line = line_of(key_lines(self.text), path)
        return f", line {line}" if line else ""


@cache
def _scene_type() -> inspect.Type:
    return inspect.type_info(Scene)


def _scene(tree: dict[str, Any], origin: _Origin, base: Path) -> Scene:
    dimension = tree.get("dimension", 3)
    try:
        scene: Scene = fitted(tree, _scene_type(), (), dimension if dimension in (2, 3) else None)
        cross_check(scene, base)
    except MisfitError as misfit:
        raise origin.error(misfit, tree) from None
    return scene

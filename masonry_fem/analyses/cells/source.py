"""Source: the scene whose keys a search changes.

source = Source.of("arch.toml", ["fidelity=rigid"])
source.scene("structures.arch.thickness=0.2")        # what a trial runs
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.scene import Scene, dumps, loads
from masonry_fem.scene.overrides import texts


@dataclass(frozen=True, slots=True)
class Source:
    """A scene as text.

    Attributes
    ----------
    text : TOML. name : What messages call it. base : Folder that its paths are relative to.
    stem : Name of its results. overrides : Texts ``key=value`` for all trials.
    """

    text: str
    name: str
    base: Path
    stem: str
    overrides: tuple[str, ...]

    @classmethod
    def of(cls, scene: Scene | str | Path, overrides: Sequence[str] = (), base: Path | None = None) -> Source:
        """From a scene or the path of its file.

        Parameters
        ----------
        scene : The scene, or where its file is. overrides : Texts ``key=value``.
        base : Folder that its paths are relative to; None: that of its file, else the current one.

        Raises
        ------
        SceneError : The file cannot be read.
        """
        if isinstance(scene, Scene):
            return cls(dumps(scene), "scene", base or Path(), "scene", texts(overrides))
        path = Path(scene)
        try:
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise SceneError(f"{path}: cannot be read ({error}); expected a TOML file") from error
        return cls(text, str(path), base or path.parent, path.stem, texts(overrides))

    def scene(self, *changes: str) -> Scene:
        """The scene with its overrides and those of a trial.

        Raises
        ------
        SceneError : They make no scene.
        """
        return loads(self.text, [*self.overrides, *changes], base=self.base, source=self.name)

    def folder(self, out: str | Path | None, search: str) -> Path:
        """Where a search leaves what it finds: ``out``, or ``results/SCENE-search``."""
        return Path("results") / f"{self.stem}-{search}" if out is None else Path(out)

    def refuse(self, scene: Scene, why: Mapping[str, str]) -> None:
        """Refuse a scene of several runs.

        Parameters
        ----------
        scene : Made of this source. why : Why not, by the key that it has.

        Raises
        ------
        MasonryError : It has such a key.
        """
        for key, reason in why.items():
            if getattr(scene, key):
                raise MasonryError(f"{self.name} has {key}, and {reason}; leave them out")

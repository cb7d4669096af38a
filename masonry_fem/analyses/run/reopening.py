"""Reopening: where another run ended, as the start of a scene.

built, state = begun(scene, built, base)   # state is None where the scene starts in the reference
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import tomli_w

from masonry_fem.build import Built, build
from masonry_fem.build.going_on import gone_on
from masonry_fem.build.succession import Left, succeeded
from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.march.state import SystemState
from masonry_fem.output.checkpoint import CHECKPOINT, CheckpointError, read_checkpoint
from masonry_fem.records.remark import gathered
from masonry_fem.scene import check, loads, specs
from masonry_fem.scene.overrides import trusting_text


def begun(scene: specs.Scene, built: Built, base: Path) -> tuple[Built, SystemState | None]:
    """A scene with the contacts and loads of its start, and the state it starts from; None: at rest.

    Parameters
    ----------
    scene : The scene. built : Made of it.
    base : Folder that its paths are relative to.

    Raises
    ------
    MasonryError : There is no such run, or its stones are others.
    """
    if scene.analysis.start is None:
        return built, None
    _refuse(scene)
    left = reopened(base / scene.analysis.start, trust=_trusts(scene))
    model, state = succeeded(scene, built, base, left)
    return replace(built, model=model, bodies=state.bodies), state


def reopened(folder: Path, *, trust: bool = False) -> Left:
    """The structure of a run as its march left it.

    Parameters
    ----------
    folder : Results folder with a checkpoint.
    trust : Run the files of its scene that are programs.

    Raises
    ------
    CheckpointError : There is no checkpoint, or it was written before the first step.
    """
    checkpoint = read_checkpoint(folder)
    if checkpoint.standing is None:
        scene_text = tomllib.loads(untrusted(checkpoint.scene))
        parts = [one["name"] for key in ("stages", "combinations") for one in scene_text.get(key, ())]
        if parts:
            raise CheckpointError(
                f"{folder} holds the results of several runs; expected those of one to start from, "
                f"such as {folder / parts[-1]}"
            )
        raise CheckpointError(
            f"{folder / CHECKPOINT} is from before the first step; go on with that run first"
        )
    text = untrusted(checkpoint.scene)
    with gathered(aloud=False):
        scene = loads(
            text,
            trusting_text(text, ()) if trust else (),
            base=folder,
            source=f"{folder / CHECKPOINT} (its scene)",
        )
        scene = check(scene, base=folder)
        built = build(scene, folder, solved=False)
    standing = checkpoint.standing
    model, state = gone_on(scene, built, folder, standing), standing.state
    warmed = standing.warmed or (None,) * len(model.groups)  # of older files
    return Left(built.stones, model, state, warmed, scene.materials)


def untrusted(text: str) -> str:
    """A scene's text without the trust in its programs: whoever wrote the file may not give it.

    Raises
    ------
    CheckpointError : The text is no TOML.
    """

    def stripped(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: stripped(one) for key, one in value.items() if key != "trusted"}
        return [stripped(one) for one in value] if isinstance(value, list) else value

    try:
        return str(tomli_w.dumps(stripped(tomllib.loads(text))))
    except (ValueError, RecursionError) as error:
        raise CheckpointError(f"a checkpoint's scene cannot be read ({error}); run it again") from error


def refuse_start(scene: specs.Scene, what: str) -> None:
    """Refuse a scene that starts from another run's end, or has stages that do, or load combinations.

    Parameters
    ----------
    scene : The scene. what : What cannot start there.

    Raises
    ------
    MasonryError : It does.
    """
    if scene.stages:
        raise MasonryError(
            f"{what} is of one structure, and this one has stages; give a scene without, or 'run' it"
        )
    if scene.combinations:
        raise MasonryError(
            f"{what} is under one set of loads, and this scene has combinations; give one without, "
            "such as the as_run.toml of a combination"
        )
    if scene.analysis.start is not None:
        raise MasonryError(
            f"{what} begins in the reference, and analysis.start is '{scene.analysis.start}'; leave it out"
        )


def _refuse(scene: specs.Scene) -> None:
    """Refuse what does not go with a start."""
    if scene.initial:
        raise SceneError(
            "initial gives velocities beside analysis.start, whose state has its own; leave one of them out"
        )
    if scene.analysis.steers:
        raise SceneError(
            "analysis.start is given for kind = 'path', whose load factor begins at 0; take kind = 'statics'"
        )
    for key in of_the_reference(scene):
        raise SceneError(f"output.{key} is of stones in the reference; leave it out beside analysis.start")


def of_the_reference(scene: specs.Scene) -> list[str]:
    """Keys of what is to be written that only stones in the reference have.

    Parameters
    ----------
    scene : That asks for it.
    """
    return [key for key in ("contact_error", "limit_analysis") if getattr(scene.output, key)]


def _trusts(scene: specs.Scene) -> bool:
    """Whether the user trusts programs of this scene."""

    def walk(value: Any) -> Iterator[bool]:
        if getattr(value, "trusted", False) is True:
            yield True
        if isinstance(value, dict):
            value = tuple(value.values())
        parts = value if isinstance(value, tuple) else ()
        if hasattr(value, "__struct_fields__"):
            parts = tuple(getattr(value, name) for name in value.__struct_fields__)
        for part in parts:
            yield from walk(part)

    return any(walk(scene))

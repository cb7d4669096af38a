"""Inspection: what can be said and shown of a scene without solving it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import psutil
from msgspec import structs

from masonry_fem.analyses.run.stages import check_stages, of_stage
from masonry_fem.bodies.support import SupportGroup
from masonry_fem.build import build
from masonry_fem.build.foresight import memory_of_run
from masonry_fem.fidelities import fidelities
from masonry_fem.output.folder import Folder
from masonry_fem.records.remark import remark
from masonry_fem.records.told import Told
from masonry_fem.results.summarise import size
from masonry_fem.scene import check, specs


class Inspection(Told, frozen=True, kw_only=True):
    """What is known of a scene before it is solved.

    Attributes
    ----------
    title : Of the scene. blocks, shapes, meshes, interfaces, contacts, unknowns : Their numbers.
    names : Of the blocks. roles : Numbers of supports and of blocks of each fidelity.
    interfaces_by_label : Numbers of interfaces of each joint.
    most_steps : Steps of the analysis. estimated_memory_mb : Of a run [MB].
    """

    title: str
    blocks: int
    shapes: int
    meshes: int
    interfaces: int
    contacts: int
    unknowns: int
    names: tuple[str, ...]
    roles: dict[str, int]
    interfaces_by_label: dict[str, int]
    most_steps: int
    estimated_memory_mb: float


def check_scene(scene: specs.Scene, base: str | Path = Path()) -> Inspection:
    """Build a scene without solving it; of stages what is known of the largest, and the steps of all.

    Parameters
    ----------
    scene : The scene. base : Folder that its paths are relative to.

    Raises
    ------
    SceneError : It contradicts itself, or a file of it cannot be read.
    """
    if scene.stages:
        found = []
        for stage, own in zip(scene.stages, check_stages(scene, Path(base)), strict=True):
            with of_stage(stage.name):
                found.append(check_scene(own, base))
        largest = max(found, key=lambda one: (one.unknowns, one.blocks))
        return structs.replace(largest, title=scene.title, most_steps=sum(one.most_steps for one in found))
    built = build(check(scene, base=base), Path(base), solved=False)
    memory = memory_of_run(built.stones, built.model.contacts) / 1e6
    present = psutil.virtual_memory().total / 1e6
    if memory > present:
        remark(
            "memory",
            f"a run needs some {memory:.0f} MB, this machine has {present:.0f} MB; expected less: "
            "take larger elements, or rigid blocks where stresses are not asked for",
        )
    labels = Counter(label or "unnamed" for label in built.model.interfaces.label_of_each)
    return Inspection(
        title=scene.title,
        **size(built.model),
        names=built.model.assembly.blocks.names,
        roles={SupportGroup.kind: len(built.stones.of(None))}
        | {name: len(built.stones.of(name)) for name in fidelities()},
        interfaces_by_label=dict(labels),
        most_steps=scene.analysis.steps * max(len(scene.combinations), 1),
        estimated_memory_mb=memory,
    )


def write_mesh(scene: specs.Scene, out: str | Path, base: str | Path = Path()) -> list[Path]:
    """Write and picture the mesh and the detected interfaces, without solving.

    Parameters
    ----------
    scene : What to build. base : Folder that the paths in it are relative to.
    out : Folder of the results.

    Raises
    ------
    MasonryError : The scene cannot be built, or the folder not be written to.
    """
    from masonry_fem.output.mesh_picture import write_mesh_files  # noqa: PLC0415

    out, base = Path(out), Path(base)
    built = build(check(scene, base=base), base, solved=False)
    with Folder(out, "mesh"):
        return write_mesh_files(built.model, out, scene.title)

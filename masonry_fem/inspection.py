"""Inspection: what can be said and shown of a scene without solving it."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.build import Built, build, strategy
from masonry_fem.post.folder import make_folder
from masonry_fem.scene import check, specs
from masonry_fem.summary import peak_memory, size

logger = logging.getLogger(__name__)


def check_scene(scene: specs.Scene, base: Path = Path()) -> Mapping[str, Any]:
    """Build a scene without solving it: its size, interfaces and a memory estimate."""
    built = build(check(scene, base=base), base)
    memory, present = estimated_memory(built), present_memory()
    if memory > present:
        logger.warning(
            "a run needs some %.0f MB, this machine has %.0f MB; expected less: take larger elements, or "
            "rigid blocks where stresses are not asked for",
            memory, present,
        )  # fmt: skip
    labels: dict[str, int] = {}
    for interface in built.model.interfaces:
        labels[interface.label or "unnamed"] = labels.get(interface.label or "unnamed", 0) + 1
    return {
        "title": scene.title,
        **size(built),
        "roles": {role: built.stones.role.count(role) for role in ("support", "rigid", "elastic")},
        "interfaces_by_label": labels,
        "most_steps": strategy(scene.analysis).steps,
        "estimated_memory_mb": memory,
    }


def estimated_memory(built: Built) -> float:
    """Rough peak of a run [MB]: what is there now and the dense compliance of the elastic blocks."""
    model = built.model
    d, total = model.assembly.dimension, 0.0
    elastic = {int(b) for g in model.groups if g.cell != "polytope" for b in g.blocks}
    per_block = np.bincount(model.contacts.blocks.ravel(), minlength=len(model.assembly.blocks))
    for block in elastic:
        total += 8.0 * (d * per_block[block]) ** 2
    # factors of the contact system hold a few times the compliance
    return peak_memory() + 4 * total / 1e6


def present_memory() -> float:
    """Memory of this machine [MB]."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e6


def write_mesh(scene: specs.Scene, out: Path, base: Path = Path()) -> list[Path]:
    """Write and picture the mesh and the detected interfaces, without solving."""
    from masonry_fem.post.mesh_picture import write_mesh_files  # noqa: PLC0415

    built = build(check(scene, base=base), base)
    make_folder(out)
    return write_mesh_files(built.model, out, scene.title)

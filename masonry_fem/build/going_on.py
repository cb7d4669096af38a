"""Going on: a model that has been built again, with the contacts that its march had found.

model = gone_on(scene, built, base, standing)
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from masonry_fem.build.joints import joints_at
from masonry_fem.build.model import Built
from masonry_fem.errors import MasonryError
from masonry_fem.march.model import Model
from masonry_fem.march.standing import Standing
from masonry_fem.records.remark import first_few
from masonry_fem.records.tree import differences
from masonry_fem.scene import specs

SHOWN = 3  # differences that a message names


def gone_on(scene: specs.Scene, built: Built, base: Path, standing: Standing) -> Model:
    """The structure with the contacts that its march had between two steps.

    Parameters
    ----------
    scene : What was run. built : The same, built again.
    base : Folder that the scene's paths are relative to.
    standing : What the march knew.

    Raises
    ------
    MasonryError : The state is not of this structure; the message tells the differences.
    """
    model, found = built.model, standing.found
    if found is not None:
        closed = replace(found.contacts, gap=np.zeros(found.contacts.count))
        records = list(found.records)
        laws, scatter = joints_at(scene, built.stones, found.interfaces, closed, records, base)
        model = replace(
            model,
            interfaces=found.interfaces,
            contacts=found.contacts,
            laws=laws,
            scatter=scatter,
            joint_records=found.records,
            found=True,
        )
    state, count = standing.state, model.contacts.count
    told = []
    for one, rest, group in zip(state.bodies, built.bodies, model.groups, strict=False):
        told += differences(_unmoved(one), _unmoved(rest), f"the state of the {group.kind} stones")
    if len(state.bodies) != len(model.groups):
        told.append(f"the state has {len(state.bodies)} groups of stones, expected {len(model.groups)}")
    if len(state.gap) != count:
        told.append(f"the state has {len(state.gap)} contacts, expected {count}")
    if told:
        raise MasonryError(
            f"the saved state does not fit its scene: {first_few(told, SHOWN, separator='; ')}. Files that "
            "the scene names have changed since; restore them, or run the scene again"
        )
    return model


def _unmoved(state: object) -> object:
    """A body state without what there is only once a step is made."""
    changes = {name: None for name in ("memory", "pushed") if hasattr(state, name)}
    return replace(state, **changes) if changes else state  # type: ignore[type-var]  # states are dataclasses

"""Ageing: stones whose material is another than where they were left become it evenly.

    ageing = Ageing(scene, stones, base, {"stone": material_before})
    model = ageing(model, 0.4)                  # of materials between the two

Numbers go linearly from those of the one table to those of the other; what is no number, such as the kind of
a law, changes at the start. Layers of stones themselves in series with joints follow these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct, structs

from masonry_fem.bodies.base import BodyGroup
from masonry_fem.build.joints import joints_at, skins
from masonry_fem.build.model import body_groups
from masonry_fem.build.stones import Stones
from masonry_fem.build.supports import fade
from masonry_fem.build.temperature import Expansions
from masonry_fem.march.model import Model
from masonry_fem.scene import specs


@dataclass(slots=True)
class Ageing:
    """How stones follow materials that change.

    Attributes
    ----------
    scene, stones, base : What the model was built from.
    before : Materials where the stones were left, of those that are others here, by name.
    left : Strains by temperature that blocks have beside those of the scene.
    """

    scene: specs.Scene
    stones: Stones
    base: Path
    before: Mapping[str, specs.Material]
    left: Expansions = field(default_factory=dict)
    _last: tuple[float, tuple[BodyGroup, ...]] | None = None

    def __call__(self, model: Model, time: float) -> Model:
        """The model with its materials at a time [s] or load factor; groups that stay are the same objects.

        Parameters
        ----------
        model : As it is. time : At the end of a step.
        """
        share, groups = 1.0 - fade(self.scene)(time), model.groups
        if self._last is not None and self._last[0] == share and self._last[1] is groups:
            return model
        known = self.scene.materials
        now = {name: between(own, known[name], share) for name, own in self.before.items()}
        scene = structs.replace(self.scene, materials=known | now)
        were: tuple[Any, ...] = groups
        made: tuple[Any, ...] = body_groups(scene, self.stones, self.base, groups, self.left)
        aged = tuple(
            new.clamped_as(old) if new.deforms and new.operators is not old.operators else old
            for new, old in zip(made, were, strict=True)
        )
        self._last = share, aged
        laws = model.laws
        if skins(scene, self.stones, model.contacts) is not None:
            closed = replace(model.contacts, gap=np.zeros(model.contacts.count))
            records = list(model.joint_records)
            laws, _ = joints_at(scene, self.stones, model.interfaces, closed, records, self.base)
        return replace(model, groups=aged, laws=laws)


def changed(scene: specs.Scene, stones: Stones, before: Mapping[str, specs.Material]) -> dict[str, Any]:
    """Materials of stones that deform and were left with other ones, as they were left, by name.

    Parameters
    ----------
    scene : The scene. stones : Its blocks.
    before : The material of each block where it was left, by the block's name.
    """
    found: dict[str, specs.Material] = {}
    mixed = set()
    for block in stones.deforming:
        name, own = stones.material[block], before.get(stones.assembly.blocks.names[block])
        if own is not None and found.setdefault(name, own) != own:
            mixed.add(name)
    return {name: own for name, own in found.items() if name not in mixed and own != scene.materials[name]}


def between(one: specs.Material, other: specs.Material, share: float) -> specs.Material:
    """A material so far on the way from one to another.

    Parameters
    ----------
    one, other : The materials. share : 0 is the one, 1 the other.
    """
    made: specs.Material = _between(one, other, share)
    return structs.replace(made, thermal_expansion=other.thermal_expansion)  # strains are what warms them


def _between(one: Any, other: Any, share: float) -> Any:
    """The same of any value in a material's table."""
    if type(one) is not type(other) or one == other:
        return other
    if isinstance(other, float):
        return (1.0 - share) * one + share * other
    if isinstance(other, tuple) and len(one) == len(other):
        return tuple(_between(*pair, share) for pair in zip(one, other, strict=True))
    if isinstance(other, dict):
        return {key: _between(one.get(key), value, share) for key, value in other.items()}
    if isinstance(other, Struct):
        keys = other.__struct_fields__
        return structs.replace(
            other, **{key: _between(getattr(one, key), getattr(other, key), share) for key in keys}
        )
    return other

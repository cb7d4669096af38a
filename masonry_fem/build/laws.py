"""From joint records to the cohesive laws of contact points."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from masonry_fem.build.law_file import law_of_file
from masonry_fem.contact.contacts import Contacts
from masonry_fem.errors import LawError, SceneError
from masonry_fem.nscd.laws.assignment import Assignment
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.nscd.laws.law import Law


def joint_laws(scene: specs.Scene, contacts: Contacts, chosen: list[int], base: Path) -> Assignment | None:
    """The laws of all joints, dry ones among them; None where all are dry.

    ``chosen`` is the number of the joint record of each interface, ``base`` the folder of
    the files that laws come from.
    """
    record = np.array(chosen, dtype=int)[contacts.interface] if len(chosen) else np.zeros(0, dtype=int)
    used = np.unique(record).tolist()
    if all(scene.joints[index].law is None for index in used):
        return None
    return Assignment(
        tuple((_law(index, scene.joints[index], base), np.flatnonzero(record == index)) for index in used)
    )


def _check(index: int, joint: specs.Joint) -> None:
    for name, plain in (("form", "gap"), ("dynamic_friction", None)):
        value = getattr(joint, name)
        if value != plain:
            raise SceneError(
                f"joints.{index}.{name} is {value!r} beside a law, expected none; leave it out, or "
                f"drop joints.{index}.law"
            )


def _law(index: int, joint: specs.Joint, base: Path) -> Law:
    from masonry_fem.nscd.laws import LAWS, Dry  # noqa: PLC0415 - only scenes with cohesion need them

    if joint.law is None:
        return Dry(friction=joint.friction, dynamic_friction=joint.dynamic_friction)
    _check(index, joint)
    if isinstance(joint.law, specs.PythonLaw):
        return law_of_file(joint.law, joint.friction, base, f"joints.{index}.law")
    make: Callable[..., Law] = LAWS[str(joint.law.__struct_config__.tag)]
    try:
        return make(friction=joint.friction, **msgspec.structs.asdict(joint.law))
    except LawError as error:
        raise SceneError(f"joints.{index}.law: {error}") from error

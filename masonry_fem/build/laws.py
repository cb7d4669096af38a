"""From joint records to the cohesive laws of contact points."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from masonry_fem.contact.contacts import Contacts
from masonry_fem.dynamics.joint_laws import JointLaws
from masonry_fem.errors import LawError, SceneError
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.nscd.laws import Law


def joint_laws(scene: specs.Scene, contacts: Contacts, chosen: list[int]) -> JointLaws | None:
    """The laws of all joints that have one; None where all are dry.

    ``chosen`` is the number of the joint record of each interface.
    """
    record = np.array(chosen, dtype=int)[contacts.interface] if len(chosen) else np.zeros(0, dtype=int)
    laws, members = [], []
    for index, joint in enumerate(scene.joints):
        own = np.flatnonzero(record == index)
        if joint.law is None or not len(own):
            continue
        _check(index, joint)
        laws.append(_law(index, joint.law, joint.friction))
        members.append(own)
    return JointLaws(tuple(laws), tuple(members)) if laws else None


def _check(index: int, joint: specs.Joint) -> None:
    for name, plain in (("form", "gap"), ("dynamic_friction", None)):
        value = getattr(joint, name)
        if value != plain:
            raise SceneError(
                f"joints.{index}.{name} is {value!r} beside a law, expected none; leave it out, or "
                f"drop joints.{index}.law"
            )


def _law(index: int, law: specs.AnyLaw, friction: float) -> Law:
    from masonry_fem.nscd.laws import LAWS  # noqa: PLC0415 - only scenes with cohesion need them

    make: Callable[..., Law] = LAWS[str(law.__struct_config__.tag)]
    try:
        return make(friction=friction, **msgspec.structs.asdict(law))
    except LawError as error:
        raise SceneError(f"joints.{index}.law: {error}") from error

"""From joint records to the laws of contact points.

A joint is built from the faces outwards: what holds them together (dry contact, cohesion), what their
sliding does (dilatancy), and the layer of mortar in series with all of it.

    Bed(Rough(MohrCoulomb(...)))
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np
from numpy.typing import NDArray

from masonry_fem.build.law_file import law_of_file
from masonry_fem.contact.contacts import Contacts, Interface
from masonry_fem.errors import LawError, SceneError
from masonry_fem.nscd.laws.assignment import Assignment
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.nscd.laws.law import Law


def joint_laws(
    scene: specs.Scene,
    contacts: Contacts,
    interfaces: tuple[Interface, ...],
    chosen: list[int],
    base: Path,
) -> Assignment | None:
    """The laws of all joints, dry ones among them; None where all are dry.

    ``chosen`` is the number of the joint record of each interface, ``base`` the folder of
    the files that laws come from.
    """
    record = np.array(chosen, dtype=int)[contacts.interface] if len(chosen) else np.zeros(0, dtype=int)
    used = np.unique(record).tolist()
    if all(scene.joints[index].dry for index in used):
        return None
    bare = _bare(contacts, interfaces)
    parts: list[tuple[Law, NDArray[np.int64]]] = []
    for index in used:
        joint = scene.joints[index]
        alone = bare if joint.mortar is None else bare & _on_points(contacts, interfaces)
        points = np.flatnonzero((record == index) & ~alone)
        if len(points):
            parts.append((_law(index, joint, base), points))
        points = np.flatnonzero((record == index) & alone)
        if len(points):
            parts.append((_dry(joint), points))
    return Assignment(tuple(parts))


def _bare(contacts: Contacts, interfaces: tuple[Interface, ...]) -> NDArray[np.bool_]:
    """Contact points with no area for cohesion to act on: only pressure and friction are left."""
    largest = np.array([interface.area for interface in interfaces])[contacts.interface]
    bare: NDArray[np.bool_] = contacts.area <= 1e-12 * largest
    return bare


def _on_points(contacts: Contacts, interfaces: tuple[Interface, ...]) -> NDArray[np.bool_]:
    """Contact points where corners or edges meet faces: there is no layer of mortar."""
    areas = np.array([interface.area for interface in interfaces])[contacts.interface]
    without: NDArray[np.bool_] = areas <= 0
    return without


def _law(index: int, joint: specs.Joint, base: Path) -> Law:
    from masonry_fem.nscd.laws import Bed, Rough  # noqa: PLC0415 - only scenes with cohesion need them

    law = _faces(index, joint, base)
    part = "dilatancy"
    try:
        if joint.dilatancy is not None:
            law = Rough(law, joint.dilatancy.tangent, joint.dilatancy.bound)
        part, mortar = "mortar", joint.mortar
        if mortar is None:
            return law
        if mortar.thickness is None or mortar.young is None:
            normal, tangential = mortar.normal_stiffness, mortar.tangential_stiffness
            assert normal is not None  # checked with the scene
            assert tangential is not None
            return Bed(law, normal, tangential, mortar.crushing, mortar.hardening)
        poisson = 0.2 if mortar.poisson is None else mortar.poisson
        return Bed.of_mortar(
            law, mortar.thickness, mortar.young, poisson, mortar.crushing, mortar.hardening
        )  # fmt: skip
    except LawError as error:
        raise SceneError(f"joints.{index}.{part}: {error}") from error


def _faces(index: int, joint: specs.Joint, base: Path) -> Law:
    """What holds the two faces together."""
    from masonry_fem.nscd.laws import LAWS  # noqa: PLC0415 - only scenes with cohesion need them

    if not joint.dry:
        _check(index, joint)
    if joint.law is None:
        return _dry(joint)
    if isinstance(joint.law, specs.PythonLaw):
        return law_of_file(joint.law, joint.friction, base, f"joints.{index}.law")
    make: Callable[..., Law] = LAWS[str(joint.law.__struct_config__.tag)]
    try:
        return make(friction=joint.friction, **msgspec.structs.asdict(joint.law))
    except LawError as error:
        raise SceneError(f"joints.{index}.law: {error}") from error


def _dry(joint: specs.Joint) -> Law:
    from masonry_fem.nscd.laws import Dry  # noqa: PLC0415 - only scenes with cohesion need them

    return Dry(friction=joint.friction, dynamic_friction=joint.dynamic_friction)


def _check(index: int, joint: specs.Joint) -> None:
    parts = [name for name in ("law", "mortar", "dilatancy") if getattr(joint, name) is not None]
    with_law = ("dynamic_friction", None) if joint.law is not None else ("form", "gap")
    for name, plain in (("form", "gap"), with_law):
        value = getattr(joint, name)
        if value != plain:
            raise SceneError(
                f"joints.{index}.{name} is {value!r} beside a {parts[0]}, expected none; leave it out, or "
                f"drop joints.{index}.{parts[0]}"
            )

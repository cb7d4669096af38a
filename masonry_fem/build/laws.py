"""From joint records to the laws of contact points.

A joint is built from the faces outwards: what holds them together (dry contact, cohesion), what their
sliding does (dilatancy), how their asperities close, and the layer of mortar in series with all of it.

    Bed(Closure(Rough(MohrCoulomb(...))))
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.build.scatter import scattered
from masonry_fem.build.ties import tie_law
from masonry_fem.contact.contacts import Contacts
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.errors import LawError, SceneError
from masonry_fem.joints.assignment import Assignment
from masonry_fem.joints.kinds import kind
from masonry_fem.joints.law import Law, Place
from masonry_fem.joints.laws.parts.bed import Bed
from masonry_fem.joints.laws.parts.closure import Closure
from masonry_fem.joints.laws.parts.dry import Dry
from masonry_fem.joints.laws.parts.kinetic import Kinetic
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle
from masonry_fem.joints.laws.parts.rough import Rough
from masonry_fem.joints.parameters import Parameter
from masonry_fem.records.remark import remark
from masonry_fem.scene import specs
from masonry_fem.scene.laws import program_faults
from masonry_fem.scene.own_class import Kind, OwnClass, made

FloatArray = NDArray[np.float64]

APART = 1e-4  # of an interface's extent: a gap that more than rounding has made
JOINT_LAW = Kind(Law, "joint law", "masonry_fem.joints.Law", LawError)  # type: ignore[type-abstract]


@dataclass(frozen=True, slots=True)
class _Part:
    """Contact points of one joint record.

    Attributes
    ----------
    joint : The record. key : Where it stands in the scene. base : Folder of files that laws come from.
    contacts : All contact points. points : Numbers of the record's own, shape (k,).
    factor : Factors on the record's values by parameter, shape (k,).
    """

    joint: specs.Joint
    key: str
    base: Path
    contacts: Contacts
    points: NDArray[np.int64]
    factor: dict[str, FloatArray]

    @property
    def rubbing(self) -> float | FloatArray:
        """The factor on all coefficients of friction."""
        return self.factor.get("friction", 1.0)


def joint_laws(
    scene: specs.Scene,
    contacts: Contacts,
    interfaces: Interfaces,
    chosen: list[int],
    base: Path,
    scatter: dict[str, FloatArray],
    skin: FloatArray | None = None,
) -> Assignment:
    """The laws of all contact points.

    Parameters
    ----------
    scene : Has the joint records.
    contacts : The contact points.
    interfaces : Where they are.
    chosen : Number of the joint record of each of the i interfaces.
    base : Folder of the files that laws come from.
    scatter : Factors on the scene's values by parameter, shape (i,).
    skin : What stones give way at the points by a unit of pressure, shape (c,) [m³/N]; None: nothing.
    """
    record = np.array(chosen, dtype=int)[contacts.interface] if len(chosen) else np.zeros(0, dtype=int)
    # all points of an interface are in one group
    groups = (np.ones(len(record), dtype=bool),) if skin is None else (skin <= 0, skin > 0)
    parts: list[tuple[Law, NDArray[np.int64]]] = []
    dry = ~contacts.tied
    for index, points in _lawful(scene.joints, record, contacts, interfaces, groups):
        joint, key = scene.joints[index], f"joints.{index}"
        factor = {name: values[contacts.interface[points]] for name, values in scatter.items()}
        _tell_apart(joint, key, contacts, interfaces, points)
        parts.append((_law(_Part(joint, key, base, contacts, points, factor)), points))
        dry[points] = False
    rubbing = scatter["friction"][contacts.interface] if "friction" in scatter else np.ones(len(record))
    plain = tuple(
        part for own in groups for part in _dry(scene.joints, record, np.flatnonzero(dry & own), rubbing)
    )
    every = (*plain, *parts)
    every = every if skin is None else tuple(_on_skin(*part, skin) for part in every)
    tied = np.flatnonzero(contacts.tied)
    return Assignment((*every, (tie_law(scene, interfaces, contacts, tied), tied)) if len(tied) else every)


def _lawful(
    joints: tuple[specs.Joint, ...],
    record: NDArray[np.int64],
    contacts: Contacts,
    interfaces: Interfaces,
    groups: tuple[NDArray[np.bool_], ...],
) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Joint records that have a law of their own, and the points (k,) of each group that it holds at.

    ``record`` is the number of each point's joint record, shape (c,), as is that of a group's mask.
    """
    bare = _bare(contacts, interfaces)
    for index in np.unique(record[record >= 0]).tolist():
        joint = joints[index]
        if joint.dry:
            continue
        thick = joint.mortar is not None or joint.closure is not None
        alone = bare & _on_points(contacts, interfaces) if thick else bare
        for own in groups:
            points = np.flatnonzero((record == index) & ~alone & own)
            if len(points):
                yield index, points


def _on_skin(law: Law, points: NDArray[np.int64], skin: FloatArray) -> tuple[Law, NDArray[np.int64]]:
    """A law of k points (k,), with the skins of the stones in series where these give way, (c,) [m³/N].

    Mortar gives way by far more, and contact that is written in velocities knows no way.
    """
    if not skin[points].any() or isinstance(law, Bed) or law.rebound(len(points)) is not None:
        return law, points
    stiffness = 1.0 / skin[points]
    return Bed(law, stiffness, stiffness), points


def _dry(
    joints: tuple[specs.Joint, ...],
    record: NDArray[np.int64],
    points: NDArray[np.int64],
    rubbing: FloatArray,
) -> Iterator[tuple[Law, NDArray[np.int64]]]:
    """Dry contact at ``points`` of all records: one law, with numbers by point, for each form of contact.

    ``record`` is the number of each point's joint record, ``rubbing`` the factor on its friction, shape (c,).
    """
    for form in ("gap", "velocity"):
        alike = points[np.array([joint.form == form for joint in joints])[record[points]]]
        if not len(alike):
            continue
        friction, dynamic, normal, aside = (
            np.array(values)[record[alike]] for values in zip(*map(_numbers, joints), strict=True)
        )
        slower = rubbing[alike] * dynamic if (dynamic < friction).any() else None
        rebound = (normal, aside) if form == "velocity" else ()
        yield _moving(Dry(rubbing[alike] * friction), slower, *rebound), alike


def _moving(law: Law, dynamic: Parameter | None, *rebound: Parameter) -> Law:
    """The law with a dynamic friction and restitution, where it has any."""
    return law if dynamic is None and not rebound else Kinetic(law, dynamic, *rebound)


def _numbers(joint: specs.Joint) -> tuple[float, float, float, float]:
    """Static and dynamic friction, normal and tangential restitution."""
    dynamic = joint.coefficient if joint.dynamic_friction is None else joint.dynamic_friction
    return joint.coefficient, dynamic, joint.restitution, joint.tangential_restitution


def _bare(contacts: Contacts, interfaces: Interfaces) -> NDArray[np.bool_]:
    """Contact points with no area for cohesion to act on: only pressure and friction are left."""
    largest = interfaces.area[contacts.interface]
    bare: NDArray[np.bool_] = contacts.area <= 1e-12 * largest
    return bare


def _on_points(contacts: Contacts, interfaces: Interfaces) -> NDArray[np.bool_]:
    """Contact points where corners or edges meet faces: there is no layer of mortar."""
    areas = interfaces.area[contacts.interface]
    without: NDArray[np.bool_] = areas <= 0
    return without


def _tell_apart(
    joint: specs.Joint,
    key: str,
    contacts: Contacts,
    interfaces: Interfaces,
    points: NDArray[np.int64],
) -> None:
    """Warn of faces that are open at the start under a rigid law, which pulls them together."""
    if joint.law is None or isinstance(joint.law, specs.PythonLaw):  # a user's own class says nothing of gaps
        return
    if not issubclass(kind(joint.law.kind).law, RigidBrittle):
        return
    areas = interfaces.area[contacts.interface[points]]
    extent = areas ** (1.0 / (contacts.points.shape[-1] - 1))
    gaps = contacts.gap[points]
    apart = gaps > APART * extent
    if apart.any():
        remark(
            "pulled_together",
            f"{key}.law: at {int(apart.sum())} contact points the faces are up to "
            f"{float(gaps[apart].max()):.3g} m apart at the start, and {joint.law.kind} pulls them "
            "together with its strength; close the gaps, lower contact.reach, or take a law with "
            "springs",
        )


def _law(part: _Part) -> Law:
    """Faces, roughness, asperities and bed of a joint."""
    joint, rough = part.joint, part.joint.dilatancy
    law = _faces(part)
    dynamic = None if joint.dynamic_friction is None else joint.dynamic_friction * part.rubbing
    rebound = () if joint.form == "gap" else (joint.restitution, joint.tangential_restitution)
    law = _made(f"{part.key}.law", _moving, law, dynamic, *rebound)
    if rough is not None:
        # a joint that drew a low friction is less rough: more would create energy
        tangent = rough.tangent * np.minimum(1.0, part.rubbing)
        law = _made(f"{part.key}.dilatancy", Rough, law, tangent, rough.bound)
    if joint.closure is not None:
        law = _made(f"{part.key}.closure", Closure, law, **_layer(part, "closure", joint.closure))
    return law if joint.mortar is None else _bedded(part, law, joint.mortar)


def _bedded(part: _Part, law: Law, mortar: specs.Mortar) -> Law:
    """The law on its bed of mortar."""
    make = Bed if mortar.thickness is None else Bed.of_mortar
    return _made(f"{part.key}.mortar", make, law, **_layer(part, "mortar", mortar))


def _layer(part: _Part, name: str, record: msgspec.Struct) -> dict[str, Any]:
    """Parameters of a layer in series, those that scatter by contact point."""
    given = {key: value for key, value in msgspec.structs.asdict(record).items() if value is not None}
    own = f"{name}."
    factor = {key.removeprefix(own): value for key, value in part.factor.items() if key.startswith(own)}
    return scattered(given, factor)


def _faces(part: _Part) -> Law:
    """What holds the two faces together."""
    joint = part.joint
    _check(part)
    key, friction = f"{part.key}.law", joint.coefficient * part.rubbing
    if joint.law is None:
        return Dry(friction)
    if isinstance(joint.law, specs.PythonLaw):
        arrays = scattered(joint.law.parameters or {}, part.factor)
        return law_of_file(joint.law, friction, part.base, key, arrays)
    told = msgspec.structs.asdict(joint.law)
    alike = {"residual_friction": part.factor["friction"]} if "friction" in part.factor else {}
    drawn = {"friction": friction} | scattered(told, part.factor | alike)
    make = kind(joint.law.kind).law.made
    return _made(key, make, told, drawn, Place(key, partial(_laplacian, part)))


def law_of_file(
    spec: specs.PythonLaw, friction: Parameter, base: Path, key: str, arrays: Mapping[str, Any] | None = None
) -> Law:
    """The law that a class in a file makes of the scene's parameters.

    Parameters
    ----------
    spec : File, class and parameters. friction : The joint's, for classes that take one.
    base : Folder of the scene file. key : Where the law stands in the scene, for messages.
    arrays : Parameters in the place of the scene's own, such as those that scatter.

    Raises
    ------
    SceneError : Where the file is not trusted, cannot be run, has no such law, or the law refuses its
        parameters.
    """
    for fault, expected in program_faults(spec):  # none, if the scene has been checked
        raise SceneError(f"{key}.{fault} is {getattr(spec, fault)!r}, expected {expected}")

    def parameters(accepted: Collection[str]) -> dict[str, Any]:
        given: dict[str, Any] = {**(spec.parameters or {}), **(arrays or {})}
        if "friction" in accepted:
            given.setdefault("friction", friction)
        return given

    return made(JOINT_LAW, OwnClass(spec.file, spec.law, "law"), base, key, parameters)


def _laplacian(part: _Part) -> sparse.csr_array:
    """−Δ among the part's points, each in the plane of its interface."""
    from masonry_fem.joints.spreading import interface_laplacian  # noqa: PLC0415 - brings scipy.spatial

    contacts, points = part.contacts, part.points
    own = contacts.interface[points]
    _, first, of_own = np.unique(own, return_index=True, return_inverse=True)
    planes = contacts.frame[points[first], 1:]  # one for all points of an interface
    inside = np.einsum("ktd,kd->kt", planes[of_own], contacts.points[points, 0])
    return interface_laplacian(inside, contacts.area[points], own)


def _made(key: str, make: Callable[..., Law], *law: Any, **values: Any) -> Law:
    try:
        return make(*law, **values)
    except LawError as error:
        raise SceneError(f"{key}: {error}") from error


def _check(part: _Part) -> None:
    joint = part.joint
    beside = next(
        (name for name in ("mortar", "closure", "dilatancy") if getattr(joint, name) is not None), None
    )
    if joint.form != "gap" and beside is not None:
        raise SceneError(
            f"{part.key}.form is {joint.form!r} beside a {beside}, expected 'gap'; leave it out, or "
            f"drop {part.key}.{beside}"
        )

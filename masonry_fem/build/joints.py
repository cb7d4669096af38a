"""From interfaces and joint records to contact points with their properties."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from masonry_fem.build.foresight import foresee_points
from masonry_fem.build.laws import joint_laws
from masonry_fem.build.scatter import scatter_factors
from masonry_fem.build.selection import matching
from masonry_fem.build.stones import Stones
from masonry_fem.build.ties import with_ties
from masonry_fem.contact.contacts import Contacts, Interface
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule, least_inset
from masonry_fem.errors import SceneError
from masonry_fem.fidelities import fidelity
from masonry_fem.joints.assignment import Assignment
from masonry_fem.joints.laws.parts.bed import bearing
from masonry_fem.march.model import Model
from masonry_fem.records.remark import remark
from masonry_fem.scene import specs
from masonry_fem.scene.misfit import listed, nearest
from masonry_fem.solid.assembly import Blocks

ROUNDING = 1e-6  # of an angle [degrees]


def joint_of_interfaces(
    scene: specs.Scene, stones: Stones, interfaces: Interfaces, tell: bool = True
) -> list[int]:
    """Number of the joint record that holds for each interface: the last that matches; −1 for a tie.

    Parameters
    ----------
    scene : Has the records. stones : Its blocks.
    interfaces : Where blocks touch.
    tell : Warn of records that hold for no interface.

    Raises
    ------
    SceneError : No record matches an interface.
    """
    if not interfaces:
        return []
    holds = _matching(scene, interfaces, stones.assembly.blocks)
    for number in np.flatnonzero(~holds.any(axis=0) & ~interfaces.tie)[:1]:
        raise SceneError(_no_match(stones, interfaces[number]))
    if tell and not interfaces.tie.all():
        labels = set(interfaces.only(~interfaces.tie).label_of_each)
        _tell_idle(scene, np.flatnonzero(~holds.any(axis=1)).tolist(), labels)
    last = np.where(holds, np.arange(len(holds))[:, None], -1).max(axis=0, initial=-1)
    found: list[int] = last.tolist()
    return found


def _matching(scene: specs.Scene, interfaces: Interfaces, blocks: Blocks) -> NDArray[np.bool_]:
    """Whether each joint record holds for each of i interfaces, shape (records, i); none does for ties."""
    angle = inclinations(interfaces.normal)
    holds = np.zeros((len(scene.joints), len(angle)), dtype=bool)
    for held, joint in zip(holds, scene.joints, strict=True):
        alike = np.array([fnmatchcase(text, joint.interface) for text in interfaces.labels])[interfaces.label]
        least, most = joint.inclination
        inclined = (least - ROUNDING <= angle) & (angle <= most + ROUNDING)
        one, other = (matching(pattern, blocks)[interfaces.blocks] for pattern in joint.between)
        joins = (one[:, 0] & other[:, 1]) | (one[:, 1] & other[:, 0])
        held[:] = alike & inclined & joins & ~interfaces.tie
    return holds


def _no_match(stones: Stones, interface: Interface) -> str:
    """What to say of an interface for which no joint record holds."""
    first, second = (stones.assembly.blocks.names[block] for block in interface.blocks)
    return (
        f"joints: none matches the interface '{interface.label}' between '{first}' and '{second}', "
        f"{inclinations(interface.normal):.3g} degrees to the horizontal; add a joint with interface = '*', "
        "no 'between' and no 'inclination' as the first one"
    )


def touching(
    scene: specs.Scene, stones: Stones, interfaces: Interfaces, tell: bool = True
) -> tuple[Interfaces, list[int]]:
    """The interfaces at which blocks are in contact, and the number of the joint record of each.

    Parameters
    ----------
    scene : Has the joint records. stones : Its blocks.
    interfaces : Where blocks touch, or come near each other.
    tell : Warn of records that hold for no interface.

    Raises
    ------
    SceneError : No record matches an interface.
    """
    chosen = joint_of_interfaces(scene, stones, interfaces, tell)
    # the last is that of ties, whose record is −1
    touches = np.array([*(joint.contact != "none" for joint in scene.joints), True])
    kept = np.flatnonzero(touches[np.array(chosen, dtype=np.int64)])
    return interfaces.only(kept), np.array(chosen, dtype=np.int64)[kept].tolist()


def _tell_idle(scene: specs.Scene, idle: list[int], labels: set[str]) -> None:
    """Warn of joint records that no interface matches: a pattern with a slip of the pen leaves joints dry."""
    default = specs.Joint()
    for index in idle:
        joint = scene.joints[index]
        given = [
            f"{name} = {getattr(joint, name)!r}"
            for name in ("interface", "between", "inclination")
            if getattr(joint, name) != getattr(default, name)
        ]
        near = "" if joint.interface in labels else nearest(joint.interface, sorted(labels))
        remark(
            "idle_joint",
            f"joints.{index} ({', '.join(given)}) matches none of the joints, whose labels are "
            f"{listed(sorted(labels))}{near}; correct it, or drop it",
        )


def inclinations(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles of planes to the horizontal, 0 (beds) to 90 (heads) [degrees]; up is the last axis.

    Parameters
    ----------
    normal : Of each plane, shape (..., d).
    """
    up = np.abs(normal[..., -1])
    angle: NDArray[np.float64] = np.degrees(np.arctan2(np.linalg.norm(normal[..., :-1], axis=-1), up))
    return angle


def contacts_and_joints(
    scene: specs.Scene, stones: Stones, interfaces: Interfaces, chosen: list[int], base: Path
) -> tuple[Interfaces, Contacts, Assignment, dict[str, np.ndarray]]:
    """All interfaces and ties, their contacts and laws, and by parameter the factors by which these scatter.

    Parameters
    ----------
    scene : Has the joint records. stones : Its blocks.
    interfaces : Where blocks touch.
    chosen : Number of the joint record of each interface.
    base : Folder that the paths in the scene are relative to.

    Raises
    ------
    SceneError : A joint or a tie that cannot be.
    """
    foresee_points(scene, np.array([joint.density for joint in scene.joints])[chosen])
    contacts = place(stones.assembly, interfaces, rules_of(scene, stones, interfaces, chosen), tell=True)
    interfaces, contacts = with_ties(scene, stones, interfaces, contacts)
    records = [*chosen, *[-1] * (len(interfaces) - len(chosen))]
    return interfaces, contacts, *joints_at(scene, stones, interfaces, contacts, records, base)


def replaced(
    scene: specs.Scene, stones: Stones, model: Model, base: Path, other: Callable[[Rule, int], Rule]
) -> Model | None:
    """The model with contact points placed by other rules; None where no rule is another.

    Parameters
    ----------
    scene : Has the joint records. stones : Its blocks.
    model : Made of them.
    base : Folder that the paths in the scene are relative to.
    other : Gives the rule to take for an interface, by its rule so far and its number.
    """
    touching = model.interfaces.only(~model.interfaces.tie)  # ties come last
    chosen = joint_of_interfaces(scene, stones, touching, tell=False)
    rules = rules_of(scene, stones, touching, chosen)
    wanted = [other(rule, number) for number, rule in enumerate(rules)]
    if wanted == rules:
        return None
    interfaces, contacts = with_ties(scene, stones, touching, place(stones.assembly, touching, wanted))
    records = [*chosen, *[-1] * (len(interfaces) - len(chosen))]
    laws, scatter = joints_at(scene, stones, interfaces, contacts, records, base)
    return replace(model, contacts=contacts, laws=laws, scatter=scatter)


def rules_of(scene: specs.Scene, stones: Stones, interfaces: Interfaces, chosen: list[int]) -> list[Rule]:
    """The placement rule of each interface.

    Parameters
    ----------
    scene : Has the joint records. stones : Its blocks.
    interfaces : Where blocks touch.
    chosen : Number of the joint record of each interface.
    """
    of_block = stones.assembly.meshed
    either = of_block[interfaces.blocks].any(axis=1)
    names, wanted = _wanted(scene, stones)
    sides = np.where(of_block, wanted, -1)[interfaces.blocks]
    sides = np.where(sides < 0, sides[:, ::-1], sides)  # a rigid side goes along
    usual = np.where(sides[:, 0] == sides[:, 1], sides[:, 0], -1)
    kinds = list(zip(chosen, either.tolist(), usual.tolist(), strict=True))
    made = {
        kind: _rule(scene.joints, kind[0], kind[1], names[kind[2]] if kind[2] >= 0 else "auto")
        for kind in dict.fromkeys(kinds)
    }
    return list(map(made.__getitem__, kinds))


def _wanted(scene: specs.Scene, stones: Stones) -> tuple[list[str], np.ndarray]:
    """Placement rules that stones would have where the scene names none, and the number of each, (b,)."""
    pairs = list(zip(stones.fidelity, stones.material, strict=True))
    own = {
        (name, material): "auto" if name is None else fidelity(name).placement(scene.materials[material])
        for name, material in dict.fromkeys(pairs)
    }
    names = list(dict.fromkeys(own.values()))
    number = {pair: names.index(rule) for pair, rule in own.items()}
    return names, np.fromiter(map(number.__getitem__, pairs), np.int64)


def joints_at(
    scene: specs.Scene,
    stones: Stones,
    interfaces: Interfaces,
    contacts: Contacts,
    chosen: list[int],
    base: Path,
) -> tuple[Assignment, dict[str, np.ndarray]]:
    """Laws of contact points, and by parameter the factors by which these scatter, shape (c,).

    Parameters
    ----------
    scene : Has the joint records. stones : Its blocks.
    interfaces : Where blocks touch.
    contacts : The c contact points on them.
    chosen : Number of the joint record of each interface.
    base : Folder that the paths in the scene are relative to.
    """
    scatter = scatter_factors(scene, interfaces, chosen)
    skin = skins(scene, stones, contacts)
    laws = joint_laws(scene, contacts, interfaces, chosen, base, scatter, skin)
    return laws, {name: values[contacts.interface] for name, values in scatter.items()}


def skins(scene: specs.Scene, stones: Stones, contacts: Contacts) -> np.ndarray | None:
    """What the skins of both stones give way by a unit of pressure, shape (c,) [m³/N]; None: all are firm.

    Stones that deform by a few modes say how thick a layer of themselves stands for what these leave out.

    Parameters
    ----------
    scene : Has the materials. stones : Its blocks. contacts : The c contact points.
    """
    pairs = list(zip(stones.fidelity, stones.material, strict=True))
    soft = {}
    for own, name in set(pairs):
        depth = 0.0 if own is None else fidelity(own).skin(scene.materials[name])
        soft[own, name] = depth / scene.materials[name].modulus if depth else 0.0
    if not any(soft.values()):
        return None
    share = np.fromiter(map(soft.__getitem__, pairs), float)
    faces = np.bincount(contacts.interface, contacts.area)[contacts.interface]
    width = bearing(faces) ** (1.0 / (contacts.dimension - 1))
    given_way: np.ndarray = width * share[contacts.blocks].sum(axis=1)
    return given_way


def _rule(joints: Sequence[specs.Joint], number: int, meshed: bool, usual: str) -> Rule:
    """The placement rule of interfaces with a meshed side or none: the usual one where none is named.

    Raises
    ------
    SceneError : Its contacts would be nearer to the centroid than the rule bears.
    """
    joint = joints[number]
    name = joint.placement or usual
    least = least_inset(name)
    if joint.inset < least:
        raise SceneError(
            f"joints.{number}.inset is {joint.inset:g} with placement '{name}', expected at least "
            f"{least:.3g}: nearer to the centroid contacts cannot bend as the face does; take placement "
            "'corners', or leave inset out"
        )
    if name == "nodes" and not meshed:
        name = "corners"  # a rigid pair of a scene whose elastic joints use nodes
    return Rule(name=name, inset=joint.inset, density=joint.density)

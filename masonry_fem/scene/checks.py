"""Checks: whether the parts of a scene fit together, without building any geometry.

``cross_check`` raises an error at the first contradiction, ``doubts`` lists what is possible but seldom
meant. What depends on the blocks (whether they touch, what a selector selects) is checked once they exist.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec

from masonry_fem.fidelities import deforms
from masonry_fem.scene.combinations import GRAVITY, cases_of
from masonry_fem.scene.joint_checks import check_joints, joint_doubts, law_class
from masonry_fem.scene.lines import KeyPath
from masonry_fem.scene.material_doubts import material_doubts
from masonry_fem.scene.misfit import MisfitError, braced, listed, nearest, wrong
from masonry_fem.scene.quantity import QuantityError, si_factor, si_value
from masonry_fem.scene.specs import (
    Accelerogram,
    MovingLoad,
    Override,
    Pulse,
    PythonLaw,
    PythonMaterial,
    Record,
    Scene,
    Spec,
    Structure,
)
from masonry_fem.scene.stages import predecessor, stage_scenes

NEARLY = 1e-12  # of a squared cosine: directions that differ by less are one


def cross_check(scene: Scene, base: Path) -> None:
    """Raise an error at the first contradiction.

    Parameters
    ----------
    scene : Each value fits its annotation already.
    base : Folder that paths in the scene are relative to.

    Raises
    ------
    MisfitError : Two parts of the scene contradict each other.
    """
    _names(scene)
    _materials(scene)
    _fidelities(scene)
    _own_faults(scene)
    check_joints(scene)
    _analysis(scene)
    _solver(scene)
    _files(scene, base)


def doubts(scene: Scene) -> tuple[str, ...]:
    """What is allowed but seldom meant, one sentence each; of stages each one's scene has its own."""
    return tuple(_weightless(scene) if scene.stages else _doubts(scene))


def records(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, msgspec.Struct]]:
    """Every record of a scene with its key path, outer ones before inner ones.

    Parameters
    ----------
    value : A scene, or a part of it.
    path : Keys that lead to this part.
    """
    if isinstance(value, msgspec.Struct):
        yield path, value
        for name in value.__struct_fields__:
            yield from records(getattr(value, name), (*path, name))
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from records(item, (*path, name))
    elif isinstance(value, tuple):
        for index, item in enumerate(value):
            yield from records(item, (*path, index))


# --- names ------------------------------------------------------------------------------------


def _names(scene: Scene) -> None:
    _unique("structures", (one.name for one in scene.structures))
    _unique("probes", (one.name for one in scene.probes))
    _unique("output.cuts", (one.name for one in scene.output.cuts))
    _unique("ties", (one.name for one in scene.ties))
    _combinations(scene)
    _stages(scene)


def _stages(scene: Scene) -> None:
    _unique("stages", (one.name for one in scene.stages))
    for index, stage in enumerate(scene.stages):
        earlier = [one.name for one in scene.stages[:index]]
        if stage.after is not None and stage.after not in earlier:
            known = (
                f"the name of an earlier stage ({listed(earlier)})" if earlier else "none in the first stage"
            )
            raise wrong(("stages", index, "after"), stage.after, known, nearest(stage.after, earlier))
        if stage.analysis is not None and stage.analysis.start is not None:
            where = "none, as a stage begins where the one before has ended, or 'after'"
            raise wrong(("stages", index, "analysis", "start"), stage.analysis.start, where)


def _combinations(scene: Scene) -> None:
    _unique("combinations", (one.name for one in scene.combinations))
    if scene.combinations and scene.stages:
        expected = "none beside 'stages': combine the loads of one analysis, which may start where one ended"
        raise wrong(("combinations", 0, "name"), scene.combinations[0].name, expected)
    cases = cases_of(scene)
    for index, one in enumerate(scene.combinations):
        if not one.factors:
            raise wrong(("combinations", index, "factors"), one.factors, "factors of at least one load case")
        for case in one.factors:
            if case not in cases:
                known = f"a load case ({listed(cases)})" if cases else "a load case, and no load has one"
                raise wrong(("combinations", index, "factors"), case, known, nearest(case, cases))


def _unique(key: str, names: Iterable[str]) -> None:
    seen: dict[str, int] = {}
    for index, name in enumerate(names):
        if name in seen:
            path: KeyPath = (*key.split("."), index, "name")
            raise wrong(path, name, f"a name of its own ({key}.{seen[name]} has it)")
        seen[name] = index


def _materials(scene: Scene) -> None:
    told: dict[str, Sequence[Structure | Override]] = {
        "structures": scene.structures,
        "overrides": scene.overrides,
    }
    for key, users in told.items():
        for index, user in enumerate(users):
            name = user.material
            if name is not None and name not in scene.materials:
                known = f"one of the materials {listed(scene.materials)}" if scene.materials else "a material"
                raise wrong((key, index, "material"), name, known, nearest(name, scene.materials))


def _fidelities(scene: Scene) -> None:
    """Elastic blocks need a stiffness; those that an override may make rigid are left to the build."""
    softened = any(one.material or (one.fidelity and not deforms(one.fidelity)) for one in scene.overrides)
    for index, structure in enumerate(scene.structures):
        own = structure.fidelity or scene.fidelity
        if deforms(own) and not softened:
            _young(scene, structure.material, f"the {own} blocks of structures.{index} ('{structure.name}')")
    for index, override in enumerate(scene.overrides):
        if deforms(override.fidelity) and override.material is not None:
            _young(scene, override.material, f"the {override.fidelity} blocks of overrides.{index}")


def _young(scene: Scene, material: str, users: str) -> None:
    if not scene.materials[material].stiff:
        cure = "give it (a pressure > 0 in Pa) or make them fidelity = 'rigid'"
        raise MisfitError(
            ("materials", material), f"{{path}} lacks the key 'young' that {braced(users)} need; {cure}"
        )


# --- what a record says of itself -------------------------------------------------------------


def _own_faults(scene: Scene) -> None:
    """Each record by itself; lengths of vectors were held against the dimension on reading."""
    for path, record in records(scene):
        for key, expected in record.faults(scene.dimension) if isinstance(record, Spec) else ():
            value: Any = record
            place = path
            for part in key.split("."):  # 'openings.0.size': a key of a table within
                step = int(part) if part.isdecimal() else part
                value = value[step] if isinstance(step, int) else getattr(value, step)
                place = (*place, step)
            if value is None:
                lacking = f"{{path}} lacks the key '{place[-1]}', expected {braced(expected)}"
                raise MisfitError(place[:-1], lacking)
            raise wrong(place, value, expected)


# --- analysis, files --------------------------------------------------------------------------


def _analysis(scene: Scene) -> None:
    analysis = scene.analysis
    if analysis.travelled(analysis.end) and not scene.loads.moving:
        expected = "'statics' where no load moves; take it, or add [[loads.moving]]"
        raise wrong(("analysis", "kind"), analysis.__struct_config__.tag, expected)
    for index, load in enumerate(scene.loads.moving):
        _moving(load, index)
    if scene.loads.accelerograms and not analysis.inertia:
        moved = scene.loads.accelerograms[0]
        expected = "none in statics, which has no time; take analysis.kind = 'dynamics'"
        raise wrong(("loads", "accelerograms", 0, "acts"), moved.acts, expected)
    if analysis.steers:
        _steered(scene)
    tolerance = getattr(analysis, "tolerance", None)
    if tolerance is not None and scene.solver.aim > tolerance:
        # contacts that are solved no better never pass for at rest: the march would end as if blocks slid
        expected = f"at most the tolerance of the equilibrium (analysis.tolerance = {tolerance:g})"
        raise wrong(("solver", "tolerance"), scene.solver.aim, f"{expected}; tighten it or loosen that")


def _moving(load: MovingLoad, index: int) -> None:
    path = ("loads", "moving", index)
    for number, (one, other) in enumerate(pairwise(load.path), start=1):
        step = [b - a for a, b in zip(one, other, strict=True)]
        if not any(step):
            raise wrong((*path, "path", number), other, "another point than the one before")
        if _parallel(step, load.vector):
            expected = "a force that is not zero, and not along its path"
            raise wrong((*path, "vector"), load.vector, expected)
    if load.width is not None and len(load.vector) == 2:
        raise wrong((*path, "width"), load.width, "none in 2D, where forces are by metre of depth")


def _parallel(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two vectors have one direction, or one of them has none."""
    product = sum(a * b for a, b in zip(one, other, strict=True))
    squares = sum(a * a for a in one) * sum(b * b for b in other)
    return product * product >= squares * (1 - NEARLY)


def _steered(scene: Scene) -> None:
    """A path moves the blocks by its loads alone, and cannot follow what softens."""
    none = f"none with analysis.kind = '{scene.analysis.__struct_config__.tag}': its loads move the blocks"
    for index, support in enumerate(scene.supports):
        if support.motion is not None:
            raise wrong(("supports", index, "motion"), support.motion, f"{none}; push by a load instead")
    if scene.loads.temperatures:
        heated = scene.loads.temperatures[0].on
        raise wrong(("loads", "temperatures", 0, "on"), heated, f"{none}; heat them in statics")
    for index, joint in enumerate(scene.joints):
        law = law_class(joint)
        if joint.law is not None and law is not None and law.softens:
            expected = "'elastic', or no law: a path (analysis.kind) cannot follow joints that soften"
            cure = "; where these are to break move a support in statics"
            raise wrong(("joints", index, "law", "kind"), joint.law.kind, expected, cure)


def _solver(scene: Scene) -> None:
    solver = scene.solver
    for name, usual in (("relaxation", 1.0), ("threads", None)):
        given = getattr(solver, name)
        if solver.method != "nsgs" and given != usual:
            expected = f"none with solver.method = {solver.method!r}: only 'nsgs' has it"
            raise wrong(("solver", name), given, f"{expected}; leave it out or choose that method")
    if solver.method == "nsgs" and not scene.analysis.inertia:
        expected = "another one in statics: sweeps want bodies with inertia"
        cure = "; use method 'auto' or 'newton', or analysis.kind = 'dynamics'"
        raise wrong(("solver", "method"), solver.method, expected, cure)


def _files(scene: Scene, base: Path) -> None:
    for path, record in records(scene):
        if isinstance(record, Pulse):
            _pulse(record, path)
        elif isinstance(record, Structure) and record.source is not None:
            if Path(record.source).suffix.lower() not in record.endings:
                raise wrong((*path, "path"), record.source, f"a file that ends in {listed(record.endings)}")
            _exists(record.source, (*path, "path"), base)
        elif isinstance(record, Record):
            _exists(record.path, (*path, "path"), base)
            for key, unit in (("unit", record.unit), ("time_unit", record.time_unit)):
                _unit(unit, (*path, key))
        elif isinstance(record, Accelerogram):
            for axis, name in record.files.items():
                _exists(name, (*path, axis), base)
        elif isinstance(record, PythonLaw | PythonMaterial):
            _exists(record.file, (*path, "file"), base)


def _pulse(pulse: Pulse, path: KeyPath) -> None:
    if pulse.every is not None and pulse.every < pulse.duration:
        expected = f"a time not shorter than a pulse ({pulse.duration:g} s)"
        raise wrong((*path, "every"), pulse.every, expected)
    if pulse.count is not None and pulse.every is None:
        raise wrong((*path, "count"), pulse.count, "none without 'every': there is one pulse; give both")


def _unit(unit: str | None, path: KeyPath) -> None:
    if unit is None:
        return
    timed = path[-1] == "time_unit"
    try:
        _ = si_value(f"1 {unit}", "s") if timed else si_factor(unit)
    except QuantityError as error:
        expected = "a unit of time, as 'ms'" if timed else "a unit, as 'kN'"
        raise wrong(path, unit, expected, str(error)) from error


def _exists(name: str, path: KeyPath, base: Path) -> None:
    if not (base / name).is_file():
        folder = (base / name).parent
        files = folder.iterdir() if folder.is_dir() else ()
        beside = [one.name for one in files if one.suffix == Path(name).suffix and one.is_file()]
        raise wrong(path, name, f"an existing file in '{base}'", nearest(Path(name).name, beside))


# --- doubts -----------------------------------------------------------------------------------


def _doubts(scene: Scene) -> Iterator[str]:
    yield from _dragged(scene)
    yield from _light(scene)
    if not _driven(scene):
        yield "nothing acts on the blocks; expected loads.gravity or another load"
    yield from material_doubts(scene)
    if not scene.supports and not any(structure.carries for structure in scene.structures):
        yield "nothing holds the blocks; expected a ground, springings or [[supports]]"
    if not scene.analysis.inertia:
        for index, load in enumerate(scene.loads.moving):
            if load.speed:
                yield (
                    f"true statics has no velocities: loads.moving.{index}.speed has no effect; "
                    "analysis.kind = 'crossing' takes loads along their paths"
                )
    if not scene.analysis.inertia and scene.initial:
        yield "true statics has no velocities: [[initial]] has no effect"
    for index, joint in enumerate(scene.joints):
        yield from joint_doubts(joint, f"joints.{index}")


def _dragged(scene: Scene) -> Iterator[str]:
    """Damping that holds stones in space while their ground moves."""
    if not any(one.acts == "ground" for one in scene.loads.accelerograms):
        return
    for name, stone in scene.materials.items():
        if stone.damping.mass:
            yield (
                f"materials.{name}.damping.mass = {stone.damping.mass:g} 1/s damps velocities in space, "
                "and the ground moves: it drags stones back from going with it; take acts = 'inertia', "
                "or damping.stiffness"
            )


def _light(scene: Scene) -> Iterator[str]:
    """Combinations in which nothing weighs."""
    light = [one.name for one in scene.combinations if not one.factors.get(GRAVITY)]
    if light and scene.loads.gravity is not None:
        yield (
            f"loads.gravity does not act in {listed(light)} of the combinations; if it should, name it in "
            "their factors: gravity = 1.0"
        )


def _weightless(scene: Scene) -> Iterator[str]:
    """Stages whose loads take the place of gravity, too."""
    had: dict[str | None, bool] = {None: scene.loads.gravity is not None}
    for stage, own in stage_scenes(scene):
        had[stage.name] = own.loads.gravity is not None
        if had[predecessor(scene, stage)] and not had[stage.name]:
            yield (
                f"nothing weighs any more in stage '{stage.name}': its loads take the place of all loads, "
                f"and have no gravity; if it should act, give it again in stages.{stage.name}.loads.gravity"
            )


def _driven(scene: Scene) -> bool:
    """Whether loads, initial velocities or supports that move make the blocks do anything."""
    loads = scene.loads
    pushed = (
        loads.accelerations
        or loads.accelerograms
        or loads.tractions
        or loads.pressures
        or loads.points
        or loads.lines
        or loads.moving
        or loads.temperatures
    )
    moved = any(support.motion is not None for support in scene.supports)
    return loads.gravity is not None or bool(pushed or scene.initial) or moved

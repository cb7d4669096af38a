"""Discretisation: what elements, contact points and time steps leave open, in a few numbers.

    errors_of(scene, built, made, base)
    # {"stress": 0.073, "contact": {"supports": 0.002, ...}, "time": {"dissipated": 0.01, ...}}

Stress: Zienkiewicz and Zhu's estimate. Contact: the change where the same structure is solved once more with
contact points placed otherwise. Time: what the energy ledger tells.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.build import Built
from masonry_fem.build.joints import replaced
from masonry_fem.contact.placement import Rule
from masonry_fem.march.clock import Clock
from masonry_fem.march.march import March, march
from masonry_fem.output.stress_error import block_errors
from masonry_fem.records.remark import gathered
from masonry_fem.results.discretisation import ContactError, Errors, TimeError
from masonry_fem.scene import specs

FloatArray = NDArray[np.float64]

ROUNDING = 1e-11  # of a block's size: probes that move less than that say nothing


def errors_of(scene: specs.Scene, built: Built, made: March, base: Path) -> Errors:
    """What ``summary.json`` holds as ``errors``; what does not apply is left out.

    Parameters
    ----------
    scene : What was run.
    built : The model made of it.
    made : How the march ended.
    base : Folder that the paths in the scene are relative to.
    """
    stress = block_errors(made.model, made.state)
    return Errors(
        stress=None if stress is None else stress.relative,
        contact=contact_error(scene, built, made, base) if scene.output.contact_error else None,
        time=None if scene.analysis.seeks_equilibrium else time_error(scene.analysis, made),
    )


# --- time -------------------------------------------------------------------------------------


def time_error(analysis: specs.Analysis, made: March) -> TimeError:
    """Energy that the scheme lost, and that it lost count of, over the largest energy of the march."""
    largest = made.ledger.largest
    note = (
        "theta = 0.5 keeps energy with any step, so that energy tells nothing of phases and peaks; halve "
        "analysis.step and compare"
    )
    return TimeError(
        dissipated=made.ledger.numerical_dissipation / largest if largest > 0 else 0.0,
        imbalance=made.ledger.imbalance,
        note=note if getattr(analysis, "theta", None) == 0.5 else None,
    )


# --- contact ----------------------------------------------------------------------------------


def contact_error(scene: specs.Scene, built: Built, made: March, base: Path) -> ContactError:
    """Changes, relative, where the analysis is made again with contact points placed by the other rule."""
    clock = Clock()
    if built.model.update is not None:
        return ContactError(note="contacts are found anew during the march: there is nothing to compare with")
    if not built.model.contacts.count:
        return ContactError(note="nothing touches: there are no contact points to place otherwise")
    assembly, interfaces = built.model.assembly, built.model.interfaces
    meshed = assembly.meshed[interfaces.blocks[~interfaces.tie]].any(axis=1).tolist()
    model = replaced(scene, built.stones, built.model, base, lambda rule, i: other(rule, meshed[i]))
    if model is None:
        return ContactError(note="contact points at corners of rigid faces: more would carry nothing else")
    with gathered(aloud=False):  # of what is compared only
        again = march(model, scene.analysis, scene.solver.settings, bodies=built.bodies)
    clock.lap("again")
    alike = again.outcome == made.outcome
    return ContactError(
        points=built.model.contacts.count,
        points_again=model.contacts.count,
        outcome_again=None if alike else again.outcome,
        note=None if alike else f"with other contact points: {again.message}",
        **(changes(made, again) if alike else {}),
        seconds=round(clock.phases["again"], 3),
    )


def other(rule: Rule, meshed: bool) -> Rule:
    """The rule to compare with: Gauss points for nodes and nodes for these, denser Gauss points if rigid.

    Corners of rigid faces stay: whatever presses the face, they can carry.
    """
    if meshed:
        return replace(rule, name="nodes" if rule.name in ("gauss", "corners") else "gauss")
    return replace(rule, density=rule.density + 1) if rule.name == "gauss" else rule


def changes(made: March, again: March) -> dict[str, Any]:
    """Changes of support forces, probes and stresses, each over the largest or the norm of its kind.

    ``supports`` : greatest change of a support's force. ``probes`` : of a probe's displacement,
    where one moves.
    ``stress`` : of the stress in the mean over the volume, ``block_stress`` : of the blocks' means.
    """
    told: dict[str, Any] = {}
    first, second = made.report, again.report
    d = made.model.assembly.dimension
    if first.support_resultants:
        forces = [
            (value[:d], second.support_resultants[name][:d])
            for name, value in first.support_resultants.items()
        ]
        told["supports"] = _greatest(forces, float(np.linalg.norm(first.applied[:d])))
    moved = max((float(np.linalg.norm(value)) for value in first.probes.values()), default=0.0)
    if moved > ROUNDING * made.model.length:
        told["probes"] = _greatest([(value, second.probes[name]) for name, value in first.probes.items()])
    points, blocks = [np.zeros(2)], [np.zeros(2)]
    for group, one, other_one in zip(made.model.groups, made.state.bodies, again.state.bodies, strict=True):
        before, after = group.stress(one), group.stress(other_one)
        if before is None or after is None:
            continue
        pair = np.stack([before.gauss, after.gauss - before.gauss])
        points.append(np.einsum("ebcp,cp->e", _square(pair), before.weight))
        mean = np.einsum("ebcps,cp->ebs", pair, before.weight) / before.weight.sum()
        blocks.append(_square(mean).sum(axis=1) * before.weight.sum())
    if len(points) > 1:
        told["stress"], told["block_stress"] = _relative(points), _relative(blocks)
    return told


def _square(stress: FloatArray) -> FloatArray:
    """σ : σ of stresses (..., 6)."""
    square: FloatArray = np.square(stress[..., :3]).sum(axis=-1) + 2 * np.square(stress[..., 3:]).sum(axis=-1)
    return square


def _greatest(pairs: list[tuple[FloatArray, FloatArray]], least: float = 0.0) -> float:
    largest = max(least, *(float(np.linalg.norm(a)) for a, _ in pairs))
    change = max(float(np.linalg.norm(b - a)) for a, b in pairs)
    return change / largest if largest > 0 else 0.0


def _relative(parts: list[FloatArray]) -> float:
    whole, change = np.sum(parts, axis=0)
    return float(np.sqrt(change / whole)) if whole > 0 else 0.0

"""Run: a scene from its description to results on disk.

from masonry_fem.scene import load
from masonry_fem.run import run
result = run(load("arch.toml"), Path("results"), base=Path("."))
result.outcome, result.summary["supports"], result.files
"""

from __future__ import annotations

import importlib.metadata
import logging
import os
import platform
import resource
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem import __version__
from masonry_fem.build import Built, build, solver_settings, strategy
from masonry_fem.dynamics.clock import Clock
from masonry_fem.dynamics.determinacy import ForceDeterminacy, determine
from masonry_fem.dynamics.march import March, Observer, march
from masonry_fem.dynamics.mechanism import mechanism_of_step
from masonry_fem.dynamics.step import Increment
from masonry_fem.errors import MasonryError
from masonry_fem.nscd import save_problem
from masonry_fem.post.cut import Plane
from masonry_fem.post.determinacy import determinacy_summary, write_determinacy
from masonry_fem.post.history import History
from masonry_fem.post.interface_table import InterfaceTable, joint_summary
from masonry_fem.post.mechanism_picture import draw_mechanism
from masonry_fem.post.picture import Pictures
from masonry_fem.post.recorder import Recorder, Recorders
from masonry_fem.post.render import can_render
from masonry_fem.post.report import Progress
from masonry_fem.post.scenery import Scenery
from masonry_fem.post.summary import status_counts, stress_summary, write_summary
from masonry_fem.post.vtu import FieldFiles
from masonry_fem.scene import check, specs

logger = logging.getLogger(__name__)

LIBRARIES = ("numpy", "scipy", "numba", "gmsh", "pyvista", "fenics-dolfinx", "dolfinx-solver-real")


@dataclass(frozen=True, slots=True)
class RunResult:
    """What a run leaves.

    Attributes
    ----------
    outcome : ``equilibrium``, ``finished``, ``no_convergence`` or ``no_equilibrium``.
    message : The same as a sentence.
    summary : What ``summary.json`` holds.
    files : Files written.
    built, march : The model and the march, for further work in Python.
    """

    outcome: str
    message: str
    summary: dict[str, Any]
    files: list[Path]
    built: Built
    march: March


def run(
    scene: specs.Scene,
    out: Path,
    *,
    base: Path = Path(),
    save_contact: int | None = None,
    quiet: bool = True,
) -> RunResult:
    """Solve a scene and write its results to the folder ``out``.

    Parameters
    ----------
    scene : What to solve. base : Folder that the paths in it are relative to.
    out : Folder for the results; made where it is missing.
    save_contact : Step whose contact problem is saved as ``contact_<step>.npz``.
    quiet : No progress bar.

    Raises
    ------
    MasonryError : Where the scene cannot be built or has no such step; nothing is written then.
    """
    clock = Clock()
    scene = check(scene, base=base)
    plan = strategy(scene.analysis)
    _check_step(save_contact, plan.steps)
    built = build(scene, base)
    clock.lap("build")
    limits = _limits(scene, built)
    _make_folder(out)
    table = InterfaceTable(out, fields=scene.output.fields) if scene.output.interfaces else None
    recorders = _recorders(scene, out, quiet, table)
    recorders.start(built.model)
    kept: list[Increment] = []
    summary: dict[str, Any] = {
        "title": scene.title,
        "outcome": "interrupted",
        "message": "Ended before it was done; history.csv and the field files hold the steps so far.",
    }
    try:
        made = march(
            built.model,
            plan,
            solver_settings(scene.solver),
            bodies=built.bodies,
            observers=(recorders,),
            keep=save_contact,
            kept=kept,
        )
        clock.lap("march")
        summary = summarise(scene, built, made) | limits
        _compare(summary)
        told = _determinacy(scene, built, made, summary)
        if told is not None:
            recorders.amend(made.model, told.state, made.report)
            if table is not None:
                table.determine(told)
        summary |= _joints(scene, made, told)
    finally:  # Ctrl-C too leaves what was written so far readable
        files = recorders.close(summary)
        write_summary(out / "summary.json", summary)
    clock.lap("output")
    summary["seconds"] = _seconds(built, made, clock)
    if kept:
        files.append(_save_problem(out, save_contact, kept))
    elif save_contact is not None:
        logger.warning("step %d was not reached: its contact problem is not saved", save_contact)
    if made.outcome == "no_equilibrium" and scene.output.pictures:
        files += _picture(scene, made, out)
    if told is not None:
        files.append(write_determinacy(out / "determinacy.csv", made.model, told))
    files.append(write_summary(out / "summary.json", summary))
    return RunResult(made.outcome, made.message, summary, files, built, made)


def solve_scene(scene: specs.Scene, base: Path = Path(), observers: Sequence[Observer] = ()) -> RunResult:
    """Solve a scene without writing anything; ``observers`` see each step's state and report."""
    scene = check(scene, base=base)
    built = build(scene, base)
    limits = _limits(scene, built)
    plan, settings = strategy(scene.analysis), solver_settings(scene.solver)
    made = march(built.model, plan, settings, bodies=built.bodies, observers=observers)
    summary = summarise(scene, built, made) | limits
    _compare(summary)
    told = _determinacy(scene, built, made, summary)
    summary |= _joints(scene, made, told)
    return RunResult(made.outcome, made.message, summary, [], built, made)


def _joints(scene: specs.Scene, made: March, told: ForceDeterminacy | None) -> dict[str, Any]:
    """Joints by state, where the scene asks for them."""
    if not scene.output.interfaces or not made.model.interfaces:
        return {}
    return {"joints": joint_summary(made.model, made.state if told is None else told.state)}


def _limits(scene: specs.Scene, built: Built) -> dict[str, Any]:
    """What limit analysis says, where the scene asks for it; before the march, as it may refuse."""
    if not scene.output.limit_analysis:
        return {}
    from masonry_fem.limit_analysis import reported  # noqa: PLC0415 - only scenes that ask need its solvers

    return {"limit_analysis": reported(scene, built)}


def _compare(summary: dict[str, Any]) -> None:
    """Hold the supports' forces of an equilibrium against their intervals, where limit analysis was asked."""
    if "limit_analysis" in summary and summary["outcome"] == "equilibrium":
        from masonry_fem.limit.answers import outside  # noqa: PLC0415 - as above

        told = summary["limit_analysis"]
        told["outside"] = outside(told, summary["supports"], summary["applied"])


def _determinacy(
    scene: specs.Scene, built: Built, made: March, summary: dict[str, Any]
) -> ForceDeterminacy | None:
    """What is determined, where the scene asks for it; it goes to the summary, with its reactions."""
    if not scene.output.determinacy:
        return None
    if not made.last.solution.converged:
        summary["determinacy"] = {
            "reactions": "as solved, which is not to the tolerance: nothing is determined"
        }
        return None
    told = determine(made.model, made.last)
    d = built.model.assembly.dimension
    summary["supports"] = {name: _wrench(value, d) for name, value in told.supports.items()}
    summary["status"] = status_counts(told.state)
    summary["determinacy"] = determinacy_summary(made.model, told)
    return told


def _check_step(save_contact: int | None, steps: int) -> None:
    if save_contact is not None and not 1 <= save_contact <= steps:
        expected = "1, the only step" if steps == 1 else f"a step from 1 to {steps}"
        raise MasonryError(f"step to save is {save_contact}, expected {expected} of this analysis")


def _make_folder(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if isinstance(error, FileExistsError) else error.strerror
        raise MasonryError(f"results folder '{out}' cannot be made: {reason}; choose another one") from error


def _recorders(scene: specs.Scene, out: Path, quiet: bool, table: InterfaceTable | None) -> Recorders:
    members: list[Recorder] = [_progress(scene, quiet), History(out)]
    if scene.output.fields:
        members.append(FieldFiles(out))
    if table is not None:
        members.append(table)
    if scene.output.pictures:
        output = scene.output
        planes = [Plane(one.name, one.point, one.normal, one.show) for one in output.cuts]
        members.append(
            Pictures(out, scene.title, output.amplification, joints=output.interfaces, cuts=planes)
        )
    return Recorders(members, scene.output.every)


def _progress(scene: specs.Scene, quiet: bool) -> Progress:
    plan = strategy(scene.analysis)
    if plan.parts > 1:  # how many steps there will be is not known
        return Progress(end=1.0, quiet=quiet)
    return Progress(plan.steps, quiet=quiet)


def _save_problem(out: Path, step: int | None, kept: list[Increment]) -> Path:
    path = out / f"contact_{step}.npz"
    save_problem(kept[0].problem, path)
    return path


def summarise(scene: specs.Scene, built: Built, made: March) -> dict[str, Any]:
    """Everything ``summary.json`` holds."""
    report, model = made.report, built.model
    d = model.assembly.dimension
    return {
        "title": scene.title,
        "outcome": made.outcome,
        "message": made.message,
        "time": report.time,
        "steps": report.step,
        **size(built),
        **_scatter(scene, built),
        **_abrupt(made),
        "supports": {name: _wrench(value, d) for name, value in report.support_resultants.items()},
        "applied": report.applied[:d],
        "certificate": certificate(made),
        "stress": stress_summary(model, made.state),
        "probes": report.probes,
        "status": status_counts(made.state),
        **_mechanism(made),
        "moving": [{"block": name, "speed": speed, "how": how} for name, speed, how in made.moving],
        "energy": {
            "kinetic": report.kinetic_energy,
            "strain": report.strain_energy,
            "external_work": made.ledger.external,
            "support_work": made.ledger.support,
            "joints": report.joint_energy,
            "joint_dissipation": made.ledger.joints,
            "joint_viscosity": made.ledger.viscous,
            "friction_dissipation": made.ledger.friction,
            "damping_dissipation": made.ledger.damping,
            "numerical_dissipation": made.ledger.numerical,
        },
        "solver": {
            "method": report.method,
            "iterations": report.iterations,
            "linear_solves": report.linear_solves,
        },
        "seconds": _seconds(built, made, None),
        "peak_memory_mb": peak_memory(),
        "versions": versions(),
    }


def _mechanism(made: March) -> dict[str, Any]:
    """How the blocks move where there is no equilibrium; nothing where there is."""
    if made.outcome != "no_equilibrium":
        return {}
    return {"mechanism": mechanism_of_step(made.last, made.model).told()}


def _picture(scene: specs.Scene, made: March, out: Path) -> list[Path]:
    """The mechanism, on the structure as it was when the last step began, where this machine can draw."""
    found = mechanism_of_step(made.last, made.model)
    if not found.parts or not can_render():
        return []
    scenery = Scenery.of(made.model, made.last.before, title=scene.title)
    return [draw_mechanism(scenery, found, out / "mechanism.png")]


def _abrupt(made: March) -> dict[str, Any]:
    """Steps in which joints gave way between two known states; nothing where none did."""
    if not made.abrupt:
        return {}
    return {"abrupt": {"steps": len(made.abrupt), "first": made.abrupt[0], "last": made.abrupt[-1]}}


def _scatter(scene: specs.Scene, built: Built) -> dict[str, Any]:
    """Seeds of the joints' random fields and how far their properties went; nothing where none scatters."""
    factors = built.model.scatter
    if not factors:
        return {}
    seeds = [joint.scatter.seed for joint in scene.joints if joint.scatter is not None]
    ends = {name: [float(values.min()), float(values.max())] for name, values in factors.items()}
    return {"scatter": {"seeds": seeds, "factors": ends}}


def size(built: Built) -> dict[str, int]:
    """How large a model is: blocks, shapes, interfaces, contacts, unknowns."""
    model = built.model
    d = model.assembly.dimension
    free = [group for group in model.groups if not group.prescribed]
    unknowns = sum(group.nodes(0).size * len(group.blocks) for group in free if group.cell != "polytope")
    unknowns += sum((3 if d == 2 else 6) * len(group.blocks) for group in free)
    used = {model.assembly.blocks[int(block)].shape for group in free for block in group.blocks}
    return {
        "blocks": len(model.assembly.blocks),
        "shapes": len(used),
        "interfaces": len(model.interfaces),
        "contacts": model.contacts.count,
        "unknowns": unknowns + d * model.contacts.count,
    }


def certificate(made: March) -> dict[str, float]:
    """How exact the last state is, by measures that no solver has a say in.

    ``natural_map``, ``cone_violation``, ``block_balance``, ``global_balance`` and
    ``energy_balance`` are relative; ``max_penetration`` is in m, ``min_normal_reaction`` in N. With cohesion
    normal reaction and cone are those of contact, what the joint pulls taken off.
    """
    report, problem, solution = made.report, made.last.problem, made.last.solution
    pressed = problem.contact_part(solution.impulse, solution.velocity) / made.last.scheme.step
    tangent = np.linalg.norm(pressed[:, 1:], axis=1)
    largest = float(np.linalg.norm(made.state.reaction, axis=1).max(initial=0.0))
    excess = float(np.maximum(tangent - problem.friction * pressed[:, 0], 0).max(initial=0.0))
    return {
        "natural_map": max(report.quality.natural_map, report.quality.natural_map_velocity),
        "max_penetration": report.max_penetration,
        "min_normal_reaction": float(np.minimum(pressed[:, 0], 0).min(initial=0.0)),
        "cone_violation": excess / largest if largest > 0 else 0.0,
        "block_balance": report.block_balance,
        "global_balance": report.global_balance,
        "energy_balance": made.ledger.imbalance,
    }


def _wrench(value: np.ndarray, dimension: int) -> dict[str, np.ndarray]:
    return {"force": value[:dimension], "moment": value[dimension:]}


def _seconds(built: Built, made: March, clock: Clock | None) -> dict[str, float]:
    """CPU time by phase: import, mesh, assemble, factorise, detect, solve, step, output."""
    seconds = dict(built.seconds)
    for phase, value in made.seconds.items():
        seconds[phase] = seconds.get(phase, 0.0) + value
    if clock is not None:
        seconds["output"] = clock.phases["output"]
    order = ("import", "mesh", "assemble", "factorise", "detect", "solve", "step", "measure", "output")
    return {phase: round(seconds.get(phase, 0.0), 4) for phase in order}


def peak_memory() -> float:
    """Largest resident memory of this process so far [MB]."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024**2 if platform.system() == "Darwin" else 1024)


def versions() -> dict[str, str]:
    """Versions of this program and of the libraries that shape its numbers."""
    found = {"masonry_fem": __version__, "python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


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
    _make_folder(out)
    return write_mesh_files(built.model, out, scene.title)

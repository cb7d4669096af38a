"""Summarise: the summary of a march."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_fem import __version__
from masonry_fem.build import Built
from masonry_fem.host.memory import peak_memory
from masonry_fem.host.ranks import HANDING, Spent, team
from masonry_fem.march.march import March
from masonry_fem.march.measure import largest_force
from masonry_fem.march.model import Model
from masonry_fem.march.rounding import force_rounding
from masonry_fem.nscd import rounding
from masonry_fem.records.remark import remark
from masonry_fem.results.blocks import status_counts, stress_summary
from masonry_fem.results.damping import damping_told
from masonry_fem.results.discretisation import Errors
from masonry_fem.results.joints import ties_told
from masonry_fem.results.summary import (
    Abrupt,
    Certificate,
    Mover,
    RanksTold,
    Rounding,
    ScatterTold,
    SolverTold,
    Summary,
    WorkTold,
    Wrench,
)
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.march.mechanism import Falling

PHASES = (
    "build", "mesh", "detect", "import", "assemble", "factorise", "solve", "step", "measure", "output"
)  # fmt: skip
LIBRARIES = ("numpy", "scipy", "numba", "gmsh", "pyvista", "fenics-dolfinx", "dolfinx-solver-real")


def summarise(scene: specs.Scene, built: Built, made: March, **others: Any) -> Summary:
    """The summary of a march.

    Parameters
    ----------
    scene : What was run. built : The model made of it.
    made : How the march ended.
    others : Further keys of the summary, from analyses that follow the march.
    """
    report, model = made.report, built.model
    d = model.assembly.dimension
    return Summary(
        title=scene.title,
        outcome=made.outcome,
        message=made.message,
        time=report.time,
        steps=report.step,
        **size(made.model),
        factorisations=sum(group.factorisations for group in built.model.groups),
        scatter=_scatter(scene, made.model),
        abrupt=_abrupt(made),
        supports=wrenches(report.support_resultants, d),
        applied=report.applied[:d],
        load_factors=scene.design.loads.used or None,
        damping=damping_told(scene, built, made),
        certificate=certificate(made),
        stress=stress_summary(model, made.state),
        ties=ties_told(made.model, made.state),
        probes=dict(report.probes),
        status=status_counts(made.state),
        mechanism=_mechanism(made),
        moving=tuple(Mover(block=name, speed=speed, how=how) for name, speed, how in made.moving),
        energy=made.ledger,
        solver=SolverTold(
            method=report.method,
            iterations=report.iterations,
            linear_solves=report.linear_solves,
            rounds=report.rounds or None,
        ),
        seconds=seconds(built, made),
        peak_memory_mb=peak_memory(),
        ranks=_ranks(),
        versions=versions(),
        errors=Errors(),
        **others,
    )


def _mechanism(made: March) -> Falling | None:
    """How the blocks move where there is no equilibrium; None where there is."""
    if made.outcome != "no_equilibrium":
        return None
    from masonry_fem.march.recognition import mechanism_of_step  # noqa: PLC0415 - what stands needs none

    return mechanism_of_step(made.last, made.model).told()


def _abrupt(made: March) -> Abrupt | None:
    """Steps in which joints gave way between two known states; None where none did."""
    if not made.abrupt:
        return None
    return Abrupt(steps=len(made.abrupt), first=made.abrupt[0], last=made.abrupt[-1])


def _scatter(scene: specs.Scene, model: Model) -> ScatterTold | None:
    """How far the joints' properties went that scatter; None where none does."""
    factors = model.scatter
    if not factors:
        return None
    return ScatterTold(
        seeds=tuple(joint.scatter.seed for joint in scene.joints if joint.scatter is not None),
        factors={name: (float(values.min()), float(values.max())) for name, values in factors.items()},
    )


def size(model: Model) -> dict[str, Any]:
    """How large a model is: blocks, shapes, interfaces, contacts, unknowns."""
    free = [group for group in model.groups if not group.prescribed]
    shapes = [np.unique(model.assembly.blocks.shape[group.blocks]).tolist() for group in free]
    return {
        "blocks": len(model.assembly.blocks),
        "shapes": len(set().union(*shapes)),
        "meshes": sum(shape.mesh is not None for shape in model.assembly.shapes),
        "interfaces": len(model.interfaces),
        "contacts": model.contacts.count,
        "unknowns": sum(group.unknowns for group in free) + model.assembly.dimension * model.contacts.count,
    }


def certificate(made: March) -> Certificate:
    """How exact the last state is."""
    report, problem, solution = made.report, made.last.problem, made.last.solution
    pressed = problem.contact_part(solution.impulse, solution.velocity) / made.last.scheme.step
    tangent = np.linalg.norm(pressed[:, 1:], axis=1)
    largest = float(np.linalg.norm(made.state.reaction, axis=1).max(initial=0.0))
    excess = float(np.maximum(tangent - problem.friction * pressed[:, 0], 0).max(initial=0.0))
    return Certificate(
        natural_map=max(report.quality.natural_map, report.quality.natural_map_velocity),
        rounding=_rounding(made, largest),
        max_penetration=report.max_penetration,
        min_normal_reaction=float(np.minimum(pressed[:, 0], 0).min(initial=0.0)),
        cone_violation=excess / largest if largest > 0 else 0.0,
        block_balance=report.block_balance,
        global_balance=report.global_balance,
        energy_balance=made.ledger.imbalance,
        written=None if made.witness is None else made.witness.told,
    )


def _rounding(made: March, largest: float) -> Rounding:
    """What rounding may make of the measures; the last contact problem has this ``largest`` reaction [N]."""
    problem, solution, h = made.last.problem, made.last.solution, made.last.scheme.step
    known = solution.rounding or rounding(problem, solution.impulse, solution.rigid_velocity)
    acting, supports = made.last.after.acting, made.report.support_resultants
    assert acting is not None  # a step that was measured
    scale = largest_force(acting, supports, made.state.reaction)
    return Rounding(
        natural_map=max(known.natural_map, known.natural_map_velocity),
        max_penetration=h * known.max_penetration,
        min_normal_reaction=known.min_normal / h,
        cone_violation=known.cone_violation / h / largest if largest > 0 else 0.0,
        block_balance=known.block_balance,
        global_balance=force_rounding(made.model, made.last, acting) / scale if scale > 0 else 0.0,
        energy_balance=made.ledger.rounded,
    )


def wrenches(values: Mapping[str, np.ndarray], dimension: int) -> dict[str, Wrench]:
    """Vectors of force and moment, parted, by name.

    Parameters
    ----------
    values : Force [N] and moment about the origin [N m] in one vector, shape (3,) in 2D, (6,) in 3D.
    dimension : 2 or 3.
    """
    return {name: Wrench(force=value[:dimension], moment=value[dimension:]) for name, value in values.items()}


def seconds(built: Built, made: March) -> dict[str, float]:
    """CPU time by phase [s], only of the phases that the scene needed.

    Parameters
    ----------
    built : The model, with the time that it took to build.
    made : The march, with the time of its steps.
    """
    seconds = dict(built.seconds)
    for phase, value in made.seconds.items():
        seconds[phase] = seconds.get(phase, 0.0) + value
    return {phase: round(seconds[phase], 4) for phase in PHASES if phase in seconds}


def _ranks() -> RanksTold | None:
    """What several ranks have spent; None where there is one process."""
    spent = team().spent()
    if not spent:
        return None
    kinds = dict.fromkeys(kind for of_rank, _ in spent for kind in of_rank)
    memory = tuple(round(peak, 1) for _, peak in spent)
    if kinds.keys() <= HANDING:
        idle = len(spent) - 1
        remark(
            "idle_ranks",
            "nothing of this scene is split among ranks: one did all of it, and "
            f"{idle} waited; what is split are factors of unlike elastic stones, and Newton's method for "
            "elastic stones with 2000 contacts and more, or with solver.linear = 'krylov'",
        )
        return RanksTold(count=len(spent), peak_memory_mb=memory)
    work = {kind: _work([of_rank.get(kind, Spent()) for of_rank, _ in spent]) for kind in kinds}
    return RanksTold(count=len(spent), peak_memory_mb=memory, work=work)


def _work(spent: Sequence[Spent]) -> WorkTold:
    """One kind of work on all ranks."""
    return WorkTold(
        seconds=tuple(round(one.seconds, 4) for one in spent),
        wall=tuple(round(one.wall, 4) for one in spent),
        received=tuple(round(1e-6 * one.received, 3) for one in spent),
        times=tuple(one.times for one in spent),
    )


def versions() -> dict[str, str]:
    """Versions of this program and of the libraries that shape its numbers."""
    found = {"masonry_fem": __version__, "python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found

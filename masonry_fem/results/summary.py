"""Summary: what ``summary.json`` holds of a run, key by key; ``docs/results.md`` tells units and meanings.

    result.summary.certificate.natural_map
    print(result.summary)            # a short table

Keys that a run has nothing to say of are left out of the file, and None here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.ledger import Ledger
from masonry_fem.march.mechanism import Falling
from masonry_fem.march.witness import Written
from masonry_fem.output.stress_error import StressError
from masonry_fem.records.remark import Remark
from masonry_fem.records.told import Told

FloatArray = NDArray[np.float64]

Outcome = Literal["equilibrium", "finished", "no_convergence", "no_equilibrium", "interrupted", "failed"]


class Wrench(Told, frozen=True, kw_only=True):
    """Force, shape (d,) [N], and moment about the origin, shape (1 or 3,) [N m]."""

    force: FloatArray
    moment: FloatArray


class Certificate(Told, frozen=True, kw_only=True):
    """How exact the last state is, by measures that no solver has a say in.

    ``natural_map``, ``cone_violation``, ``block_balance``, ``global_balance`` and
    ``energy_balance`` are relative; ``max_penetration`` is in m, ``min_normal_reaction`` in N. With cohesion
    normal reaction and cone are those of contact, what the joint pulls taken off.
    """

    natural_map: float
    max_penetration: float
    min_normal_reaction: float
    cone_violation: float
    block_balance: float
    global_balance: float
    energy_balance: float
    written: Written | None = None


class Extreme(Told, frozen=True, kw_only=True):
    """A greatest value [Pa], and in which block."""

    value: float
    block: str


class BlockStress(Told, frozen=True, kw_only=True):
    """Mean stress of a block [Pa]: xx, yy, zz, xy, yz, xz, and what is made of it."""

    block: str
    von_mises: float
    principal: FloatArray
    stress: FloatArray


class Stress(Told, frozen=True, kw_only=True):
    """Greatest stresses [Pa], tension positive, and where.

    ``max_von_mises``, ``max_principal`` and ``min_principal`` are over the Gauss points,
    ``max_von_mises_nodal`` of the stress smoothed to the nodes, which pictures show; 5 % of the volume have
    more than ``p95_von_mises``. ``blocks`` are those of greatest mean von Mises stress; ``error`` is how
    wrong all this may be, estimated.
    """

    max_von_mises: Extreme
    max_von_mises_nodal: Extreme
    p95_von_mises: float
    max_principal: Extreme
    min_principal: Extreme
    blocks: tuple[BlockStress, ...]
    error: StressError | None = None


class Mover(Told, frozen=True, kw_only=True):
    """A block that moves, its greatest speed [m/s], and how."""

    block: str
    speed: float
    how: str


class Abrupt(Told, frozen=True, kw_only=True):
    """Steps in which joints gave way between two known states, and the times of the first and the last."""

    steps: int
    first: float
    last: float


class ScatterTold(Told, frozen=True, kw_only=True):
    """Seeds of the joints' random fields; least and greatest factor on the scene's values, by parameter."""

    seeds: tuple[int, ...]
    factors: dict[str, tuple[float, float]]


class SolverTold(Told, frozen=True, kw_only=True):
    """How the last step was solved."""

    method: str
    iterations: int
    linear_solves: int


class TimeError(Told, frozen=True, kw_only=True):
    """What steps of a finite length lost of the largest energy, and lost count of."""

    dissipated: float
    imbalance: float
    note: str | None = None


class ContactError(Told, frozen=True, kw_only=True):
    """Relative changes with other contact points; a ``note`` where there is nothing to compare.

    ``supports``, ``probes`` : greatest change of a support's force, of a probe's displacement.
    ``stress``, ``block_stress`` : of the stress in the mean over the volume, of the blocks' means.
    """

    points: int | None = None
    points_again: int | None = None
    outcome_again: str | None = None
    note: str | None = None
    supports: float | None = None
    probes: float | None = None
    stress: float | None = None
    block_stress: float | None = None
    seconds: float | None = None


class Errors(Told, frozen=True, kw_only=True):
    """What elements, contact points and steps leave open; what does not apply is None."""

    stress: float | None = None
    contact: ContactError | None = None
    time: TimeError | None = None


class StartTold(Told, frozen=True, kw_only=True):
    """How an equilibrium may come about, as ``Start`` explains it; ``message`` is its sentence."""

    reached: bool | None
    note: str | None = None
    message: str | None = None
    least_thrust: float | None = None
    joints: tuple[tuple[str, str], ...] | None = None
    mechanism: Falling | None = None


class LeftOpen(Told, frozen=True, kw_only=True):
    """Components of an interface's resultant that are not determined."""

    interface: str
    components: tuple[str, ...]


class Determinacy(Told, frozen=True, kw_only=True):
    """How much of the forces is a fact; the interfaces and supports of which something is not, by name.

    Where the last step was not solved ``reactions`` says so, and nothing else is known.
    """

    reactions: str
    error: float | None = None
    interfaces_determined: int | None = None
    interfaces_not_determined: int | None = None
    not_determined: tuple[LeftOpen, ...] | None = None
    supports_not_determined: dict[str, tuple[str, ...]] | None = None
    contacts_unique: int | None = None
    contacts_not_unique: int | None = None


class Furthest(Told, frozen=True, kw_only=True):
    """The greatest value of all interfaces [m], and of which."""

    value: float
    interface: str


class Joints(Told, frozen=True, kw_only=True):
    """How many joints are in which state, how many slide, and where the most open and the most slid are."""

    open: int
    closed: int
    middle_third: int
    cracked: int
    hinge: int
    held: int
    slide: int
    greatest_opening: Furthest
    greatest_sliding: Furthest


class LimitAnalysis(Told, frozen=True, kw_only=True, tag_field="schema", tag="limit/1"):
    """What limit analysis says of the blocks where they stand at the start (``docs/limit_analysis.md``).

    Ends of ``supports`` are None where a force has no bound, what is ``inexact`` where an end was not found.
    """

    title: str | None = None
    message: str
    dead: tuple[str, ...]
    growing: tuple[str, ...]
    blocks: int
    contacts: int
    admissible: bool
    share: float
    multiplier: float | None
    least_multiplier: float | None
    unlimited: bool
    mechanism: Falling | None
    supports: dict[str, dict[str, tuple[float | None, float | None]]]
    inexact: dict[str, dict[str, float | None]]
    certificate: dict[str, float | None]
    notes: tuple[str, ...]
    outside: tuple[Outside, ...] | None = None


class Outside(Told, frozen=True, kw_only=True):
    """Force of a simulation's support along an axis that lies outside its interval [N]."""

    support: str
    axis: str
    force: float


class Round(Told, frozen=True, kw_only=True):
    """One solution of a refinement.

    Attributes
    ----------
    round : From 1. unknowns : Of displacement and contact. meshes : Distinct ones, ``made`` of them new.
    error : Estimated, relative, in the energy norm. refined : Blocks that get finer elements next.
    seconds : CPU time [s].
    """

    round: int
    unknowns: int
    meshes: int
    made: int
    error: float
    refined: int
    seconds: float


class RefinementTold(Told, frozen=True, kw_only=True):
    """How the error of the stress was brought down, and whether to the target."""

    target: float
    reached: bool
    message: str
    rounds: tuple[Round, ...]


class Summary(Told, frozen=True, kw_only=True, tag_field="schema", tag="run/1"):
    """The end of a run."""

    title: str
    outcome: Outcome
    message: str
    time: float
    steps: int
    blocks: int
    shapes: int
    meshes: int
    interfaces: int
    contacts: int
    unknowns: int
    factorisations: int
    scatter: ScatterTold | None = None
    abrupt: Abrupt | None = None
    supports: dict[str, Wrench]
    applied: FloatArray
    certificate: Certificate
    stress: Stress | None = None
    probes: dict[str, FloatArray]
    status: dict[str, int]
    mechanism: Falling | None = None
    moving: tuple[Mover, ...]
    energy: Ledger
    solver: SolverTold
    seconds: dict[str, float]
    peak_memory_mb: float
    versions: dict[str, str]
    limit_analysis: LimitAnalysis | None = None
    start: StartTold | None = None
    errors: Errors
    determinacy: Determinacy | None = None
    joints: Joints | None = None
    refinement: RefinementTold | None = None
    remarks: tuple[Remark, ...] = ()

    def __repr__(self) -> str:
        """A short table."""
        rows = dict(self._rows())
        width = max(map(len, rows))
        return "\n".join(f"{name:<{width}}  {value}" for name, value in rows.items())

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "outcome", self.outcome
        yield "message", self.message
        yield "size", f"{self.blocks} blocks, {self.contacts} contacts, {self.unknowns} unknowns"
        yield "end", f"t = {self.time:.6g} after {self.steps} steps"
        certificate, written = self.certificate, self.certificate.written
        yield "balance", f"blocks {certificate.block_balance:.1e}, whole {certificate.global_balance:.1e}"
        overlap = certificate.max_penetration if written is None else written.overlap.value
        yield "overlap", f"{overlap:.2g} m"
        for name, wrench in self.supports.items():
            yield f"support {name}", f"({', '.join(f'{part:.5g}' for part in wrench.force)}) N"
        yield "CPU", f"{sum(self.seconds.values()):.2f} s, {self.peak_memory_mb:.0f} MB"

"""Bodies: what blocks owe the solver.

A *body group* is all blocks of one kind that share their operators (all rigid blocks; all
elastic blocks of one shape, material and clamping), held as arrays with the block first, so that
a step runs over groups, never over blocks. Every block moves as a rigid body plus an elastic
part, M-orthogonal to the rigid modes (split form):

    u = Φ U + u_el,        Φᵀ M Φ = I

The march knows groups only by the protocols of this file: what *moves*, what *is loaded*, what *is
shown*. Who reads a group asks for the one that it needs. What a group can do it says by ``prescribed``,
``turns`` and ``deforms``; nobody asks what it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # scenes that are only read need no SciPy
    from scipy import sparse

    from masonry_fem.solid.submerged import Submerged

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Opaque to the march: each group defines its own frozen state and force arrays.
State = Any


@dataclass(frozen=True, slots=True)
class Scheme:
    """Coefficients of one θ-step.

    Attributes
    ----------
    step : h [s]; any number > 0 in statics (it cancels).
    theta : ½ ≤ θ ≤ 1.
    inertia : 1 in dynamics, 0 in true statics (M_r = 0, M̂ = h²K, θ = 1, no damping); masses are multiplied
        by any other (``snapping``).
    """

    step: float
    theta: float = 0.5
    inertia: float = 1.0


@dataclass(frozen=True, slots=True)
class Sides:
    """The contact sides that touch the blocks of one group (k of them).

    Attributes
    ----------
    contact : Contact each side belongs to, shape (k,).
    side : 0 candidate, 1 antagonist, shape (k,).
    body : Block within the group, shape (k,).
    point : Material point in world coordinates of the reference configuration [m], (k, d).
    facet : Mesh facet that carries the point, −1 where the shape has no mesh, shape (k,).
    frame : Contact frames in the reference configuration, rows (n, t1[, t2]), (k, d, d).
    means : Of contacts that are means over a part of the interface, the weights of the mesh nodes, shape (k,
        nodes or more); rows of points are empty. None where all are points.
    """

    contact: IntArray
    side: IntArray
    body: IntArray
    point: FloatArray
    facet: IntArray
    frame: FloatArray
    means: sparse.csr_array | None = None


@dataclass(frozen=True, slots=True)
class Free:
    """One group's step without contact impulses, split in rigid and elastic part.

    Attributes
    ----------
    rigid_velocity : U_0 before the step, shape (b, m).
    rigid_impulse : f_r = Φᵀ h F_θ (with its damping terms), shape (b, m).
    rigid_mass : Diagonal of M_r, shape (b, m).
    elastic : Elastic free velocity u_el,free at the end of the step, the group's own array
        (nodal, shape (b, n)); None for groups without elastic part.
    origin : State from which U − (its velocity) leads on, in whose axes and arms the rigid part is
        written; None: the one at the start of the step, with velocity 0 in statics.
    guess : State that nonlinear blocks are linearised at; None: they are elastic from the start on.
    """

    rigid_velocity: FloatArray
    rigid_impulse: FloatArray
    rigid_mass: FloatArray
    elastic: FloatArray | None
    origin: State | None = None
    guess: State | None = None


@dataclass(frozen=True, slots=True)
class StepEnergy:
    """Energy of one step by block, each of shape (b,) [J].

    With u_θ = (1−θ)u + θu⁺ and Δq = h u_θ, a linear block's step gives exactly
    Δ(½uᵀMu) + Δ(½qᵀKq) = external + support + heat − damping − numerical − dissipation + (contact work).

    Attributes
    ----------
    external : F_θ · Δq.
    support : Work of clamped faces that move.
    damping : h u_θᵀ C u_θ.
    numerical : (θ − ½)(Δuᵀ M Δu + Δqᵀ K Δq); with inertia 0 the first term is absent.
        Of blocks that yield, the same of their stresses.
    dissipation : Lost as the material yields; 0 of blocks that do not.
    heat : Work of strains by temperature, −∫ σ : 1 Δe; 0 of blocks that have none.
    summed : Absolute values of all products that these terms and the stored energies are sums of, summed up:
        what they are of this size is known to rounding only, whatever cancels.
    """

    external: FloatArray
    support: FloatArray
    damping: FloatArray
    numerical: FloatArray
    dissipation: FloatArray | float = 0.0
    heat: FloatArray | float = 0.0
    summed: FloatArray | float = 0.0


@dataclass(frozen=True, slots=True)
class StressField:
    """Cauchy stress at the Gauss points of all blocks of a group, world axes.

    Attributes
    ----------
    gauss : Components (xx, yy, zz, xy, yz, xz) [Pa], shape (b, cells, points, 6); plane cases
        fill zz too.
    weight : Volume that each Gauss point stands for [m³; m² in 2D], shape (cells, points).
    nodal : The same smoothed to the nodes, shape (b, nodes, 6).
    """

    gauss: FloatArray
    weight: FloatArray
    nodal: FloatArray


@dataclass(frozen=True, slots=True)
class StressError:
    """Estimated error of the stress of all blocks of a group, as squares of energy norms.

    ∫ (Δσ : C⁻¹ : Δσ) is twice an energy: of the stress itself it is twice the strain energy.

    Attributes
    ----------
    squares : e² of each cell [J], shape (b, cells).
    norm : The same of the stress [J], shape (b,).
    volume : Of each cell [m³; m² in 2D], shape (cells,).
    """

    squares: FloatArray
    norm: FloatArray
    volume: FloatArray


@dataclass(frozen=True, slots=True)
class Actions:
    """What acts on the blocks of a group beside contacts, where they balance: m is 3 in 2D, 6 in 3D.

    Each is a force and a moment about the world origin, shape (b, m) [N, N m].

    Attributes
    ----------
    load : Mean of the loads over the step. clamp : What clamped faces give.
    held : Sizes of the forces that clamps give to nodes, summed up; unlike `clamp` it tells of forces that
        cancel, and is never less than a small share of what would hold heated blocks, shape (b,) [N].
    inertia : Change of momentum over the step and mass damping; 0 in statics.
    centre : Point of each block to take moments about, shape (b, d) [m].
    displaced : Moments of loads and clamps with the points of blocks that do not turn where these
        have gone to, shape (b, 1 or 3) [N m].
    summed : Absolute values of all products that the forces of clamps are sums of, summed up, (b,) [N]; or 0.
    """

    load: FloatArray
    clamp: FloatArray
    held: FloatArray
    inertia: FloatArray
    centre: FloatArray
    displaced: FloatArray
    summed: FloatArray | float = 0.0


class Attachment(Protocol):
    """A group seen through its contact sides (k of them)."""

    def displacements(self, state: State) -> FloatArray:
        """How far the material points have gone, all digits kept, shape (k, d) [m]."""
        ...

    def rotations(self, state: State) -> FloatArray:
        """How the blocks have turned since the reference configuration, shape (k, d, d)."""
        ...

    def rigid_map(self, state: State, points: FloatArray, frames: FloatArray) -> FloatArray:
        """Velocity, in the frames, of the block at ``points`` for unit U, shape (k, d, m); unsigned."""
        ...

    # A nodal field turns with its block. The frames of what follows are turned back by as much.

    def elastic_velocity(self, elastic: FloatArray, seen: FloatArray) -> FloatArray:
        """Velocity, in the frames, that a nodal field (b, n) has at the points, shape (k, d)."""
        ...

    def compliance(
        self, scheme: Scheme, seen: FloatArray, guess: State | None = None
    ) -> Sequence[tuple[IntArray, FloatArray]]:
        """W_el of each block that has sides: (side numbers (s,), matrix (s d, s d)); unsigned, [1/kg].

        ``guess`` is the state that nonlinear blocks are linearised at (the others ignore it); None: they are
        elastic from the start of the step on.
        """
        ...

    def kinds(
        self, scheme: Scheme, seen: FloatArray, guess: State | None = None
    ) -> Sequence[tuple[IntArray, FloatArray, FloatArray]]:
        """The same by kinds of n blocks with s sides each that share a matrix; unsigned, [1/kg].

        Side numbers (n, s), what turns velocities from the blocks' axes into the frames, shape (n, s, d, d),
        and the matrix in these axes, shape (s d, s d).
        """
        ...

    def unit_motions(self, scheme: Scheme, seen: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of blocks with K modes: velocities of unit motions, (k, d, K), unsigned; effective mass, (b, K)."""
        ...

    def spread(self, impulses: FloatArray, seen: FloatArray) -> FloatArray | None:
        """Nodal impulses Gᵀ p of signed side impulses (k, d) in the frames, shape (b, n); None if rigid."""
        ...


class Moves(Protocol):
    """What steps and contacts ask of b blocks of one kind; ``m`` rigid velocities each: 3 in 2D, 6 in 3D."""

    kind: str
    """Name of this kind of body, for reports: the blocks' fidelity, or ``support``."""
    blocks: IntArray
    """Block numbers in the assembly, shape (b,)."""
    mass: FloatArray
    """Masses [kg], shape (b,)."""
    prescribed: bool
    """Whether the motion is given, as that of supports: ``Free.rigid_velocity`` is U⁺, and not solved for."""
    turns: bool
    """Whether equations follow the blocks as these turn: frames, lever arms and loads are those of the place
    where a block is. Else they stay those of the reference, as small kinematics has it."""
    deforms: bool
    """Whether blocks have an elastic part: nodal velocities, a compliance at contacts, strains."""
    modal: bool
    """Whether they deform by few modes, by which contacts may see them instead of by their compliance."""
    nonlinear: bool
    """Whether ``free`` and the compliance depend on a guess of the step's end, so that a step takes rounds.
    Such groups are ``Nonlinear``, too."""
    factorisations: int
    """Matrices factorised so far: one for each scheme, whatever the number of blocks; 0 for rigid ones."""

    @property
    def unknowns(self) -> int:
        """Displacements of all blocks that a step solves for; 0 where the motion is prescribed."""
        ...

    def rest(self) -> State:
        """The state of reference: undeformed, in place, at rest."""
        ...

    def attach(self, sides: Sides) -> Attachment:
        """The group seen through contact sides."""
        ...

    def motion(self, state: State) -> tuple[FloatArray, FloatArray]:
        """The rigid motions x = R X + t nearest to what blocks have done, (b, d, d) and (b, d) [m]."""
        ...

    def free(
        self, state: State, at: State, force: FloatArray, scheme: Scheme, guess: State | None = None
    ) -> Free:
        """The step without contact.

        Nonlinear groups are linearised at ``guess``; None: they are elastic from ``state`` on. ``force`` is
        F_θ = (1−θ) F_i + θ F_{i+1}. Statics (inertia 0) balances at the end of the step: there blocks that
        turn take axes and arms of ``at``.
        """
        ...

    def generalised(self, state: State, force: FloatArray) -> FloatArray:
        """Work of a force array by unit rigid velocities U where blocks are as in ``state``, shape (b, m)."""
        ...

    def advance(
        self,
        state: State,
        free: Free,
        rigid_velocity: FloatArray,
        nodal: FloatArray | None,
        scheme: Scheme,
    ) -> State:
        """The state at the end of the step: U⁺ (b, m) and the nodal contact impulses Gᵀ p (b, n)."""
        ...

    def velocity_parts(self, state: State) -> tuple[FloatArray, FloatArray | None]:
        """The state's velocity as (U (b, m), u_el (b, n)); None where blocks do not deform."""
        ...

    def scale_velocity(self, state: State, factor: float) -> State:
        """The state with its velocities multiplied by ``factor`` (0: velocity zeroing)."""
        ...

    def going_on(self, state: State, end: State) -> State:
        """A step's start with velocities and material of its end; the motion of supports stays as given."""
        ...

    def set_down(self, state: State, rows: IntArray, rotation: FloatArray, shift: FloatArray) -> State:
        """Blocks ``rows`` (k,) at rest at x = R X + t without strain: R (k, d, d), t (k, d) [m].

        X are places in the reference. Supports and blocks with clamped faces stay as they are.
        """
        ...

    def with_velocity(self, state: State, body: int, velocity: FloatArray, spin: FloatArray) -> State:
        """One block set moving at ``velocity`` (d,) [m/s], turning at ``spin`` (1,) or (3,) [rad/s]."""
        ...


class Loaded(Protocol):
    """What loads do to b blocks, and what a step is judged by: balance and energy, from the two states alone.

    Forces are arrays of the group's own kind: nodal (b, n), or for rigid blocks the force and the dyadic of
    its lever arm (b, d + d²), world axes; they add and scale. Loads are dead, but for what
    ``following`` turns.
    """

    def following(self, force: FloatArray, state: State) -> FloatArray:
        """A force array of the reference with its directions turned as blocks that turn are in ``state``."""
        ...

    def acceleration_force(self, acceleration: FloatArray) -> FloatArray:
        """Body force of a uniform acceleration (d,) [m/s²]."""
        ...

    def traction_force(
        self, body: int, face: int, traction: FloatArray, factor: Submerged | None = None
    ) -> FloatArray:
        """Traction on a polytope face of one block.

        Parameters
        ----------
        body, face : The block and its face. traction : World axes, shape (d,) [Pa].
        factor : What it is multiplied by at each point of the reference; None: it is uniform.
        """
        ...

    def point_force(self, body: int, point: FloatArray | None, force: FloatArray) -> FloatArray:
        """Force (d,) [N] at a world point of the reference configuration (None: centroid)."""
        ...

    def resultant(self, force: FloatArray, state: State | None = None) -> FloatArray:
        """Force and moment about the world origin, shape (b, m) [N, N m].

        Of blocks that turn where they are in ``state``; None: in the reference.
        """
        ...

    def imbalance(
        self, state: State, at: State, after: State, force: FloatArray, impulse: FloatArray,
        nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step [N s], shape (b,).

        ``impulse`` is Bᵀ p (b, m), ``at`` the state in whose arms and axes it is written, as in ``free``:
        ``after`` itself where the step balances there. Not from the solver's words.
        """
        ...

    def clamp_reactions(
        self, state: State, after: State, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> dict[str, FloatArray]:
        """Force and moment about the origin that clamped faces give, by ``block/face`` name.

        From the momentum of the clamped nodes over the step, shape (m,) [N, N m]. Empty without clamps.
        """
        ...

    def actions(
        self, state: State, after: State, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> Actions:
        """What acts on the blocks in a step, where they balance.

        Blocks that turn balance where they are at the end of a step of statics and at the start of one of
        dynamics; others in the reference.
        """
        ...

    def step_energy(
        self, state: State, after: State, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> StepEnergy:
        """Work of F_θ and of moving clamps, what damping and the θ-scheme took (exact for linear blocks).

        ``nodal`` are the contact impulses Gᵀ p (b, n), which clamped nodes may bear, too.
        """
        ...

    def kinetic_energy(self, state: State) -> FloatArray:
        """½ uᵀ M u, shape (b,) [J]."""
        ...

    def strain_energy(self, state: State) -> FloatArray:
        """½ qᵀ K q, shape (b,) [J]."""
        ...


class Shown(Protocol):
    """Where b blocks are and what is in them, for pictures, tables and measures.

    Values at nodes come for all blocks at once, block after block, world axes: v is the number of all nodes
    (``by_block`` parts them). Nodes are those of the mesh, or the corners of blocks without one.
    """

    blocks: IntArray
    """Block numbers in the assembly, shape (b,)."""

    @property
    def cell(self) -> str | None:
        """Kind of the mesh's cells, a key of ``solid.mesh.FACET_OF``; None where ``cells`` are faces."""
        ...

    def cells(self, body: int) -> Sequence[Any] | IntArray:
        """Cells of one block over its nodes: (cells, k) node numbers, or the face loops of a solid."""
        ...

    def nodes(self, body: int) -> FloatArray:
        """Nodes of one block in the reference, shape (n, d) [m]."""
        ...

    def positions(self, state: State) -> FloatArray:
        """Where the nodes are, shape (v, d) [m]."""
        ...

    def displacements(self, state: State) -> FloatArray:
        """How far the nodes have gone, shape (v, d) [m]."""
        ...

    def velocities(self, state: State, place: State | None = None) -> FloatArray:
        """Velocity of the nodes, shape (v, d) [m/s]; of blocks that turn as if they were in ``place``."""
        ...

    def displacement(self, state: State, body: int, point: FloatArray) -> FloatArray:
        """Displacement of a material point given in world coordinates of reference, (d,) [m]."""
        ...

    def stress(self, state: State) -> StressField | None:
        """Stresses of all blocks of the group; None where it has none (rigid)."""
        ...

    def material_state(self, state: State) -> Mapping[str, FloatArray]:
        """What the material remembers, at Gauss points: by name, (b, cells, points); {} where nothing."""
        ...

    def stress_error(self, state: State) -> StressError | None:
        """How exact the stresses are, estimated; None where the group has none (rigid)."""
        ...


class Nonlinear(Protocol):
    """What a step asks besides of blocks that say they are ``nonlinear``."""

    @property
    def material_name(self) -> str:
        """What they are made of, for reports: the law by which they yield."""
        ...

    @property
    def softens(self) -> bool:
        """Whether their material loses strength as it is strained further."""
        ...

    def effort(self, after: State, scheme: Scheme) -> FloatArray:
        """Size of the impulses of the blocks' stresses on their nodes, shape (b,) [N s]."""
        ...

    def tangents(self, guess: State | None, scheme: Scheme) -> Mapping[int, object]:
        """What stands for the tangents of the blocks that are not elastic in a guess, by block.

        It is the same object as long as tangents stay, and empty where all blocks are elastic.
        """
        ...

    def keeping(self, guess: State, other: State | None) -> State:
        """A guess whose tangents are those of another state; the elastic ones where that is None."""
        ...

    def holding(self, guess: State) -> State:
        """A guess whose tangents are those of damage that stays, or elastic ones."""
        ...

    def promoted(self, state: State) -> FloatArray | None:
        """Time from which each block has not been elastic any more, ∞ while it is, shape (b,) [s].

        None where no block changes from elastic to what it is.
        """
        ...

    def lost_between(self, state: State, after: State) -> FloatArray:
        """Energy that the material loses on the way from one state to another, shape (b,) [J]."""
        ...

    def joined(self, state: State, after: State, lost: FloatArray | float) -> State:
        """The end of a step from ``state`` that was reached by several, which lost so much, (b,) [J]."""
        ...

    def between(self, state: State, start: State, end: State, share: float, scheme: Scheme) -> State:
        """The end of a step from ``state``, a ``share`` of the way from one guess of it to another."""
        ...


class BodyGroup(Moves, Loaded, Shown, Protocol):
    """All that a model's blocks owe: who adds a kind of body writes these."""

    def warmed(self, state: Any) -> FloatArray | None:
        """Strain by temperature of each block in a state, shape (b,); None where none can have any."""
        ...


def by_block(group: Shown, values: FloatArray) -> list[FloatArray]:
    """Values at all nodes of a group as one array a block.

    Parameters
    ----------
    group : The blocks.
    values : As its ``positions`` and fields come, shape (v, ...).
    """
    ends = np.cumsum([len(group.nodes(body)) for body in range(len(group.blocks))])
    return np.split(values, ends[:-1])


def nonlinear(group: Moves) -> Nonlinear:
    """A group that says it is nonlinear, with what it then has."""
    assert group.nonlinear
    return cast("Nonlinear", group)

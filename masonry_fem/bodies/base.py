"""Bodies: the protocols through which the program computes blocks, whatever they are made of.

A *body group* is all blocks of one kind that share their operators (all rigid blocks; all
elastic blocks of one shape, material and clamping). Its arrays have the block as first index, so that
a step loops over groups, never over blocks. Every block moves as a rigid body plus an elastic
part, M-orthogonal to the rigid modes (split form):

    u = Φ U + u_el,        Φᵀ M Φ = I

Here b is the number of blocks of a group, d = 2 or 3, m the number of rigid velocities U of a block (3 in
2D, 6 in 3D), n the number of its nodal degrees of freedom, and F_θ = (1−θ) F_i + θ F_{i+1} the load of a
step from i to i+1. Groups are used through the protocols of this file only, which say how blocks *move*
(``Moves``), how they are *loaded* (``Loaded``) and how they are *shown* (``Shown``). The flags
``prescribed``, ``turns`` and ``deforms`` say what a group can do; its type is never asked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol, cast, runtime_checkable

if TYPE_CHECKING:  # scenes that are only read need neither NumPy nor SciPy
    import numpy as np
    from numpy.typing import NDArray
    from scipy import sparse

    from masonry_fem.solid.submerged import Submerged

type FloatArray = NDArray[np.float64]
type IntArray = NDArray[np.int64]

# Opaque to the march: each group defines its own frozen state and force arrays.
State = Any


@dataclass(frozen=True, slots=True)
class Scheme:
    """Coefficients of one time step of the θ-method.

    Attributes
    ----------
    step : Length h of the step [s]; any number > 0 in statics (it cancels).
    theta : θ, ½ ≤ θ ≤ 1.
    inertia : Factor of all masses: 1 in dynamics, 0 in statics (M_r = 0, M̂ = h²K, θ = 1, no damping).
    """

    step: float
    theta: float = 0.5
    inertia: float = 1.0


@dataclass(frozen=True, slots=True)
class Sides:
    """The k contact sides on blocks of one group; each contact has two sides, candidate and antagonist.

    Attributes
    ----------
    contact : Contact to which each side belongs, shape (k,).
    side : 0 for the candidate, 1 for the antagonist, shape (k,).
    body : Number of the block within the group, shape (k,).
    point : Material point in world coordinates of the reference configuration [m], (k, d).
    facet : Mesh facet that carries the point, −1 where the shape has no mesh, shape (k,).
    frame : Contact frames in the reference configuration, rows (n, t1[, t2]), (k, d, d).
    means : Weights of the mesh nodes of contacts that are means over a part of the interface (placement
        ``weighted``), shape (k, nodes or more); other rows are empty. None: there are no such contacts.
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
    """A step of one group without contact impulses, split into a rigid and an elastic part.

    Attributes
    ----------
    rigid_velocity : U_0 before the step, shape (b, m).
    rigid_impulse : f_r = Φᵀ h F_θ, with the damping terms, shape (b, m).
    rigid_mass : Diagonal of M_r, shape (b, m).
    elastic : Elastic free velocity u_el,free of the nodes at the end of the step, shape (b, n); None for
        groups without elastic part.
    origin : State from which U − (its velocity) leads on, and in whose axes and lever arms the rigid part is
        written; None: the state at the start of the step, with velocity 0 in statics.
    guess : State at which nonlinear blocks are linearised; None: elastic from the start of the step.
    """

    rigid_velocity: FloatArray
    rigid_impulse: FloatArray
    rigid_mass: FloatArray
    elastic: FloatArray | None
    origin: State | None = None
    guess: State | None = None


@dataclass(frozen=True, slots=True)
class StepEnergy:
    """Energies of one step by block, each of shape (b,) [J].

    With u_θ = (1−θ)u + θu⁺ and Δq = h u_θ, a linear block's step gives exactly
    Δ(½uᵀMu) + Δ(½qᵀKq) = external + support + heat − damping − numerical − dissipation + (contact work).

    Attributes
    ----------
    external : F_θ · Δq.
    support : Work of moving clamped faces.
    damping : h u_θᵀ C u_θ.
    numerical : (θ − ½)(Δuᵀ M Δu + Δqᵀ K Δq), without the first term if inertia is 0; of blocks that yield
        the corresponding work of their stresses.
    dissipation : Energy lost as the material yields; 0 for linear blocks.
    heat : Work of the thermal strains e, −∫ σ : 1 Δe; 0 without temperatures.
    summed : Sum of the absolute values of all products in these terms and in the stored energies; times the
        machine precision it bounds their rounding error.
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
    """Estimated error Δσ of the stress of all blocks of a group, as squared energy norms ∫ Δσ : C⁻¹ : Δσ.

    The squared norm of the stress itself is twice the strain energy.

    Attributes
    ----------
    squares : Squared norm of the error in each cell [J], shape (b, cells).
    norm : Squared norm of the stress [J], shape (b,).
    volume : Volume of each cell [m³; m² in 2D], shape (cells,).
    """

    squares: FloatArray
    norm: FloatArray
    volume: FloatArray


@dataclass(frozen=True, slots=True)
class Actions:
    """What acts on the blocks of a group besides contacts, in the configuration in which they balance.

    Each is a force and a moment about the world origin, shape (b, m) [N, N m].

    Attributes
    ----------
    load : Mean of the loads over the step.
    clamp : Reactions of clamped faces.
    held : Sum of the magnitudes of the clamps' nodal forces, which unlike ``clamp`` do not cancel; at least a
        small share of what would hold heated blocks, shape (b,) [N].
    inertia : Change of momentum over the step and mass damping; 0 in statics.
    centre : Point of each block about which to take moments, shape (b, d) [m].
    displaced : Moments of loads and clamps at the displaced points of blocks that do not turn, shape
        (b, 1 or 3) [N m].
    summed : Sum of the absolute values of all products in the forces of clamps, shape (b,) [N]; or 0.
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
        """Displacements of the material points, exact also if they are small, shape (k, d) [m]."""
        ...

    def rotations(self, state: State) -> FloatArray:
        """Rotation matrices of the blocks since the reference configuration, shape (k, d, d)."""
        ...

    def rigid_map(self, state: State, points: FloatArray, frames: FloatArray) -> FloatArray:
        """Velocity in ``frames`` (k, d, d) of the blocks at ``points`` (k, d) for unit U, shape (k, d, m).

        It is unsigned, as all that follows: the sign of the side is not included.
        """
        ...

    # A nodal field turns with its block. The frames of what follows are turned back by as much.

    def elastic_velocity(self, elastic: FloatArray, seen: FloatArray) -> FloatArray:
        """Velocity, in the frames ``seen`` (k, d, d), of a nodal field (b, n) at the points, shape (k, d)."""
        ...

    def compliance(
        self, scheme: Scheme, seen: FloatArray, guess: State | None = None
    ) -> Sequence[tuple[IntArray, FloatArray]]:
        """W_el of each block that has s sides: side numbers (s,) and matrix (s d, s d), unsigned [1/kg].

        ``guess`` is the state at which nonlinear blocks are linearised (others ignore it); None: they are
        elastic from the start of the step.
        """
        ...

    def kinds(
        self, scheme: Scheme, seen: FloatArray, guess: State | None = None
    ) -> Sequence[tuple[IntArray, FloatArray, FloatArray]]:
        """W_el of kinds: n blocks with s sides each that share a matrix, unsigned [1/kg].

        For each kind the side numbers (n, s), the rotations of velocities from the blocks' axes into the
        frames (n, s, d, d), and the matrix in the blocks' axes (s d, s d).
        """
        ...

    def unit_motions(self, scheme: Scheme, seen: FloatArray) -> tuple[FloatArray, FloatArray]:
        """For blocks with K modes: velocities of unit motions, (k, d, K), and effective masses, (b, K)."""
        ...

    def spread(self, impulses: FloatArray, seen: FloatArray) -> FloatArray | None:
        """Nodal impulses Gᵀ p, shape (b, n), of signed side impulses (k, d) in the frames; None if rigid."""
        ...


class Making(Protocol):
    """Something costly that another process can make: it can be sent there."""

    @property
    def cost(self) -> float:
        """Of making it, in any unit that is the same for all."""
        ...

    @property
    def numbers(self) -> int:
        """How many there are in what is made."""
        ...

    def made(self, *, here: bool) -> Any:
        """Make it, in the process where it is used or, if not ``here``, as it can be sent there."""
        ...


@runtime_checkable
class Makes(Protocol):
    """An attachment of which something costly is made before its compliance is known."""

    def making(self, scheme: Scheme) -> Making | None:
        """What is to be made for a scheme; None: all is there, or costs too little to be sent about."""
        ...

    def take(self, scheme: Scheme, made: Any) -> None:
        """Have what was made for a scheme."""
        ...


class Moves(Protocol):
    """How the b blocks of a group move, with ``m`` rigid velocities each: 3 in 2D, 6 in 3D."""

    kind: str
    """Name of this kind of body, for messages: the blocks' fidelity, or ``support``."""
    blocks: IntArray
    """Block numbers in the assembly, shape (b,)."""
    mass: FloatArray
    """Masses [kg], shape (b,)."""
    prescribed: bool
    """Whether the motion is given, as for supports: ``Free.rigid_velocity`` is U at the end of the step."""
    turns: bool
    """Whether rotations are finite: frames, lever arms and loads follow the block. If not, they stay those of
    the reference (small displacements)."""
    deforms: bool
    """Whether blocks have an elastic part: nodal velocities, a compliance at contacts, strains."""
    modal: bool
    """Whether they deform in few modes, which contacts may use instead of a compliance."""
    nonlinear: bool
    """Whether ``free`` and the compliance depend on a guess of the end of the step, so that a step takes
    several iterations. Such groups are ``Nonlinear``, too."""
    factorisations: int
    """Matrices factorised so far: one for each scheme, whatever the number of blocks; 0 for rigid ones."""

    @property
    def unknowns(self) -> int:
        """Number of displacements for which a step solves, of all blocks; 0 if the motion is prescribed."""
        ...

    def rest(self) -> State:
        """The reference state: undeformed, in place, at rest."""
        ...

    def attach(self, sides: Sides) -> Attachment:
        """The group seen through contact sides."""
        ...

    def motion(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Rigid motions x = R X + t nearest to those of the blocks: R (b, d, d) and t (b, d) [m]."""
        ...

    def free(
        self, state: State, at: State, force: FloatArray, scheme: Scheme, guess: State | None = None
    ) -> Free:
        """The step from ``state`` without contact, under the load ``force``, F_θ.

        Nonlinear groups are linearised at ``guess``; None: they are elastic from ``state`` on. In statics
        (inertia 0) forces balance at the end of the step: blocks that turn then use the axes and lever
        arms of ``at``.
        """
        ...

    def generalised(self, state: State, force: FloatArray) -> FloatArray:
        """Power of a force array at unit rigid velocities, blocks placed as in ``state``, shape (b, m)."""
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
        """Velocities U (b, m) and u_el (b, n) of a state; u_el is None if blocks do not deform."""
        ...

    def scale_velocity(self, state: State, factor: float) -> State:
        """The state with its velocities multiplied by ``factor`` (0: velocity zeroing)."""
        ...

    def going_on(self, state: State, end: State) -> State:
        """The places of ``state`` with velocities and material of ``end``; supports move as prescribed."""
        ...

    def set_down(self, state: State, rows: IntArray, rotation: FloatArray, shift: FloatArray) -> State:
        """The state with blocks ``rows`` (k,) at rest and unstrained at x = R X + t.

        X are their points in the reference, R is ``rotation`` (k, d, d), t is ``shift`` (k, d) [m]. Supports
        and blocks with clamped faces stay as they are.
        """
        ...

    def with_velocity(self, state: State, body: int, velocity: FloatArray, spin: FloatArray) -> State:
        """The state with one block moving at ``velocity`` (d,) [m/s] and ``spin`` (1,) or (3,) [rad/s]."""
        ...


class Loaded(Protocol):
    """How the b blocks of a group are loaded, and the balance and energy of a step from its two states alone.

    Force arrays are the group's own, world axes, and can be added and scaled: nodal forces (b, n), or for
    rigid blocks the force and its dyadic product with the lever arm (b, d + d²). They keep their directions,
    except those that ``following`` turns.
    """

    def following(self, force: FloatArray, state: State) -> FloatArray:
        """A force array of the reference, turned with the blocks to ``state``."""
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
        body, face : Numbers of the block in the group and of its face.
        traction : Traction in world axes, shape (d,) [Pa].
        factor : Factor at each point of the reference; None: the traction is uniform.
        """
        ...

    def point_force(self, body: int, point: FloatArray | None, force: FloatArray) -> FloatArray:
        """Force (d,) [N] at a world point of the reference configuration (None: centroid)."""
        ...

    def resultant(self, force: FloatArray, state: State | None = None) -> FloatArray:
        """Force and moment of a force array about the world origin, shape (b, m) [N, N m].

        Blocks that turn are placed as in ``state``; None: as in the reference.
        """
        ...

    def imbalance(
        self, state: State, at: State, after: State, force: FloatArray, impulse: FloatArray,
        nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step [N s], shape (b,).

        ``impulse`` is Bᵀ p (b, m) of the contacts, ``at`` the state in whose axes and lever arms it is
        written, as in ``free``, and ``after`` the end of the step. It is computed from the states alone,
        independently of the solver.
        """
        ...

    def clamp_reactions(
        self, state: State, after: State, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> dict[str, FloatArray]:
        """Reactions of clamped faces by ``block/face`` name: force and moment about the origin.

        They follow from the momentum of the clamped nodes, shape (m,) [N, N m]; empty without clamps.
        """
        ...

    def actions(
        self, state: State, after: State, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> Actions:
        """What acts on the blocks in a step, in the configuration in which they balance.

        For blocks that turn this is the end of the step in statics, its start in dynamics; for others it is
        the reference.
        """
        ...

    def step_energy(
        self, state: State, after: State, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> StepEnergy:
        """Work of F_θ and of moving clamps, and losses by damping and by the θ-method.

        ``nodal`` are the contact impulses Gᵀ p (b, n), which may act on clamped nodes, too.
        """
        ...

    def kinetic_energy(self, state: State) -> FloatArray:
        """½ uᵀ M u, shape (b,) [J]."""
        ...

    def strain_energy(self, state: State) -> FloatArray:
        """½ qᵀ K q, shape (b,) [J]."""
        ...


class Shown(Protocol):
    """Places, displacements and stresses of the b blocks of a group, for pictures, tables and measures.

    Values at nodes come for all blocks at once, block after block, in world axes: v is the number of nodes of
    all blocks, and ``by_block`` splits the arrays. Nodes are those of the mesh, or the corners of blocks
    without one.
    """

    blocks: IntArray
    """Block numbers in the assembly, shape (b,)."""

    @property
    def cell(self) -> str | None:
        """Kind of the mesh's cells, a key of ``solid.mesh.FACET_OF``; None where ``cells`` are faces."""
        ...

    def cells(self, body: int) -> Sequence[Any] | IntArray:
        """Node numbers of the cells of one block, shape (cells, k), or of the faces of a solid."""
        ...

    def nodes(self, body: int) -> FloatArray:
        """Positions of the nodes of one block in the reference, shape (nodes, d) [m]."""
        ...

    @property
    def alike(self) -> IntArray:
        """A number for each block, shape (b,); blocks of one number have the same ``cells``."""
        ...

    @property
    def places(self) -> FloatArray:
        """Positions of the nodes in the reference, shape (v, d) [m]."""
        ...

    @property
    def first(self) -> IntArray:
        """First of the nodes of each block, and v, shape (b + 1,)."""
        ...

    def positions(self, state: State) -> FloatArray:
        """Positions of the nodes, shape (v, d) [m]."""
        ...

    def displacements(self, state: State) -> FloatArray:
        """Displacements of the nodes, shape (v, d) [m]."""
        ...

    def velocities(self, state: State, place: State | None = None) -> FloatArray:
        """Velocities of the nodes, shape (v, d) [m/s]; blocks that turn are placed as in ``place``."""
        ...

    def displacement(self, state: State, body: int, point: FloatArray) -> FloatArray:
        """Displacement (d,) [m] of the material point at ``point`` (d,) [m] in the reference."""
        ...

    def stress(self, state: State) -> StressField | None:
        """Stresses of all blocks of the group; None where it has none (rigid)."""
        ...

    def material_state(self, state: State) -> Mapping[str, FloatArray]:
        """Internal variables at the Gauss points by name, each (b, cells, points); {} if there are none."""
        ...

    def stress_error(self, state: State) -> StressError | None:
        """Estimated error of the stresses; None if the group has none (rigid)."""
        ...


class Nonlinear(Protocol):
    """What groups whose ``nonlinear`` is True offer besides, for Newton's iterations of a step."""

    @property
    def material_name(self) -> str:
        """Name of the law by which they yield, for messages."""
        ...

    @property
    def softens(self) -> bool:
        """Whether their material loses strength as it is strained further."""
        ...

    def effort(self, after: State, scheme: Scheme) -> FloatArray:
        """Size of the impulses of the blocks' stresses on their nodes, shape (b,) [N s]."""
        ...

    def tangents(self, guess: State | None, scheme: Scheme) -> Mapping[int, object]:
        """A token for the tangent of each block that is not elastic in a guess, by block.

        It is the same object as long as the tangent stays the same; empty if all blocks are elastic.
        """
        ...

    def keeping(self, guess: State, other: State | None) -> State:
        """The guess with the tangents of ``other``; None: the elastic ones."""
        ...

    def holding(self, guess: State) -> State:
        """The guess with the tangents at constant damage, or the elastic ones."""
        ...

    def promoted(self, state: State) -> FloatArray | None:
        """Time at which each block ceased to be elastic, ∞ while it is, shape (b,) [s].

        None if blocks are not elastic first (fidelity ``auto``).
        """
        ...

    def lost_between(self, state: State, after: State) -> FloatArray:
        """Energy dissipated by the material from one state to another, shape (b,) [J]."""
        ...

    def joined(self, state: State, after: State, lost: FloatArray | float) -> State:
        """The end of a step from ``state`` made in several substeps, which dissipated ``lost`` (b,) [J]."""
        ...

    def between(self, state: State, start: State, end: State, share: float, scheme: Scheme) -> State:
        """The end of a step from ``state``: ``share`` (0 to 1) of the way from ``start`` to ``end``."""
        ...


class BodyGroup(Moves, Loaded, Shown, Protocol):
    """All protocols that a kind of body implements, whoever adds one."""

    def warmed(self, state: Any) -> FloatArray | None:
        """Thermal strain of each block in a state, shape (b,); None if the scene has no temperatures."""
        ...


def by_block(group: Shown, values: FloatArray) -> list[FloatArray]:
    """Values at all nodes of a group, split into one array for each block.

    Parameters
    ----------
    group : The blocks.
    values : Values at all nodes, as ``positions`` returns them, shape (v, ...).
    """
    return [values[start:end] for start, end in pairwise(group.first.tolist())]


def nonlinear(group: Moves) -> Nonlinear:
    """The group as a ``Nonlinear`` one, whose flag ``nonlinear`` must be True."""
    assert group.nonlinear
    return cast("Nonlinear", group)

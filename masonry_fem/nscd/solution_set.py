"""SolutionSet: all impulses that solve a contact problem with the velocities of one solution.

    p_i in its face of the friction cone,    Bᵀ p and W_el p as they are

The face is the whole cone where the contact sticks, the ray against the sliding where it slides, the
tip where it is open. The set is convex. Blocks that touch at more points than balance
can tell apart make it more than one point. The velocities being given, so is cohesion: two solutions
differ by as much as their contact parts, which solve a dry problem (``cohesion.frozen``).

A convex set lies in the least faces of its innermost points, and spans, within these, all that the
equations leave free: so a null space *there* tells exactly what differs between two solutions, and
what does not. At any other solution it would call things determined that are not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.central_path import INSIDE, CentralPath
from masonry_fem.nscd.cohesion import frozen
from masonry_fem.nscd.faces import Faces
from masonry_fem.nscd.outcome import Solution
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied
from masonry_fem.nscd.scaling import contact_scale, free_speed
from masonry_fem.nscd.solvers.newton_system import NewtonSystem
from masonry_fem.nscd.threads import one_thread

FloatArray = NDArray[np.float64]

# Speeds below this share of those that matter are rest, where the solution is not worse than that.
AT_REST = 1e-9
EQUATIONS = 1e-13
STEPS = 80
# Of the mean impulse: what is nearer to an edge than this, in all solutions, lies on it.
EDGE = 1e-9
# Where the equations are missed by more than the first, edges are told by so many times the miss.
CLEAR, EDGES, REDUCTIONS = 1e-11, 1e2, 3
# What edges may cost in the equations: so many times the solution's error, at least the second.
MOVED, UNMOVED = 1e3, 1e-8
# A way that missed more than the first, even without edges that are forced, led nowhere: all faces are
# then taken whole, which calls too little determined, never too much. Up to the second, forced edges
# are looked for.
USABLE, HOPEFUL = 1e-6, 1e-3
# Null-space projection: weight of what is projected, of the equations, and how often.
LOOSE, REGULAR, PASSES = 1e-7, 1e-10, 6


@dataclass(frozen=True, slots=True)
class SolutionSet:
    """The set, by a point of its inside.

    Attributes
    ----------
    problem : The contact problem, made dry: impulses here are contact parts. scale : Scale of its
        contacts, shape (c,) [1/kg].
    allowed : Faces that the velocities leave.
    member : The solution that it was made from, put on its faces [N s], shape (c, d).
    balance : Bᵀp of all solutions, by the loads and the velocities, shape (b, m).
    inner : An innermost solution [N s], shape (c, d).
    faces : The least faces that hold every solution.
    miss : How exactly ``inner`` holds the equations, relative to their largest entry.
    cohesion : p_adh of all solutions, what contact parts exceed p by [N s], shape (c, d); None: none.
    """

    problem: ContactProblem
    scale: FloatArray
    allowed: Faces
    member: FloatArray
    balance: FloatArray
    inner: FloatArray
    faces: Faces
    miss: float
    cohesion: FloatArray | None = None

    def on_blocks(self, pressed: FloatArray) -> FloatArray:
        """The impulses p of contact parts p̃, shape (c, d)."""
        return pressed if self.cohesion is None else pressed - self.cohesion

    @property
    def size(self) -> float:
        """Mean size of the impulses that may be other than 0 [N s]; 1 where there are none."""
        closed = self.faces.closed
        return float(np.linalg.norm(self.member[closed], axis=1).mean()) if closed.any() else 1.0

    def differences(self, count: int, seed: int = 0) -> FloatArray:
        """Random differences of two solutions (up to their length), shape (count, c, d).

        Normal ones with independent entries, projected on the differences that there are. A linear
        function is the same for all solutions if it vanishes on them; if it is not, the chance that
        it nearly vanishes on one is as small as the value.
        """
        problem = self.problem
        w = self.scale[:, None]
        generator = np.random.default_rng(seed)
        drawn = generator.normal(size=(count, *self.member.shape)) / np.sqrt(w)
        spans = self.faces.spans()
        drawn = (spans @ drawn[..., None])[..., 0]
        if not self.faces.closed.any():
            return drawn
        with one_thread():
            system = NewtonSystem(problem, np.full(problem.count, float(self.scale.mean())), "direct")
            d = problem.dimension
            soft = LOOSE * self.scale[:, None, None]
            own = np.tile(np.eye(d), (problem.count, 1, 1)) * soft
            if not problem.rigid:
                own = own + 1e6 * self.scale[:, None, None] * (np.eye(d) - spans)
            identity = np.broadcast_to(np.eye(d), own.shape)
            mass = REGULAR * system.column**2 / (LOOSE * system.unit)
            factor = system.factor(
                own, identity, self.faces.closed, np.ones(problem.count, bool), mass, own_inverse=spans / soft
            )
            for k in range(count):
                for _ in range(PASSES):
                    step, _ = factor.solve(problem.elastic_velocity(drawn[k]), problem.body_impulse(drawn[k]))
                    drawn[k] += applied(spans, step)
        return drawn


def solution_set(problem: ContactProblem, solution: Solution, tolerance: float | None = None) -> SolutionSet:
    """All impulses that go with the velocities of a solution.

    Parameters
    ----------
    problem : The contact problem. solution : One solution of it, converged.
    tolerance : Share of the speeds that matter below which a contact is at rest; default: ten times
        the solution's error, at least 1e-9.

    Raises
    ------
    ProblemError : The solution is none.
    """
    if not solution.solved:
        raise ProblemError(
            f"the solution ended as '{solution.outcome.value}' at an error of {solution.quality.error:.1e}; "
            "what is determined can be told of a converged one only: solve to a tolerance that is reached"
        )
    if problem.cohesive:
        held = problem.contact_part(solution.impulse, solution.velocity) - solution.impulse
        dry = frozen(problem, solution.impulse, solution.velocity)
        pressed = replace(solution, impulse=solution.impulse + held)
        return replace(solution_set(dry, pressed, tolerance), cohesion=held)
    tolerance = max(10 * solution.quality.error, AT_REST) if tolerance is None else tolerance
    scale = contact_scale(problem)
    faces = _faces(problem, solution, scale, tolerance)
    member = faces.project(solution.impulse)[0]
    gained = problem.rigid_mass * (solution.rigid_velocity - problem.rigid_velocity)
    balance = gained - problem.rigid_impulse
    if not faces.closed.any() or not member.any():
        nothing = replace(faces, kind=np.zeros_like(faces.kind))
        return SolutionSet(problem, scale, faces, member, balance, member, nothing, 0.0)
    path, misses = _inside(problem, faces, member, balance, scale)
    clear = max(solution.quality.error, CLEAR)
    kept = max(MOVED * solution.quality.error, UNMOVED)
    for _ in range(REDUCTIONS):
        if misses <= clear or not misses <= HOPEFUL:
            break
        # too much is forced to the edges: without it the way is clear
        smaller = faces.shrunk(0.5 * (member + path.impulse), EDGES * misses * path.size)
        moved = smaller.project(member)[0]
        if path.equations(moved) > kept:
            break  # not forced, only small
        faces, member = smaller, moved
        path, misses = _inside(problem, faces, member, balance, scale)
    if not misses <= USABLE:
        return SolutionSet(problem, scale, faces, member, balance, member, faces, misses)
    # both are solutions, so half way between them is one, on no more edges than either
    inner = 0.5 * (member + path.impulse)
    # where it is not clear, rather too few edges: then something determined may not be told
    least = EDGE if misses > clear else max(EDGE, EDGES * misses)
    least_faces = faces.shrunk(inner, least * path.size)
    return SolutionSet(problem, scale, faces, member, balance, inner, least_faces, misses)


def _inside(
    problem: ContactProblem, faces: Faces, member: FloatArray, balance: FloatArray, scale: FloatArray
) -> tuple[CentralPath, float]:
    path = CentralPath(problem, faces, member, balance, np.ones(problem.count), scale)
    with one_thread():
        misses = path.follow(INSIDE, EQUATIONS, STEPS)
    return path, misses.equations


def _faces(problem: ContactProblem, solution: Solution, scale: FloatArray, tolerance: float) -> Faces:
    """Faces by the solution's velocities; rest is what hides in its error."""
    impulse = solution.impulse
    elastic = np.linalg.norm(problem.elastic_velocity(impulse), axis=1).max(initial=0.0)
    speed = elastic or free_speed(problem)
    hidden = scale * float(np.linalg.norm(impulse))
    threshold = tolerance * np.minimum(hidden, speed if speed > 0 else np.inf)
    velocity = problem.velocity(impulse, solution.rigid_velocity)
    return Faces.of_solution(impulse, velocity, problem.friction, threshold)

"""Solids: scenes at the extremes of material and geometry, each with a known answer.

    scene = column_of_contrast(1e8)
    result = solve_scene(scene)
    column_error(result)

A builder returns a scene and takes what makes it extreme; a function ``..._error`` of its result returns
the distance to the known answer, relative to it. Densities, lengths, stresses are in SI units.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import msgspec
import numpy as np

from masonry_fem.analyses.run import RunResult
from masonry_fem.scene.specs import (
    Analysis,
    Contact,
    Dynamics,
    Element,
    Equilibrium,
    Fidelity,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Override,
    Probe,
    Scene,
    Statics,
    Support,
    Table,
    Traction,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

G = 9.81
DENSITY = 2400.0
YOUNG = 10e9
P = 1e6  # pressure on patches [Pa]
ONE_STEP = Equilibrium(strategy="large_step", step=1.0, max_steps=20)
DYNAMICS = Dynamics(step=0.01, duration=0.05, theta=1.0)


def down(dimension: int) -> tuple[float, ...]:
    """Gravity."""
    return (0.0,) * (dimension - 1) + (-G,)


# --- columns: contrasts of stiffness and density between neighbours -----------------------------------


LINEAR = Contact(update="fixed")  # forces balance in the reference: closed forms hold at any strain


def column(
    young: Sequence[float | None],
    density: Sequence[float] = (DENSITY,),
    *,
    dimension: Literal[2, 3] = 2,
    edge: float = 1.0,
    analysis: Analysis | None = None,
    **keys: Any,
) -> Scene:
    """Cubes one on another under gravity, without friction and with ν = 0; rigid where Young is None.

    Joint k carries what lies above it, and the top sinks by Σ (W_above + W/2) edge / (E A)
    (``column_error``). The lists are repeated up to the longer one's length.
    """
    count = max(len(young), len(density))
    young = [young[k % len(young)] for k in range(count)]
    density = [density[k % len(density)] for k in range(count)]
    materials = {
        f"m{k}": Material(density=rho, young=e, poisson=0.0)
        for k, (rho, e) in enumerate(zip(density, young, strict=True), start=1)
    }
    size = (edge,) * dimension
    stack = StackStructure(name="stack", material="m1", size=size, count=count)
    middle = (0.5 * edge,) * (dimension - 1)
    return Scene(
        **{
            "title": "column of contrast",
            "dimension": dimension,
            "materials": materials,
            "structures": (stack,),
            "overrides": tuple(
                Override(
                    blocks=f"stack.b{k}",
                    material=f"m{k}",
                    fidelity="rigid" if young[k - 1] is None else "elastic",
                )
                for k in range(1, count + 1)
            ),
            "mesh": MeshSettings(divisions=(2,) * dimension),
            "joints": (Joint(friction=0.0),),
            "loads": Loads(gravity=down(dimension)),
            "analysis": Statics() if analysis is None else analysis,
            "probes": (Probe(name="top", block=f"stack.b{count}", point=(*middle, count * edge)),),
        }
        | keys
    )


def column_error(result: RunResult) -> float:
    """Worst of what joints carry and of the top's sinking, each relative to its own known value."""
    return max(carried_error(result), sinking_error(result))


def weights(result: RunResult) -> np.ndarray:
    """Weight of each free block, from the ground up [N], shape (b,)."""
    named: dict[int, float] = {}
    for group in result.built.model.groups:
        if not group.prescribed:
            named |= dict(zip(group.blocks.tolist(), (group.mass * G).tolist(), strict=True))
    return np.array([named[block] for block in sorted(named)])


def carried_error(result: RunResult) -> float:
    """Worst error of what a joint of a column carries, relative to the weight above that joint."""
    state, joint = result.march.state, result.built.model.contacts.interface
    force = np.bincount(joint, state.reaction[:, 0])
    # the lower block of a joint: soft columns sink so far that heights would not sort them
    lower = [min(interface.blocks) for interface in result.built.model.interfaces]
    ground = next(k for k, block in enumerate(result.built.model.assembly.blocks) if block.support)
    lower = [
        -1 if ground in interface.blocks else one
        for one, interface in zip(lower, result.built.model.interfaces, strict=True)
    ]
    above = np.cumsum(weights(result)[::-1])[::-1]
    return float(np.abs(force[np.argsort(lower)] / above - 1).max())


def sinking_error(result: RunResult) -> float:
    """Error of the top's settlement relative to it; 0 where all is rigid."""
    model = result.built.model
    own = weights(result)
    above = np.cumsum(own[::-1])[::-1] - 0.5 * own
    flexibility: dict[int, float] = {}
    for group in model.groups:
        if not group.prescribed:
            material = group.operators.material if group.deforms else None
            softness = 0.0 if material is None else 1.0 / material.young
            flexibility |= dict.fromkeys(group.blocks.tolist(), softness)
    size = float(np.ptp(model.assembly.solid(min(flexibility)).vertices[:, 0]))
    # L / (E A) with A = L in 2D (a metre deep) and L² in 3D
    d = model.assembly.dimension
    soft = np.array([flexibility[block] for block in sorted(flexibility)])
    exact = float(above @ soft) * size ** (2 - d)
    if exact == 0:
        return 0.0
    return abs(result.summary.probes["top"][d - 1] / -exact - 1)


# --- patches: two blocks under pressure -----------------------------------------------------------------


def patch(
    *,
    ratio: float = 1.0,
    divisions: tuple[tuple[int, ...], tuple[int, ...]] = ((2, 2), (3, 3)),
    elements: tuple[Element, Element] = ("Q1", "Q1"),
    size: tuple[float, ...] = (1.0, 1.0),
    poisson: float | tuple[float, float] = 0.2,
    young: float = YOUNG,
    placement: Literal["corners", "gauss", "nodes"] = "gauss",
    at: tuple[float, ...] | None = None,
    pressure: float = P,
    gap: float = 0.0,
    **keys: Any,
) -> Scene:
    """Two boxes one on another on rollers under a uniform pressure; the upper one's E is ``ratio`` times.

    Plane stress in 2D. σ = −p everywhere (``patch_error``), u_z = −p (1/E₁ + 1/E₂) size_z on top.
    """
    d = len(size)
    corner = (0.0,) * d if at is None else at
    both = (poisson, poisson) if isinstance(poisson, float) else poisson
    names = ("lower", "upper")
    boxes = tuple(
        BlockStructure(
            name=name,
            material=name,
            size=size,
            position=(*corner[:-1], corner[-1] + k * (size[-1] + gap)),
            mesh=MeshSettings(element=elements[k], divisions=divisions[k]),
        )
        for k, name in enumerate(names)
    )
    sides = [("left", "x"), ("front", "y")][: d - 1]
    supports = [Support(on="lower/bottom", components=("xyz"[d - 1],))]
    supports += [Support(on=f"{name}/{face}", components=(c,)) for name in names for face, c in sides]
    far = tuple(c + s for c, s in zip(corner, size, strict=True))
    stone = {"density": DENSITY}
    return Scene(
        **{
            "title": "patch",
            "dimension": d,
            "plane": "stress",
            "materials": {
                "lower": Material(young=young, poisson=both[0], **stone),
                "upper": Material(young=young * ratio, poisson=both[1], **stone),
            },
            "structures": boxes,
            "supports": tuple(supports),
            "joints": (Joint(friction=0.0, placement=placement),),
            "loads": Loads(tractions=(Traction(on="upper/top", vector=(0.0,) * (d - 1) + (-pressure,)),)),
            "probes": (Probe(name="corner", block="upper", point=(*far[:-1], far[-1] + size[-1] + gap)),),
            "analysis": Statics(),
        }
        | keys
    )


def stress_errors(result: RunResult, pressure: float = P) -> dict[str, float]:
    """Largest |σ + p e eᵀ| / p over the Gauss points of each elastic block; e is upright."""
    d = result.built.model.assembly.dimension
    e = np.eye(3)[d - 1]
    exact = -pressure * np.outer(e, e)[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    worst: dict[str, float] = {}
    for group, state in zip(result.built.model.groups, result.march.state.bodies, strict=True):
        field = group.stress(state)
        if field is not None:
            error = np.abs(field.gauss - exact).max(axis=(1, 2, 3)) / pressure
            worst |= dict(zip(group.names, error.tolist(), strict=True))
    return worst


def patch_error(result: RunResult, pressure: float = P) -> float:
    """The worst of the two blocks."""
    return max(stress_errors(result, pressure).values())


# --- walls: bricks of two kinds, course by course -------------------------------------------------------


def wall(
    *,
    ratio: float = 1.0,
    density_ratio: float = 1.0,
    alternate: Literal["courses", "columns", "rigid courses"] = "courses",
    scale: float = 1.0,
    at: tuple[float, float] = (0.0, 0.0),
    young: float = YOUNG,
    fidelity: Fidelity = "elastic",
    friction: float = 0.6,
    **keys: Any,
) -> Scene:
    """Running-bond wall, 2 bricks by 4 courses, mirror-symmetric but for half bricks, under gravity.

    Every other course, or every other brick of a course, has its E and ρ multiplied, or is rigid. The ground
    carries the weight and no horizontal force (``wall_error``).
    """
    stone = {"poisson": 0.2}
    bricks = WallStructure(
        name="wall", material="one", brick=(0.5 * scale, 0.25 * scale), columns=2, courses=4, position=at
    )
    other = {"courses": ("wall.c2.*", "wall.c4.*"), "columns": ("wall.*.b2",)}
    chosen = other.get(alternate, other["courses"])
    given = {"fidelity": "rigid"} if alternate == "rigid courses" else {"material": "two"}
    return Scene(
        **{
            "title": "wall of contrast",
            "dimension": 2,
            "fidelity": fidelity,
            "materials": {
                "one": Material(density=DENSITY, young=young, **stone),
                "two": Material(density=DENSITY * density_ratio, young=young * ratio, **stone),
            },
            "structures": (bricks,),
            "overrides": tuple(Override(blocks=blocks, **given) for blocks in chosen),
            "mesh": MeshSettings(divisions=(4, 2)),
            "joints": (Joint(friction=friction),),
            "loads": Loads(gravity=down(2)),
            "analysis": Statics(),
        }
        | keys
    )


def wall_error(result: RunResult) -> float:
    """What the ground carries against the weight, both components, relative to the weight."""
    force = np.sum([support.force for support in result.summary.supports.values()], axis=0)
    exact = -np.array(down(2)) / G * weights(result).sum()
    return float(np.linalg.norm(force - exact) / np.linalg.norm(exact))


# --- near-incompressible and auxetic stones --------------------------------------------------------------


def confined(
    poisson: float, *, element: Element = "Q1", dimension: Literal[2, 3] = 2, divisions: int = 2, **keys: Any
) -> Scene:
    """A cube between rigid rollers under a uniform pressure (plane strain): strain is uniaxial.

    Its top sinks by p / M, M = E (1 − ν) / ((1 + ν)(1 − 2ν)) (``confined_error``): nothing locks.
    """
    d = dimension
    faces = [("left", "x"), ("right", "x"), ("front", "y"), ("back", "y")][: 2 * (d - 1)]
    supports = [Support(on="cube/bottom", components=("xyz"[d - 1],))]
    supports += [Support(on=f"cube/{face}", components=(c,)) for face, c in faces]
    return Scene(
        **{
            "title": "confined cube",
            "dimension": d,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=poisson)},
            "structures": (BlockStructure(name="cube", material="stone", size=(1.0,) * d),),
            "mesh": MeshSettings(element=element, divisions=(divisions,) * d),
            "supports": tuple(supports),
            "loads": Loads(tractions=(Traction(on="cube/top", vector=(0.0,) * (d - 1) + (-P,)),)),
            "probes": (Probe(name="top", block="cube", point=(0.5,) * (d - 1) + (1.0,)),),
        }
        | keys
    )


def confined_error(result: RunResult) -> float:
    """Of the top's displacement, relative to it."""
    group = next(group for group in result.built.model.groups if not group.prescribed)
    nu, young = group.operators.material.poisson, group.operators.material.young
    modulus = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    return abs(result.summary.probes["top"][-1] / (-P / modulus) - 1)


def cantilever(
    poisson: float, *, element: Element = "Q1", divisions: tuple[int, int] = (40, 4), **keys: Any
) -> Scene:
    """A beam of 10 × 1 m in plane strain, held at its left end, sheared at its right one.

    The tip sinks by F L³ / 3 E' I + 1.2 F L / G A, E' = E / (1 − ν²), to the clamp's effect of some
    tenths of a percent (``cantilever_error``). Linear elements stiffen as ν → 1/2: they lock.
    """
    return Scene(
        **{
            "title": "cantilever",
            "dimension": 2,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=poisson)},
            "structures": (BlockStructure(name="beam", material="stone", size=(10.0, 1.0)),),
            "mesh": MeshSettings(element=element, divisions=divisions),
            "supports": (Support(on="beam/left"),),
            "loads": Loads(tractions=(Traction(on="beam/right", vector=(0.0, -1e4)),)),
            "probes": (Probe(name="tip", block="beam", point=(10.0, 0.5)),),
        }
        | keys
    )


def cantilever_error(result: RunResult) -> float:
    """Deflection of the tip over Timoshenko's, minus 1: below 0 the mesh is too stiff."""
    group = next(group for group in result.built.model.groups if not group.prescribed)
    nu, young = group.operators.material.poisson, group.operators.material.young
    shear = young / (2 * (1 + nu))
    exact = 1e4 * (1e3 / (3 * young / (1 - nu**2) / 12) + 1.2 * 10 / shear)
    return float(-result.summary.probes["tip"][1] / exact - 1)


# --- sizes and places ------------------------------------------------------------------------------------


def arch(
    *,
    radius: float = 1.0,
    thickness: float = 0.2,
    voussoirs: int = 11,
    fidelity: Fidelity = "elastic",
    stiffness: float | None = None,
    at: tuple[float, float] = (0.0, 0.0),
    friction: float = 0.6,
    **keys: Any,
) -> Scene:
    """Semicircular arch, all its lengths by ``radius`` [m]; E/(ρ g R) is kept where ``stiffness`` gives it.

    Thrust over γ R² is within an interval that depends on thickness and voussoirs (A3.3), and the same for
    all radii (``thrust``).
    """
    young = YOUNG if stiffness is None else stiffness * DENSITY * G * radius
    return Scene(
        **{
            "title": "arch",
            "dimension": 2,
            "fidelity": fidelity,
            "materials": {"stone": Material(density=DENSITY, young=young, poisson=0.2)},
            "structures": (
                ArchStructure(
                    name="arch",
                    material="stone",
                    radius=radius,
                    thickness=thickness * radius,
                    voussoirs=voussoirs,
                    centre=at,
                ),
            ),
            "mesh": MeshSettings(divisions=(2, 2)),
            "joints": (Joint(friction=friction),),
            "loads": Loads(gravity=down(2)),
            "analysis": Statics(),
        }
        | keys
    )


def thrust(result: RunResult, radius: float = 1.0) -> float:
    """Horizontal force of the left springing over γ R²."""
    force = result.summary.supports["arch.springing_left"].force
    return float(force[0]) / (DENSITY * G * radius**2)


def arch_error(result: RunResult) -> float:
    """What the springings carry against the weight, and the difference of the thrusts, over the weight."""
    return wall_error(result)


# --- wedges and slivers ------------------------------------------------------------------------------------


def keystone(
    half_angle: float,
    *,
    friction: float = 0.0,
    fidelity: Fidelity = "rigid",
    radius: float = 2.0,
    thickness: float = 0.5,
    **keys: Any,
) -> Scene:
    """One voussoir between two springings, ``half_angle`` [deg] either side of the vertical.

    Without friction N = W / (2 sin a), H = W / (2 tan a) (``keystone_error``).
    """
    return Scene(
        **{
            "title": "keystone",
            "dimension": 2,
            "fidelity": fidelity,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=0.2)},
            "structures": (
                ArchStructure(
                    name="key",
                    material="stone",
                    radius=radius,
                    thickness=thickness,
                    voussoirs=1,
                    embrace=2 * half_angle,
                ),
            ),
            "mesh": MeshSettings(divisions=(2, 2)),
            "joints": (Joint(friction=friction),),
            "loads": Loads(gravity=down(2)),
            "analysis": Statics(),
        }
        | keys
    )


def keystone_error(result: RunResult, half_angle: float) -> float:
    """Of the thrust and of the normal force, without friction; the worse, relative."""
    a = np.radians(half_angle)
    force = np.array(result.summary.supports["key.springing_left"].force) / weights(result)[0]
    thrust, normal = abs(force[0]) * 2 * np.tan(a) - 1, np.linalg.norm(force) * 2 * np.sin(a) - 1
    return float(max(abs(thrust), abs(normal)))


def slender(
    aspect: float,
    *,
    lying: bool = True,
    fidelity: Fidelity = "elastic",
    count: int = 2,
    divisions: tuple[int, int] = (4, 2),
    **keys: Any,
) -> Scene:
    """Plates (or needles) ``aspect`` times as long as thick on a ground; what lies above presses each joint.

    The known answer is ``carried_error``'s: the weight of what lies above.
    """
    size = (1.0, 1.0 / aspect) if lying else (1.0 / aspect, 1.0)
    return Scene(
        **{
            "title": "slender",
            "dimension": 2,
            "fidelity": fidelity,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=0.0)},
            "structures": (StackStructure(name="stack", material="stone", size=size, count=count),),
            "mesh": MeshSettings(divisions=divisions),
            "joints": (Joint(friction=0.0),),
            "loads": Loads(gravity=down(2)),
            "analysis": Statics(),
        }
        | keys
    )


def sizes_apart(
    ratio: float, *, fidelity: Fidelity = "rigid", dimension: Literal[2, 3] = 2, **keys: Any
) -> Scene:
    """A cube on one ``ratio`` times its edge, in the middle of it, on a ground.

    The joints carry the weights above them (``carried_error``).
    """
    d = dimension
    small = BlockStructure(
        name="small",
        material="stone",
        size=(1.0,) * d,
        position=(*((0.5 * (ratio - 1),) * (d - 1)), ratio),
    )
    large = BlockStructure(name="large", material="stone", size=(ratio,) * d, position=(0.0,) * d)
    floor = BlockStructure(
        name="floor",
        material="stone",
        size=(*((2 * ratio,) * (d - 1)), 0.5 * ratio),
        position=(*((-0.5 * ratio,) * (d - 1)), -0.5 * ratio),
        support=True,
    )
    return Scene(
        **{
            "title": "sizes apart",
            "dimension": d,
            "fidelity": fidelity,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=0.0)},
            "structures": (large, small, floor),
            "mesh": MeshSettings(divisions=(2,) * d),
            "joints": (Joint(friction=0.0),),
            "loads": Loads(gravity=down(d)),
            "analysis": Statics(),
        }
        | keys
    )


def ledges(width: float, *, fidelity: Fidelity = "rigid", dimension: Literal[2, 3] = 2, **keys: Any) -> Scene:
    """A lintel of 1 × 0.2 m whose ends rest on two fixed blocks by ``width`` only.

    Each carries half of its weight (``ledges_error``), however narrow it is. What is narrower than 1e-4 of
    the smaller face (or in 3D that part of its area) is a sliver, and no contact.
    """
    d = dimension

    def box(name: str, size: tuple[float, float], x: float, z: float, support: bool) -> BlockStructure:
        deep = (0.2,) * (d - 2)
        return BlockStructure(
            name=name,
            material="stone",
            size=(size[0], *deep, size[1]),
            position=(x, *((0.0,) * (d - 2)), z),
            support=support,
        )

    return Scene(
        **{
            "title": "lintel on ledges",
            "dimension": d,
            "fidelity": fidelity,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=0.0)},
            "structures": (
                box("left", (0.2, 0.2), -0.2 + width, -0.2, True),
                box("right", (0.2, 0.2), 1.0 - width, -0.2, True),
                box("lintel", (1.0, 0.2), 0.0, 0.0, False),
            ),
            "mesh": MeshSettings(divisions=(10, *((2,) * (d - 1)))),
            "joints": (Joint(friction=0.0),),
            "loads": Loads(gravity=down(d)),
            "analysis": Statics(),
        }
        | keys
    )


def ledges_error(result: RunResult) -> float:
    """Of what each ledge carries, relative to half of the weight."""
    half = 0.5 * float(weights(result)[0])
    forces = [result.summary.supports[name].force[-1] for name in ("left", "right")]
    return float(np.abs(np.array(forces) / half - 1).max())


# --- gaps and overlaps -------------------------------------------------------------------------------------


def lifted(
    gap: float,
    *,
    fidelity: Fidelity = "rigid",
    edge: float = 1.0,
    reach: float | None = None,
    expulsion: float = 0.0,
    analysis: Analysis | None = None,
    **keys: Any,
) -> Scene:
    """A cube ``gap`` above a floor, or as deep in it; it comes down by the gap and rests (``rest_error``)."""
    cube = BlockStructure(name="cube", material="stone", size=(edge, edge), position=(0.0, gap))
    floor = BlockStructure(
        name="floor", material="stone", size=(3 * edge, edge), position=(-edge, -edge), support=True
    )
    return Scene(
        **{
            "title": "lifted cube",
            "dimension": 2,
            "fidelity": fidelity,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=0.0)},
            "structures": (cube, floor),
            "mesh": MeshSettings(divisions=(2, 2)),
            "joints": (Joint(friction=0.6),),
            "loads": Loads(gravity=down(2)),
            "contact": Contact(reach=reach, expulsion=expulsion),
            "analysis": Statics() if analysis is None else analysis,
            "probes": (Probe(name="foot", block="cube", point=(0.5 * edge, gap)),),
        }
        | keys
    )


def rest_error(result: RunResult, gap: float) -> float:
    """Where the foot comes to rest against −gap (0 for an overlap, which is held) [m]."""
    return abs(result.summary.probes["foot"][1] + max(gap, 0.0))


def jammed(
    overlap: float,
    *,
    expulsion: float,
    fidelity: Fidelity = "rigid",
    analysis: Analysis | None = None,
    **keys: Any,
) -> Scene:
    """A cube on a floor between two fixed ones that overlap it on both sides.

    There is no way out: rigid, it stays (``probes["middle"]`` is 0); elastic, it is squeezed, and the sides
    press with E · overlap at most (``jam_pressure``).
    """

    def cube(name: str, x: float, support: bool = False) -> BlockStructure:
        return BlockStructure(
            name=name, material="stone", size=(1.0, 1.0), position=(x, 0.0), support=support
        )

    floor = BlockStructure(
        name="floor", material="stone", size=(5.0, 1.0), position=(-2.0, -1.0), support=True
    )
    return Scene(
        **{
            "title": "jammed cube",
            "dimension": 2,
            "fidelity": fidelity,
            "materials": {"stone": Material(density=DENSITY, young=YOUNG, poisson=0.0)},
            "structures": (
                cube("left", overlap - 1.0, True),
                cube("cube", 0.0),
                cube("right", 1.0 - overlap, True),
                floor,
            ),
            "mesh": MeshSettings(divisions=(2, 2)),
            "joints": (Joint(friction=0.6),),
            "loads": Loads(gravity=down(2)),
            "contact": Contact(expulsion=expulsion),
            "analysis": Dynamics(step=0.005, duration=0.2, theta=1.0) if analysis is None else analysis,
            "probes": (Probe(name="middle", block="cube", point=(0.5, 0.5)),),
        }
        | keys
    )


def crushed(
    closing: float, *, fidelity: Fidelity = "rigid", analysis: Analysis | None = None, **keys: Any
) -> Scene:
    """A cube on a floor between two others, of which the right one closes in by ``closing`` [m].

    Rigid blocks have no motion then, and a run that does not bear it says so; an elastic one is strained by
    ``closing`` (``jam_pressure``), and its middle goes half of that way.
    """
    scene = jammed(0.0, expulsion=0.0, fidelity=fidelity)
    push = Motion(displacement=(-closing, 0.0), time=Table(points=((0.0, 0.0), (1.0, 1.0))))
    march = Dynamics(step=0.05, duration=1.0, theta=1.0) if analysis is None else analysis
    return msgspec.structs.replace(
        scene, title="crushed cube", supports=(Support(on="right", motion=push),), analysis=march, **keys
    )


def jam_pressure(result: RunResult) -> float:
    """Mean pressure of the right side on the cube, over E [1]: the cube's strain, 2 · overlap of 1 m."""
    return -float(result.summary.supports["right"].force[0]) / YOUNG

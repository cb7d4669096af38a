"""Recipes of the trial set: scenes, and which of their contact problems are kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, Literal

import msgspec
import numpy as np

from benchmarks.cases import G
from demos import cyclic_joint, dome_on_piers
from masonry_fem import load
from masonry_fem.nscd import ContactProblem
from masonry_fem.scene import loads
from masonry_fem.scene import specs as s
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.dome import DomeStructure
from masonry_fem.structures.rubble import RubbleStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.extremes.scenes import LARGE_STEP, block_on_slope
from tests.extremes.solids import patch
from tests.nscd.families import elastic, low_rank
from tests.nscd.masses import rigid_mass
from tests.nscd.plane import plane_wall, soft
from tests.nscd.walls import rigid_wall
from tests.validation.test_a3_arches import SPREAD
from tests.validation.test_verdicts import PARTED

Size = Literal["tiny", "default"]
STATICS = s.Statics()
GROWING = s.Statics(load_steps=20)
AT_ONCE = s.Table(points=((0.0, 1.0),))  # while all else grows
DYNAMICS = s.Dynamics(step=5e-3, duration=1.0)
STONE = {"stone": s.Material(density=2400.0, young=10e9, poisson=0.2)}
END = 10**6  # more calls of the solver than a scene takes
TOLERANCE, EXACT = 1e-8, 1e-10  # of the set, and what runs aim at without ``solver.tolerance``
NEXT_TO = 1e-3  # of the load of limit analysis: so near to it stiffness decides


@dataclass(frozen=True, slots=True)
class Recipe:
    """How a problem is made.

    Attributes
    ----------
    family : What it is like. name : What tells it from the others of its family.
    scene : Without its horizontal load; or a problem that is none of a scene's, or what makes it.
    share : Of the load of limit analysis; None: it has no such load.
    call : Which call of the contact solver is kept, from 1; the last one where there are fewer.
    falls : Whether it falls, where that is known but not by limit analysis of its first geometry.
    joints : How many joints its mechanism has, where it has one.
    tolerance : What it is solved to.
    """

    family: str
    name: str
    scene: s.Scene | ContactProblem | Callable[[], ContactProblem]
    share: float | None
    call: int = 1
    falls: bool | None = None
    joints: int | None = None
    tolerance: float = TOLERANCE

    @property
    def path(self) -> str:
        """Name of its file."""
        return f"{self.family} {self.name}".replace(" ", "_").replace("/", "_") + ".npz"


# --- what the problems are of -----------------------------------------------------------------


def wall(columns: int, courses: int, dimension: int = 3) -> s.Structure:
    brick = (0.4, 0.2, 0.2) if dimension == 3 else (0.4, 0.2)
    return WallStructure(name="wall", material="stone", brick=brick, columns=columns, courses=courses)


def arch(voussoirs: int, thickness: float = 0.2) -> s.Structure:
    return ArchStructure(
        name="arch", material="stone", radius=1.0, thickness=thickness, voussoirs=voussoirs, depth=0.3
    )


def dome(rings: int, slices: int, thickness: float, **more: Any) -> s.Structure:
    return DomeStructure(
        name="dome", material="stone", radius=5.0, thickness=thickness, rings=rings, slices=slices, **more
    )


def rubble(stones: int, seed: int, dimension: int = 3) -> s.Structure:
    size = (1.2, 0.4, 1.0) if dimension == 3 else (2.0, 1.2)
    return RubbleStructure(name="rubble", material="stone", size=size, stones=stones, seed=seed)


def tower(courses: int, push: float) -> s.Scene:
    """A shaft of elastic ashlars, bonded at its corners, pushed by an acceleration [m/s²]."""
    full, inset = (1.0,) * 3, (-0.5, 1.0, 1.0, -0.5)
    side, brick = 4.8, (1.6, 0.8, 0.8)
    walls = (
        WallStructure(
            name=name, material="stone", brick=brick, pattern=pattern, courses=courses, ground=False,
            position=(x, y, 0.0), rotation=90.0 * quarter,
        )
        for quarter, (name, pattern, x, y) in enumerate((
            ("front", (full, inset), 0.0, 0.0), ("right", (inset, full), side, 0.0),
            ("back", (full, inset), side, side), ("left", (inset, full), 0.0, side),
        ))
    )  # fmt: skip
    ground = BlockStructure(
        name="ground", material="stone", size=(side + 2, side + 2, 0.8), position=(-1.0, -1.0, -0.8),
        support=True,
    )  # fmt: skip
    loads = s.Loads(gravity=(0.0, 0.0, -G), accelerations=(s.Acceleration(vector=(push, 0.0, 0.0)),))
    given = scene(ground, 0.6, "elastic", mesh=s.MeshSettings(element="Q1", divisions=(2, 1, 1)), loads=loads)
    return msgspec.structs.replace(given, structures=(*walls, ground))


def gaping_wall(columns: int, courses: int, gap: float) -> s.Scene:
    """A running-bond wall of elastic bricks, each shorter by a gap [m], so that head joints are open."""
    length, *rest = 0.4, 0.2, 0.2
    rows = ([1.0] * columns, [0.5, *[1.0] * (columns - 1), 0.5])
    bricks = tuple(
        BlockStructure(
            name=f"c{course}b{number}", material="stone", size=(own * length - gap, *rest),
            position=(sum(row[:number]) * length, 0.0, course * rest[-1]),
            mesh=s.MeshSettings(element="Q1", divisions=(int(4 * own), 2, 2)),
        )
        for course in range(courses)
        for row in (rows[course % 2],)
        for number, own in enumerate(row)
    )  # fmt: skip
    floor = BlockStructure(
        name="floor", material="stone", size=(columns * length + 1.0, 2.0, 0.1),
        position=(-0.5, -0.5, -0.1), support=True, fidelity="rigid",
    )  # fmt: skip
    joints = (s.Joint(friction=0.6, placement="nodes"),)
    return msgspec.structs.replace(scene(floor, 0.6, "elastic", joints=joints), structures=(floor, *bricks))


def spread_arch(friction: Any, share: float) -> s.Scene:
    """An arch whose springings move apart in twenty steps, to a share of what it falls at."""
    slowly = s.Table(points=((0.0, 0.0), (0.5, share - 0.1), (1.0, share)))
    supports = tuple(
        s.Support(
            on=f"arch.springing_{side}",
            motion=s.Motion(displacement=(way * SPREAD[0.2] / 2, 0.0), time=slowly),
        )
        for side, way in (("left", -1.0), ("right", 1.0))
    )
    loads = s.Loads(gravity=(0.0, -G), gravity_time=AT_ONCE)
    return scene(arch(20), friction, dimension=2, supports=supports, loads=loads, analysis=GROWING)


def sunk_arch(voussoirs: int, amount: float) -> s.Scene:
    """An arch of very stiff stones, one springing of which sinks by an amount [m] in one step."""
    sinks = s.Support(on="arch.springing_right", motion=s.Motion(displacement=(0.0, -amount)))
    stiff = {"stone": s.Material(density=2400.0, young=1e12, poisson=0.2)}
    mesh = s.MeshSettings(element="Q1", divisions=(1, 1))
    given = scene(arch(voussoirs, 0.15), 5.0, "elastic", 2, mesh=mesh, supports=(sinks,))
    return msgspec.structs.replace(given, materials=stiff)


def scene(
    structure: s.Structure, friction: Any, fidelity: str = "rigid", dimension: int = 3, **keys: Any
) -> s.Scene:
    """A structure of dry joints under its weight."""
    joints = (s.Joint(friction=friction),)
    mesh = s.MeshSettings(element="Q1", divisions=(2,) * dimension)
    loads = s.Loads(gravity=(0.0,) * (dimension - 1) + (-G,))
    given = {"joints": joints, "loads": loads, "analysis": STATICS, "fidelity": fidelity, "mesh": mesh} | keys
    return s.Scene(dimension=dimension, materials=STONE, structures=(structure,), **given)


def soft_wall(size: int) -> ContactProblem:
    """A plane wall whose contacts give way a little; it slides much faster than that."""
    made: ContactProblem = soft(plane_wall(size, size, friction=0.2, horizontal=0.3))
    return made


# --- families -----------------------------------------------------------------------------------


def recipes(size: Size = "default") -> list[Recipe]:
    """All recipes of a size; "tiny" has the first of each family that is made in a second."""
    every = [recipe for family in FAMILIES for recipe in family()]
    if size == "default":
        return every
    firsts: dict[str, Recipe] = {}
    for recipe in every:
        firsts.setdefault(recipe.family, recipe)
    return [recipe for family, recipe in firsts.items() if family != "large walls"]


def _walls() -> Iterator[Recipe]:
    """Rigid, in space and in a plane, standing still."""
    for (columns, courses), friction, share in product(
        ((6, 3), (3, 10), (6, 6)), (0.2, 0.6, 1.2), (0.5, 0.95, 0.99, 1.02)
    ):
        given = scene(wall(columns, courses), friction)
        yield Recipe("walls", f"{columns}x{courses} mu {friction:g} at {share:g}", given, share)
    for (columns, courses), friction, share in product(
        ((8, 4), (4, 12)), (0.1, 0.5, 0.8, 1e3), (0.8, 0.99, 1.1)
    ):
        given = scene(wall(columns, courses, 2), friction, dimension=2)
        yield Recipe("plane walls", f"{columns}x{courses} mu {friction:g} at {share:g}", given, share)


def _arches() -> Iterator[Recipe]:
    for voussoirs, friction, share in product((11, 41), (0.45, 0.7, 1e3), (0.5, 0.99, 1.02)):
        given = scene(arch(voussoirs), friction, dimension=2)
        yield Recipe("plane arches", f"{voussoirs} mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.5, 0.8), (0.5, 0.99, 1.1)):
        yield Recipe("arches", f"15 mu {friction:g} at {share:g}", scene(arch(15), friction), share)


def _domes() -> Iterator[Recipe]:
    for friction, share in product((0.4, 0.8), (None, 0.5, 0.95, 1.1)):
        told = "weight" if share is None else f"at {share:g}"
        yield Recipe("domes", f"6x10 mu {friction:g} {told}", scene(dome(6, 10, 0.5), friction), share)
    for friction, ratio in product((0.25, 0.4, 0.6), (0.045, 0.07, 0.1)):
        lune = dome(18, 1, 5 * ratio, sweep=5.0, sides=True)
        smooth = (s.Joint(friction=friction), s.Joint(friction=0.0, interface="meridian"))
        given = scene(lune, friction, joints=smooth)
        yield Recipe("lunes", f"mu {friction:g} thickness {ratio:g}", given, None)


def _rubble() -> Iterator[Recipe]:
    for seed, friction, share in product((1, 2), (0.4, 0.8), (0.5, 0.95, 1.1)):
        given = scene(rubble(30, seed), friction)
        yield Recipe("rubble", f"30 seed {seed} mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.3, 0.8), (0.8, 0.99)):
        given = scene(rubble(40, 3, 2), friction, dimension=2)
        yield Recipe("plane rubble", f"40 mu {friction:g} at {share:g}", given, share)


def _elastic() -> Iterator[Recipe]:
    for friction, share in product((0.3, 0.6, 1e3), (0.5, 0.95, 0.99, 1.02)):
        given = scene(wall(4, 4, 2), friction, "elastic", 2)
        yield Recipe("elastic plane walls", f"4x4 mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.3, 0.8), (0.5, 0.95, 1.02)):
        given = scene(wall(3, 3), friction, "elastic")
        yield Recipe("elastic walls", f"3x3 mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.5, 0.8), (0.5, 0.95, 1.1)):
        given = scene(arch(11), friction, "elastic", 2)
        yield Recipe("elastic arches", f"11 mu {friction:g} at {share:g}", given, share)
    for voussoirs, thickness in ((101, 0.12), (101, 0.11), (201, 0.11), (401, 0.11)):
        given = scene(arch(voussoirs, thickness), 0.7, "elastic", 2)
        yield Recipe("elastic arches", f"{voussoirs} thickness {thickness:g} weight", given, None)
    for friction in (0.4, 0.8):
        given = scene(dome(4, 8, 0.5), friction, "elastic")
        yield Recipe("elastic domes", f"4x8 mu {friction:g} weight", given, None)


def _mixed() -> Iterator[Recipe]:
    """Every other course rigid."""
    rigid = tuple(s.Override(blocks=f"wall.c{k}.*", fidelity="rigid") for k in (1, 3))
    for dimension, friction, share in product((2, 3), (0.4, 0.8), (0.5, 0.95, 1.02)):
        given = scene(wall(3, 4, dimension), friction, "elastic", dimension, overrides=rigid)
        yield Recipe("mixed walls", f"{dimension}D 3x4 mu {friction:g} at {share:g}", given, share)


def _laws() -> Iterator[Recipe]:
    """Joints that hold by more than friction, under what the dry ones bear and more."""
    soft: dict[str, Any] = {"normal_stiffness": 1e10, "tangential_stiffness": 4e9}
    bond: dict[str, Any] = {
        "normal_strength": 1e4, "tangential_strength": 2e4, "normal_energy": 1.0, "tangential_energy": 5.0,
    }  # fmt: skip
    laws: dict[str, dict[str, Any]] = {
        "mohr coulomb": {"law": s.law_record("mohr_coulomb", cohesion=5e3)},
        "springs": {"law": s.law_record("elastic", **soft)},
        "bilinear": {"law": s.law_record("bilinear", **soft, **bond)},
        "mortar": {"mortar": s.Mortar(**soft)},
    }
    for (name, keys), fidelity, share in product(laws.items(), ("rigid", "elastic"), (0.8, 1.1)):
        joints = (s.Joint(friction=0.6, **keys),)
        given = scene(wall(3, 4, 2), 0.6, fidelity, 2, joints=joints)
        yield Recipe("joints with laws", f"{name} {fidelity} 3x4 at {share:g}", given, share, call=3)
    for name, share in product(("mohr coulomb", "bilinear"), (0.8, 1.1)):
        joints = (s.Joint(friction=0.6, **laws[name]),)
        given = scene(wall(3, 4), 0.6, joints=joints, analysis=DYNAMICS)
        yield Recipe("laws in motion", f"{name} 3x4 at {share:g}", given, share, call=8)


def _dynamics() -> Iterator[Recipe]:
    """The first step, and one that has the step before to start from."""
    for (columns, courses), friction, share, call in product(
        ((6, 3), (5, 8)), (0.2, 0.6, 1.2), (0.5, 0.99, 1.1), (1, 10)
    ):
        given = scene(wall(columns, courses), friction, analysis=DYNAMICS)
        name = f"{columns}x{courses} mu {friction:g} at {share:g} step {call}"
        yield Recipe("moving walls", name, given, share, call)
    for friction, share, call in product((0.4, 0.8), (0.95, 1.1), (1, 10)):
        given = scene(wall(3, 3, 2), friction, "elastic", 2, analysis=DYNAMICS)
        name = f"3x3 mu {friction:g} at {share:g} step {call}"
        yield Recipe("moving elastic walls", name, given, share, call)
    for kind, structure in (("arch", arch(15)), ("rubble", rubble(25, 4)), ("dome", dome(5, 8, 0.4))):
        for friction, call in product((0.4, 0.8), (1, 10)):
            given = scene(structure, friction, analysis=DYNAMICS)
            yield Recipe(
                "moving arches and domes", f"{kind} mu {friction:g} at 1.1 step {call}", given, 1.1, call
            )


def _tipping() -> Iterator[Recipe]:
    """Walls that tip and slide at once, well beyond what they bear."""
    for (columns, courses), friction, share in product(((6, 6), (10, 8)), (0.4, 0.6), (1.2, 1.5)):
        given = scene(wall(columns, courses, 2), friction, dimension=2, analysis=DYNAMICS)
        name = f"{columns}x{courses} mu {friction:g} at {share:g}"
        yield Recipe("tipping plane walls", name, given, share)
    for friction, share in product((0.6, 0.7), (1.2, 1.4)):
        given = scene(wall(12, 12), friction, analysis=DYNAMICS)
        yield Recipe("tipping walls", f"12x12 mu {friction:g} at {share:g}", given, share)


def _layers() -> Iterator[Recipe]:
    """Layers of mortar between bricks, all of elements: the layers are slender."""
    for thickness in (1e-2, 2e-3, 5e-4):
        sizes = (0.06, thickness, 0.06)
        heights = np.concatenate([[0.0], np.cumsum(sizes)])
        pile = tuple(
            BlockStructure(
                name=f"b{k}", material="stone", size=(0.22, 0.1, size), position=(0.0, 0.0, heights[k]),
                mesh=s.MeshSettings(element="Q1", divisions=(4, 2, 1 if k == 1 else 2)),
            )
            for k, size in enumerate(sizes)
        )  # fmt: skip
        floor = BlockStructure(
            name="floor", material="stone", size=(2.0, 2.0, 0.1), position=(-0.5, -0.5, -0.1), support=True,
            fidelity="rigid",
        )  # fmt: skip
        push = s.Traction(on="b2/top", vector=(1e5, 0.0, -1e6))
        loads = s.Loads(gravity=(0.0, 0.0, -G), tractions=(push,))
        given = scene(floor, 0.6, "elastic", loads=loads)
        given = msgspec.structs.replace(given, structures=(floor, *pile))
        yield Recipe("layers", f"{1e3 * thickness:g} mm", given, None)


def _rough() -> Iterator[Recipe]:
    """Walls of five blocks that stand, soft by random matrices, and so rough that nothing slips."""
    for dimension, seed in product((2, 3), range(30)):
        made = elastic(np.random.default_rng(seed), dimension, 0.0)
        made = replace(made, friction=np.full(made.count, 100.0))
        yield Recipe("rough walls", f"{dimension}D seed {seed}", made, None)
    for dimension, mass, seed in product((2, 3), (0.0, 1.0), (1, 5)):
        made = elastic(np.random.default_rng(seed), dimension, mass)
        made = replace(made, friction=np.full(made.count, 1e6))
        told = "moves" if mass else "stands"
        yield Recipe("rough walls", f"{dimension}D mu 1e6 seed {seed} {told}", made, None)


def _rounds() -> Iterator[Recipe]:
    """Later rounds of a step of elastic blocks, which have turned: they start from the round before."""
    for friction, share, call in product((0.3, 0.6), (0.95, 0.99), (2, 3)):
        given = scene(wall(8, 6, 2), friction, "elastic", 2)
        name = f"wall 8x6 mu {friction:g} at {share:g} round {call}"
        yield Recipe("rounds", name, given, share, call)
    for voussoirs, calls in ((101, (2, 4)), (201, (3, 6, 18)), (401, (2, 3, 4, 5))):
        given = scene(arch(voussoirs, 0.11), 0.6, "elastic", 2)
        for call in calls:
            name = f"arch {voussoirs} thickness 0.11 round {call}"
            yield Recipe("rounds", name, given, None, call, falls=False)
    for (courses, push), call in product(((8, 0.0), (8, 1.5), (24, 0.0)), (2, 3)):
        name = f"tower {courses} courses pushed by {push:g} round {call}"
        yield Recipe("rounds", name, tower(courses, push), None, call, falls=False)


def _gaping() -> Iterator[Recipe]:
    """Head joints open at the start; joints of a dome that gape and slide where its stones have turned."""
    for gap in (1e-7, 1e-6, 1e-5):
        yield Recipe("open joints", f"6x4 gap {gap:g}", gaping_wall(6, 4, gap), None, falls=False)
    push = s.Acceleration(vector=(0.1, 0.0, 0.0))
    loads = s.Loads(gravity=(0.0, 0.0, -G), accelerations=(push,))
    given = scene(dome(8, 16, 0.5), 0.7, "elastic", loads=loads, mesh=s.MeshSettings(divisions=(1, 1, 1)))
    yield Recipe("open joints", "dome 8x16 pushed round 3", given, None, 3, falls=False)


def _at_limit() -> Iterator[Recipe]:
    """Elastic walls so near to their limit that turning a little decides; the next round starts anew."""
    for share, call in product((1 - 3e-7, 1.0, 1 + 3e-7), (1, 2)):
        given = scene(wall(3, 4, 2), 0.3, "elastic", 2)
        yield Recipe("elastic walls at their limit", f"3x4 at {share:.7f} round {call}", given, share, call)


def _falling() -> Iterator[Recipe]:
    """What falls in the last of many load steps, from a state that stood: its mechanism is known."""
    column = StackStructure(name="column", material="stone", size=(0.5, 0.3), count=6)
    structures = ((arch(11), 4), (arch(20), 4), (arch(15, 0.15), 4), (arch(27, 0.12), 4), (column, 1))
    for (structure, joints), friction, fidelity in product(structures, (0.6, 5.0), ("rigid", "elastic")):
        given = scene(structure, friction, fidelity, 2, analysis=GROWING)
        still = msgspec.structs.replace(given.loads, gravity_time=AT_ONCE)
        given = msgspec.structs.replace(given, loads=still)
        size = structure.count if isinstance(structure, StackStructure) else structure.voussoirs
        name = f"{structure.name} {size} {fidelity} mu {friction:g}"
        # blocks that deform move everywhere
        known = joints if fidelity == "rigid" else None
        yield Recipe("falling", name, given, 1.005, END, joints=known)
    for friction, share, call in product(("no slip", 0.6), (0.99, 1.03), (20, END)):
        name = f"spread arch mu {friction} at {share:g} call {call if call < END else 'last'}"
        # A3.7 knows of arches that do not slip
        falls = (share > 1 and call == END) if friction == "no slip" else None
        yield Recipe("spread arches", name, spread_arch(friction, share), None, call, falls=falls)


def _demos() -> Iterator[Recipe]:
    """A mortar joint sheared to and fro; a dome on piers, dry and with mortar that breaks."""
    steps = ("loads.tractions.0.vector=[0.0, -0.5e6]", "analysis.load_steps=200")
    for call in (101, 151, 152, 191, 221, 231):
        yield Recipe("sheared joint", f"call {call}", load(cyclic_joint.SCENE, overrides=steps), None, call)
    size = "structures.dome.rings=6"
    strong = load(dome_on_piers.SCENE, overrides=(size,))
    weak = load(dome_on_piers.SCENE, overrides=(size, *dome_on_piers.WEAK))
    drum = (f"structures.dome.{key}" for key in dome_on_piers.TAMBOUR)
    dry, tambour = (
        msgspec.structs.replace(one, joints=(s.Joint(friction=0.7),))
        for one in (strong, load(dome_on_piers.SCENE, overrides=(size, *drum)))
    )
    yield Recipe("domes on piers", "dry", dry, None, falls=True)
    for call in (1, 2):
        yield Recipe("domes on piers", f"dry on a tambour call {call}", tambour, None, call, falls=False)
    for name, given, calls in (("strong", strong, (2, 3)), ("weak", weak, (2, 4, 7))):
        for call in calls:
            yield Recipe("domes on piers", f"{name} mortar call {call}", given, None, call)


def _marches() -> Iterator[Recipe]:
    """Steps of a march of elastic blocks that move, each from the one before."""
    for share, call in product((0.9, 1.1), (2, 5, 20)):
        for name, structure, dimension in (
            ("wall 5x6", wall(5, 6, 2), 2), ("arch 21", arch(21), 2), ("wall 3x3", wall(3, 3), 3),
        ):  # fmt: skip
            given = scene(structure, 0.6, "elastic", dimension, analysis=DYNAMICS)
            yield Recipe("marches", f"{name} at {share:g} step {call}", given, share, call)


def _large() -> Iterator[Recipe]:
    for friction, share, analysis in product((0.3, 0.7), (0.5, 0.99), (STATICS, DYNAMICS)):
        told = "statics" if analysis is STATICS else "dynamics"
        given = scene(wall(15, 10), friction, analysis=analysis)
        yield Recipe("large walls", f"15x10 mu {friction:g} at {share:g} {told}", given, share)
    for columns, courses, analysis in ((30, 16, DYNAMICS), (40, 20, STATICS)):
        given = scene(wall(columns, courses), 0.6, analysis=analysis)
        yield Recipe("large walls", f"{columns}x{courses} mu 0.6 at 0.5", given, 0.5)


def _needy() -> Iterator[Recipe]:
    """What shows a part at work that the other families do without."""
    yield Recipe("needy", "elastic arch parted by 5 mm at once", loads(PARTED), None, falls=False)
    for share in (1.03, 1.17):
        given = scene(wall(10, 10, 2), 0.3, "elastic", 2)
        yield Recipe("needy", f"elastic wall 10x10 at {share:g}", given, share)
    yield Recipe("needy", "elastic wall 5x5 at its limit", scene(wall(5, 5), 0.3, "elastic"), 1.0)
    sliding = scene(wall(40, 20), 0.2, analysis=s.Dynamics(step=0.01, duration=1.0))
    yield Recipe("needy", "wall 40x20 that slides", sliding, 1.5)
    for voussoirs in (16, 21):
        name = f"stiff arch {voussoirs} that sinks by 1 mm at once"
        yield Recipe("needy", name, sunk_arch(voussoirs, 1e-3), None, falls=False)
    tipping = partial(rigid_wall, 18, 18, friction=0.7, horizontal=0.7)
    yield Recipe("needy", "wall 18x18 that is about to slide and tip", tipping, None)
    yield Recipe("needy", "mass of 12x12x12 bricks", partial(rigid_mass, 12, 12, 12), None)
    for size in (3, 4):
        fast = partial(soft_wall, size)
        yield Recipe("needy", f"soft wall {size}x{size} that slides fast", fast, None)
    yield Recipe("needy", "matrix of low rank", low_rank(np.random.default_rng(177), 1.0), None)


def _exact() -> Iterator[Recipe]:
    """What decides beyond 1e-8, down to what runs aim at of themselves."""
    for (columns, courses), friction, share in product(((10, 10), (12, 12)), (0.6, 0.7), (1.2, 1.4)):
        given = scene(wall(columns, courses), friction, analysis=DYNAMICS)
        name = f"tipping wall {columns}x{courses} mu {friction:g} at {share:g}"
        yield Recipe("exact", name, given, share, tolerance=EXACT)
    bond = s.law_record(
        "bilinear", normal_stiffness=1e10, tangential_stiffness=1e10, normal_strength=1e5,
        tangential_strength=2e5, normal_energy=10.0, tangential_energy=50.0,
    )  # fmt: skip
    joints = (s.Joint(friction=0.7, law=bond),)
    face = s.Traction(on="wall.*/front", vector=(0.0, 6e3, 0.0))
    corner = s.PointForce(block="wall.c4.b1", vector=(1e3, 0.0, 0.0))
    loads = s.Loads(gravity=(0.0, 0.0, -G), gravity_time=AT_ONCE, tractions=(face,), points=(corner,))
    analysis = s.Statics(load_steps=10)
    given = scene(wall(4, 5), 0.7, joints=joints, loads=loads, analysis=analysis)
    for call in (8, 17, 23):
        name = f"mortar wall 4x5 pushed over call {call}"
        yield Recipe("exact", name, given, None, call, falls=False, tolerance=EXACT)
    given = block_on_slope(1e10, 26.0, analysis=LARGE_STEP, edge=2.2)
    yield Recipe("exact", "cube on a rough slope", given, None, falls=False, tolerance=EXACT)
    for ratio in (1e-6, 1e6):
        name = f"patch of stiffness ratio {ratio:g} round 2"
        yield Recipe("exact", name, patch(ratio=ratio), None, 2, falls=False, tolerance=EXACT)


FAMILIES = (
    _walls,
    _arches,
    _domes,
    _rubble,
    _elastic,
    _mixed,
    _laws,
    _dynamics,
    _tipping,
    _layers,
    _rough,
    _rounds,
    _gaping,
    _at_limit,
    _falling,
    _demos,
    _marches,
    _large,
    _needy,
    _exact,
)

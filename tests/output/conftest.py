"""Structures without finite elements: groups whose fields are given arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from masonry_fem.bodies.base import StressField
from masonry_fem.contact.contacts import Contacts, Interface
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.joints import Assignment, Dry
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.records.told import Ending
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose


def ended(outcome: str = "finished") -> Ending:
    """What a recorder hears of a run that has come to its end."""
    return Ending(schema="run/2", title="", outcome=outcome, message="")


@dataclass(frozen=True)
class Moved:
    displacement: np.ndarray
    velocity: np.ndarray
    stress: StressField | None = None


@dataclass
class FakeGroup:
    blocks: np.ndarray
    cell: str | None
    points: list[np.ndarray]
    table: Any
    prescribed: bool = False
    mass: np.ndarray = field(default_factory=lambda: np.ones(1))

    @property
    def deforms(self) -> bool:
        return self.cell is not None

    @property
    def kind(self) -> str:
        return "support" if self.prescribed else "elastic" if self.deforms else "rigid"

    def cells(self, body: int) -> Any:
        return self.table

    def nodes(self, body: int) -> np.ndarray:
        return self.points[body]

    @property
    def alike(self) -> np.ndarray:
        return np.zeros(len(self.points), dtype=int)

    @property
    def places(self) -> np.ndarray:
        return np.concatenate(self.points)

    @property
    def first(self) -> np.ndarray:
        return np.cumsum([0, *map(len, self.points)])

    def displacements(self, state: Moved) -> np.ndarray:
        return np.concatenate(list(state.displacement))

    def velocities(self, state: Moved) -> np.ndarray:
        return np.concatenate(list(state.velocity))

    def stress(self, state: Moved) -> StressField | None:
        return state.stress

    def material_state(self, state: Moved) -> dict[str, np.ndarray]:
        return {}

    def stress_error(self, state: Moved) -> None:
        return None


@dataclass(frozen=True)
class FakeReport:
    step: int
    time: float
    kinetic_energy: float = 0.0
    strain_energy: float = 2.5
    iterations: int = 7
    natural_map: float = 1e-11
    support_resultants: dict[str, np.ndarray] = field(default_factory=dict)
    applied: np.ndarray = field(default_factory=lambda: np.zeros(6))
    probes: dict[str, np.ndarray] = field(default_factory=dict)


@pytest.fixture
def report():
    def make(step: int) -> FakeReport:
        ground = np.array([0.0, 0.0, 10.0 + step, 0.0, 1.0, 0.0])
        return FakeReport(
            step, 0.1 * step, 0.5 * step, 2.5, 7, 1e-11, {"ground": ground}, np.array([0, 0, -10.0, 0, 0, 0]),
            {"top": np.array([1e-5 * step, 0.0, -2e-5])},
        )  # fmt: skip

    return make


def box_mesh(size: tuple[float, ...], divisions: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and quadrangles or hexahedra of a box, VTK order."""
    axes = [np.linspace(0, s, n + 1) for s, n in zip(size, divisions, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(size))
    number = np.arange(len(points)).reshape([n + 1 for n in divisions])
    if len(size) == 2:
        parts = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    else:
        low = number[:, :, :-1], number[:, :, 1:]
        parts = tuple(p for n in low for p in (n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]))
    return points, np.stack([p.ravel() for p in parts], axis=1)


def wall_model(dimension: int, courses: int = 4, columns: int = 4, *, rigid: bool = False) -> Model:
    """Running bond of bricks on a rigid ground block, contacts at the corners of the bed joints."""
    size = (0.4, 0.2, 0.15)[:dimension] if dimension == 3 else (0.4, 0.15)
    up = dimension - 1
    lows = []
    for course in range(courses):
        for column in range(columns - course % 2):
            low = np.zeros(dimension)
            low[0], low[up] = (column + 0.5 * (course % 2)) * size[0], course * size[up]
            lows.append(low)
    ground_low = -0.1 * np.ones(dimension)
    ground_high = np.array([columns * size[0] + 0.1, 0.3, 0.0]) if dimension == 3 else np.array([1.7, 0.0])
    ground_low[up] = -0.2
    ground = Polytope.box(tuple(ground_low), tuple(ground_high))
    brick = Polytope.box((0.0,) * dimension, size)
    blocks = [Block("ground", 0, Pose.identity(dimension), support=True)]
    blocks += [Block(f"wall.b{i}", 1, Pose.at(*low)) for i, low in enumerate(lows)]
    assembly = Assembly(dimension, (Shape("ground", ground), Shape("brick", brick)), tuple(blocks))
    numbers = np.arange(1, len(blocks))
    if rigid:
        stones = FakeGroup(numbers, None, [brick.vertices + low for low in lows], brick.faces)
    else:
        kind = "hexahedron" if dimension == 3 else "quad"
        points, cells = box_mesh(size, (4, 2, 2) if dimension == 3 else (6, 3))
        stones = FakeGroup(numbers, kind, [points + low for low in lows], cells)
    base = FakeGroup(np.array([0]), None, [ground.vertices], ground.faces, prescribed=True)
    interfaces, contacts = bed_contacts(lows, size, dimension)
    laws = Assignment.of(Dry(0.5), contacts.count)
    return Model(assembly, (base, stones), interfaces, contacts, laws, (), (), 0.3)  # type: ignore[arg-type]


def bed_contacts(lows: list, size: tuple, d: int) -> tuple[Interfaces, Contacts]:
    up, interfaces, rows = d - 1, [], []
    frame = (
        np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float) if d == 3 else np.array([[0, 1], [-1, 0]], float)
    )
    for i, low in enumerate(lows):
        below = [j for j, other in enumerate(lows) if abs(other[up] + size[up] - low[up]) < 1e-9]
        for j in below or [-1]:
            a = low[0] if j < 0 else max(low[0], lows[j][0])
            b = low[0] + size[0] if j < 0 else min(low[0] + size[0], lows[j][0] + size[0])
            if b - a < 1e-6:
                continue
            if d == 3:
                polygon = np.array(
                    [[a, 0, low[2]], [b, 0, low[2]], [b, size[1], low[2]], [a, size[1], low[2]]]
                )
            else:
                polygon = np.array([[a, low[1]], [b, low[1]]])
            area = (b - a) * (size[1] if d == 3 else 1.0)
            rows += [(i + 1, j + 1, len(interfaces), p, area / len(polygon)) for p in polygon]
            interfaces.append(
                Interface((i + 1, j + 1), (4, 5), frame[0], polygon, np.zeros(len(polygon)), area, "bed")
            )
    count = len(rows)
    points = np.array([r[3] for r in rows])
    return Interfaces.of(interfaces, d), Contacts(
        np.array([r[:2] for r in rows]), np.array([r[2] for r in rows]), np.stack([points, points], axis=1),
        np.full((count, 2), -1), np.broadcast_to(frame, (count, d, d)).copy(), np.zeros(count),
        np.array([r[4] for r in rows]),
    )  # fmt: skip


def wall_state(model: Model, index: int = 3) -> SystemState:
    """Bricks squeezed and sheared under their own weight, an analytic field."""
    d, bodies = model.assembly.dimension, []
    up = d - 1
    for group in model.groups:
        points = np.stack(group.points)  # type: ignore[attr-defined]
        height = points[..., up].max() if group.deforms or not group.prescribed else 0.0
        displacement = np.zeros_like(points)
        if not group.prescribed:
            z = points[..., up]
            displacement[..., up] = -1e-6 * z * (2 * height - z)
            displacement[..., 0] = 2e-6 * z**2
        field = None
        if group.deforms:
            x = points[:, group.table].mean(axis=2)  # type: ignore[attr-defined]
            gauss = np.zeros((*x.shape[:2], 1, 6))
            nodal = np.zeros((*points.shape[:2], 6))
            for out, at in ((gauss[:, :, 0], x), (nodal, points)):
                out[..., up] = -20e3 * (height - at[..., up]) * (1 + at[..., 0])
                out[..., 0] = 3e3 * np.sin(9 * at[..., 0])
                out[..., 5 if d == 3 else 3] = 4e3 * at[..., 0]
            weight = np.full((x.shape[1], 1), 1e-3)
            field = StressField(gauss, weight, nodal)
        bodies.append(Moved(displacement, 0.5 * displacement, field))
    contacts = model.contacts
    reaction = np.zeros((contacts.count, d))
    reaction[:, 0] = 9e3 * contacts.area * (1.2 - contacts.points[:, 0, up])
    reaction[:, 1] = 0.2 * reaction[:, 0] * np.sin(5 * contacts.points[:, 0, 0])
    status = np.where(np.arange(contacts.count) % 5 == 0, 2, 1)
    status[-1], reaction[-1] = 0, 0.0
    return SystemState(
        0.1 * index, index, tuple(bodies), reaction, 0.01 * reaction, contacts.gap, status.astype(np.int8),
        contacts.frame, contacts.points[:, 0], contacts.frame,
        jump=np.zeros_like(reaction), joints=model.laws.initial(*reaction.shape),
    )  # fmt: skip


@pytest.fixture(params=[2, 3], ids=["2D", "3D"])
def dimension(request):
    return request.param


@pytest.fixture
def elastic(dimension):
    model = wall_model(dimension)
    return model, wall_state(model)


@pytest.fixture
def rigid(dimension):
    model = wall_model(dimension, rigid=True)
    return model, wall_state(model)


@pytest.fixture
def state_at():
    return wall_state

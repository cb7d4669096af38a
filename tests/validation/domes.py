"""Domes of 5 m and 20 kN/m³: a lune of some degrees between planes of symmetry, and what is read from it.

The planes are supports beside the lune; joints on them are without friction, springs or unilateral.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import (
    AnyLaw,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Scene,
    Solver,
    Statics,
    Support,
    Table,
    law_record,
)
from masonry_fem.structures.dome import DomeStructure

RADIUS, GAMMA, G = 5.0, 20e3, 9.81
SWEEP = 10.0
STIFF = 1e13  # springs of bonded joints [N/m³]: they give way 1e-4 of what the stones do
BONDED = law_record("elastic", normal_stiffness=STIFF, tangential_stiffness=STIFF)
PLANE = law_record("elastic", normal_stiffness=STIFF, tangential_stiffness=1.0)  # bonded, yet free to slide


def brittle(strength: float) -> AnyLaw:
    """A joint on a plane of symmetry that cracks at ``strength`` [Pa]."""
    return law_record(
        "elastic_brittle",
        normal_stiffness=STIFF,
        tangential_stiffness=1.0,
        normal_strength=strength,
        tangential_strength=1e9,
    )


def lune(
    *,
    thickness: float,
    meridian: AnyLaw | None,
    beds: AnyLaw | None = None,
    base_friction: float = 0.0,
    spread: float = 0.0,
    steps: int = 1,
    rings: int = 18,
    element: str = "Q1",
    sweep: float = SWEEP,
    friction: float = 0.6,
    fidelity: Literal["elastic", "rigid"] = "elastic",
    tolerance: float = 1e-10,
) -> RunResult:
    """One slice of a hemisphere under its weight; where its base spreads, after the weight."""
    a = np.radians(sweep / 2)
    outwards = Motion(
        displacement=(spread * np.cos(a), spread * np.sin(a), 0.0),
        time=Table(points=((0.5, 0.0), (1.0, 1.0))),
    )
    loads: dict[str, Any] = {"gravity": (0.0, 0.0, -G)}
    if spread:
        loads["gravity_time"] = Table(points=((0.0, 0.0), (0.5, 1.0)))
    scene = Scene(
        fidelity=fidelity,
        materials={"stone": Material(density=GAMMA / G, young=10e9, poisson=0.0)},
        structures=(
            DomeStructure(
                name="dome",
                material="stone",
                radius=RADIUS,
                thickness=thickness,
                rings=rings,
                slices=1,
                sweep=sweep,
                sides=True,
            ),
        ),
        mesh=MeshSettings(element=element, divisions=(1, 1, 1)),
        joints=(
            Joint(friction=friction, law=beds),
            Joint(friction=base_friction, between=("dome.base.*", "dome.r1.*"), interface="bed"),
            Joint(friction=0.0, law=meridian, interface="meridian"),
        ),
        supports=(Support(on="dome.base.*", motion=outwards),) if spread else (),
        loads=Loads(**loads),
        analysis=Statics(load_steps=steps),
        solver=Solver(tolerance=tolerance),
    )
    return solve_scene(scene)


def mean_stresses(result: RunResult) -> np.ndarray:
    """Of each stone: angle from the crown [deg], stress along meridian and parallel [Pa], (stones, 3)."""
    model, rows = result.built.model, []
    for group, own in zip(model.groups, result.march.state.bodies, strict=True):
        field = group.stress(own)
        if field is None:
            continue
        weight = np.broadcast_to(field.weight, field.gauss.shape[:3])[..., None]
        mean = (field.gauss * weight).sum((1, 2)) / weight.sum((1, 2))
        for block, (xx, yy, zz, xy, yz, xz) in zip(group.blocks, mean, strict=True):
            place = model.assembly.solid(int(block)).mass_properties().centroid
            out = place / np.linalg.norm(place)
            parallel = np.array([-out[1], out[0], 0.0]) / np.hypot(out[0], out[1])
            meridian = np.cross(parallel, out)
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            angle = np.degrees(np.arccos(out[2]))
            rows.append((angle, meridian @ tensor @ meridian, parallel @ tensor @ parallel))
    return np.array(sorted(rows))


def membrane(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stress along meridian and parallel of a uniform shell under its weight [Pa]."""
    c = np.cos(np.radians(angle))
    return -GAMMA * RADIUS / (1 + c), GAMMA * RADIUS * (1 / (1 + c) - c)


def meridian_points(result: RunResult) -> tuple[np.ndarray, np.ndarray]:
    """Contacts of the meridian joints and their angles from the crown [deg], shapes (n,)."""
    model, points = result.built.model, result.march.state.points
    labels = np.array([interface.label == "meridian" for interface in model.interfaces])
    mine = np.flatnonzero(labels[model.contacts.interface])
    place = points[mine]
    return mine, np.degrees(np.arctan2(np.hypot(place[:, 0], place[:, 1]), place[:, 2]))


def thrust(result: RunResult, sweep: float = SWEEP) -> tuple[float, float]:
    """Horizontal thrust on the base and weight, per radian of longitude [N]."""
    force, a = np.array(result.summary.supports["dome.base.s1"].force), np.radians(sweep / 2)
    return -float(force[0] * np.cos(a) + force[1] * np.sin(a)) / (2 * a), float(force[2]) / (2 * a)

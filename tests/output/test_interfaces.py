"""What joints carry, against statics with a pencil, in structures solved by the program itself."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, run
from masonry_fem.output.asked.interfaces import interface_columns, write_interfaces
from masonry_fem.output.interfaces import (
    CRACKED,
    FREE,
    HELD,
    HINGE,
    MIDDLE_THIRD,
    InterfaceForces,
    _side_names,
    interface_forces,
)
from masonry_fem.output.joint_faces import JointFaces
from masonry_fem.results.joints import joint_summary
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Joint,
    Loads,
    MeshSettings,
    Motion,
    Output,
    PointForce,
    Scene,
    Statics,
    Support,
    law_record,
)
from masonry_fem.structures.arch_bridge import ArchBridgeStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.validation.scenes import STONE, G, rigid_arch, solved
from tests.validation.test_a6_5_floor_rotation import THETA, B, lowered

GAMMA = STONE.density * G


def told(result: RunResult) -> InterfaceForces:
    return interface_forces(result.march.model, result.march.state)


def between(result: RunResult, one: str, other: str) -> int:
    """Number of the interface of two blocks."""
    model = result.march.model
    names = [{model.assembly.blocks[b].name for b in face.blocks} for face in model.interfaces]
    return names.index({one, other})


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))


def stack(dimension: int, gravity: tuple[float, ...], size: tuple[float, ...], count: int = 4) -> RunResult:
    pile = StackStructure(name="tower", material="stone", size=size, count=count)
    return solved(
        dimension=dimension, fidelity="rigid", structures=(pile,), joints=(Joint(friction=2.0),),
        loads=Loads(gravity=gravity), analysis=Statics(load_steps=1),
    )  # fmt: skip


@pytest.fixture(scope="module")
def spread_arch() -> RunResult:
    """A3.3 and A3.7: N = 20, t = .2 R, springings that part by 1e-4 R: three hinges, 63° from the crown."""
    moved = Support(on="arch.springing_right", motion=Motion(displacement=(1e-4, 0.0)))
    return rigid_arch(
        thickness=0.2, voussoirs=20, friction=5.0, supports=(moved,), analysis=Statics(load_steps=2)
    )


def test_arch_of_least_thrust_has_hinges_at_crown_and_haunches(spread_arch: RunResult):
    forces = told(spread_arch)
    crown = between(spread_arch, "arch.v10", "arch.v11")
    haunches = [between(spread_arch, "arch.v03", "arch.v04"), between(spread_arch, "arch.v17", "arch.v18")]
    hinges = np.flatnonzero(forces.status == HINGE)
    assert sorted(hinges) == sorted([crown, *haunches])
    assert [forces.edge[k] for k in (crown, *haunches)] == ["extrados", "intrados", "intrados"]
    for k in (crown, *haunches):
        (sides,) = forces.faces.sides[k].tolist()
        towards = 1 if sides[1] == forces.edge[k] else -1
        assert forces.eccentricity[k, 0] == pytest.approx(towards * 0.1, rel=1e-4)
        assert forces.opening[k] > 1e-6
    assert (forces.plastic.area[hinges] == 0).all()


def test_thrust_at_the_crown_is_that_of_the_springings(spread_arch: RunResult):
    forces = told(spread_arch)
    thrust = abs(spread_arch.summary.supports["arch.springing_left"].force[0])
    crown = forces.force[between(spread_arch, "arch.v10", "arch.v11")]
    assert abs(crown[0]) == pytest.approx(thrust, rel=1e-4)
    assert crown[1] == pytest.approx(0.0, abs=1e-3 * thrust)
    # every joint has the same thrust, and the weight of the stones above
    np.testing.assert_allclose(np.abs(forces.force[:, 0]), thrust, rtol=1e-3)


def test_contact_points_moved_inwards_have_their_hinges_there():
    """ξ = 0.75: a joint turns at 0.75 of half its thickness, and its stress blocks are finite."""
    moved = Support(on="arch.springing_right", motion=Motion(displacement=(1e-4, 0.0)))
    result = rigid_arch(
        thickness=0.2, voussoirs=12, friction=5.0, inset=0.75, supports=(moved,),
        analysis=Statics(load_steps=2),
    )  # fmt: skip
    forces = told(result)
    hinges = forces.status == HINGE
    assert hinges.sum() >= 3
    np.testing.assert_allclose(np.abs(forces.eccentricity[hinges, 0]), 0.075, rtol=1e-3)
    np.testing.assert_allclose(forces.linear.area[hinges], 3 * 0.025, rtol=1e-2)


@pytest.mark.parametrize("slope", [0.05, 0.12, 0.25])
def test_leaning_tower_presses_off_its_middle(slope: float):
    """e = M/N: tan α times half the height above; sum of N is the weight above."""
    result = stack(2, (G * slope, -G), (0.8, 0.5))
    forces = told(result)
    for k, face in enumerate(result.march.model.interfaces):
        above = 5 - max(face.blocks)
        assert forces.normal[k] == pytest.approx(above * 0.4 * GAMMA, rel=1e-9)
        e = slope * above * 0.25
        x = forces.centre[k, 0] - forces.faces.centroid[k, 0]
        assert x == pytest.approx(e, rel=1e-8)
        assert abs(forces.moment[k, 0]) == pytest.approx(forces.normal[k] * e, rel=1e-8)
        assert forces.status[k] == (MIDDLE_THIRD if e <= 0.8 / 6 else CRACKED)
        assert forces.friction_used[k] == pytest.approx(slope / 2.0, rel=1e-8)
        pressed = min(0.8, 3 * (0.4 - e))
        assert forces.linear.area[k] == pytest.approx(pressed, rel=1e-8)
        ratio = 1 + 6 * e / 0.8 if e <= 0.8 / 6 else 2 * 0.8 / pressed
        assert forces.linear.pressure[k] == pytest.approx(forces.normal[k] / 0.8 * ratio, rel=1e-8)
        assert forces.plastic.pressure[k] == pytest.approx(forces.normal[k] / (0.8 - 2 * e), rel=1e-8)


def test_tower_that_leans_both_ways_has_two_eccentricities():
    result = stack(3, (0.1 * G, -0.05 * G, -G), (0.8, 0.6, 0.5))
    forces = told(result)
    k = between(result, "tower.b1", "tower.ground")
    np.testing.assert_allclose(forces.faces.axes[k], [[1, 0, 0], [0, 1, 0]], atol=1e-12)
    assert forces.faces.sides[k].tolist() == [["left", "right"], ["front", "back"]]
    weight = 4 * 0.24 * GAMMA
    assert forces.normal[k] == pytest.approx(weight, rel=1e-9)
    np.testing.assert_allclose(forces.eccentricity[k], [0.1, -0.05], rtol=1e-7)
    np.testing.assert_allclose(forces.shear[k], [-0.1 * weight, 0.05 * weight], rtol=1e-7)
    # |e1|/h1 + |e2|/h2 = 1/6 on the kern's rim
    assert forces.kern[k] == pytest.approx(6 * (0.1 / 0.8 + 0.05 / 0.6), rel=1e-7)
    assert forces.status[k] == CRACKED
    top = between(result, "tower.b4", "tower.b3")
    assert forces.status[top] == MIDDLE_THIRD
    navier = (0.24 * GAMMA / 0.48) * (1 + 6 * (0.025 / 0.8 + 0.0125 / 0.6))
    assert forces.linear.pressure[top] == pytest.approx(navier, rel=1e-6)


def test_beds_of_a_wall_carry_the_weight_above():
    wall = WallStructure(name="wall", material="stone", brick=(0.4, 0.2), columns=4, courses=5)
    result = solved(
        dimension=2, fidelity="rigid", structures=(wall,), joints=(Joint(friction=0.6),),
        analysis=Statics(load_steps=1),
    )  # fmt: skip
    forces, model = told(result), result.march.model
    level = np.array([face.polygon[0, 1] for face in model.interfaces])
    bed = np.array([face.label == "bed" for face in model.interfaces])
    height = max(block.pose.translation[1] for block in model.assembly.blocks) + 0.2
    for y in np.unique(np.round(level[bed], 9)):
        own = bed & (np.abs(level - y) < 1e-6)
        assert forces.force[own, 1].sum() == pytest.approx(1.6 * (height - y) * GAMMA, rel=1e-9)


@pytest.mark.parametrize(("push", "status"), [(0.1, MIDDLE_THIRD), (0.4, CRACKED), (0.498, HINGE)])
def test_buttress_under_a_thrust(push: float, status: int):
    """A6.1: e = H h / W; it overturns at H h = W b / 2."""
    width, height = 1.0, 2.0
    weight = width * height * GAMMA
    pier = StackStructure(name="pier", material="stone", size=(width, height), count=1)
    thrust = push * weight * width / height
    result = solved(
        dimension=2, fidelity="rigid", structures=(pier,), joints=(Joint(friction=0.6),),
        loads=Loads(
            gravity=(0.0, -G),
            points=(PointForce(block="pier.b1", point=(0.0, height), vector=(thrust, 0.0)),),
        ),
        analysis=Statics(load_steps=1),
    )  # fmt: skip
    forces = told(result)
    assert forces.centre[0, 0] - width / 2 == pytest.approx(thrust * height / weight, rel=1e-8)
    assert forces.status[0] == status
    assert forces.edge[0] == ("right" if status == HINGE else "")
    assert forces.friction_used[0] == pytest.approx(thrust / weight / 0.6, rel=1e-8)
    assert not forces.slides[0]
    faces = JointFaces.of(result.march.model)
    nameless = replace(faces, sides=np.full((1, 1, 2), ""))  # as of a stone that stands askew
    along = faces.axes[0, 0, 0]
    ends = [_side_names(nameless, np.array([[along * way]])) for way in (-1, 1)]
    assert ends == [["-x"], ["+x"]]


def test_a6_5_floor_opens_by_its_turn_and_presses_the_edge():
    result = lowered("rigid")
    forces = told(result)
    k = between(result, "slab", "wall")
    assert forces.opening[k] == pytest.approx(B * THETA, rel=1e-4)
    assert abs(forces.eccentricity[k, 0]) == pytest.approx(B / 2, rel=1e-5)
    assert forces.status[k] == HINGE
    widest = joint_summary(result.march.model, result.march.state).greatest_opening
    assert widest.value == pytest.approx(B * THETA, rel=1e-4)
    assert widest.interface == "slab / wall (bed)"


@pytest.fixture(scope="module")
def dragged() -> RunResult:
    """A block that a fixed stop holds back while the floor below it moves on by 1 cm."""
    return solved(
        dimension=2,
        fidelity="rigid",
        structures=(
            BlockStructure(
                name="floor", material="stone", size=(3.0, 0.2), position=(-1.0, -0.2), support=True
            ),
            BlockStructure(
                name="stop", material="stone", size=(0.2, 1.0), position=(1.0, 0.05), support=True
            ),
            BlockStructure(name="block", material="stone", size=(1.0, 0.5)),
        ),
        joints=(Joint(friction=0.3), Joint(friction=0.0, between=("stop", "block"))),
        supports=(Support(on="floor", motion=Motion(displacement=(0.01, 0.0))),),
        analysis=Statics(load_steps=2),
        output=Output(interfaces=True, pictures=False, fields=True),
    )


def test_prescribed_slide_is_found(dragged: RunResult):
    forces = told(dragged)
    bed, head = between(dragged, "block", "floor"), between(dragged, "block", "stop")
    np.testing.assert_allclose(forces.sliding[bed], 0.01, rtol=1e-8)
    np.testing.assert_allclose(forces.corner_sliding[bed], 0.01, rtol=1e-8)
    assert forces.slides[bed]
    assert forces.friction_used[bed] == pytest.approx(1.0, rel=1e-9)
    assert forces.normal[head] == pytest.approx(0.3 * 0.5 * GAMMA, rel=1e-8)
    np.testing.assert_allclose(forces.sliding[head], 0.0, atol=1e-9)
    # the stop is friction-free: what friction is used of none is unknown
    assert np.isnan(forces.friction_used[head])
    assert dragged.summary.joints.slide >= 1


def test_contacts_found_anew_know_how_far_they_slid():
    """Two slabs that slide together over a floor: a = g' − μ g; e is the lever of friction, h_i/2 μ."""
    mu, slope, end = 0.1, 3.0, 0.5
    slabs = [
        BlockStructure(name=name, material="stone", size=(1.0, 0.5), position=(0.0, y))
        for name, y in (("low", 0.0), ("high", 0.5))
    ]
    floor = BlockStructure(
        name="floor", material="stone", size=(4.0, 0.2), position=(-2.0, -0.2), support=True
    )
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(floor, *slabs),
        joints=(Joint(friction=mu, form="velocity"),),
        loads=Loads(gravity=(slope, -G)),
        analysis=Dynamics(step=0.01, duration=end),
        contact=Contact(update="redetect", every=3),
    )
    forces = told(result)
    bed, upper = between(result, "low", "floor"), between(result, "high", "low")
    slid = 0.5 * (slope - mu * G) * end**2
    np.testing.assert_allclose(forces.sliding[bed], slid, rtol=1e-6)
    np.testing.assert_allclose(forces.sliding[upper], 0.0, atol=1e-9)
    np.testing.assert_allclose(forces.eccentricity[[bed, upper], 0], [-0.5 * mu, -0.25 * mu], rtol=1e-6)
    np.testing.assert_allclose(forces.faces.centroid[[bed, upper], 0], 0.5 + slid, rtol=1e-5)


def test_two_meshes_press_each_other_alike():
    """Elastic blocks whose finer mesh takes the contact's side of the candidate: weights and levers stay."""
    blocks = [
        BlockStructure(
            name=name, material="stone", size=(1.0, 1.0, 1.0), position=(0.0, 0.0, z),
            mesh=MeshSettings(divisions=(n, n, 2)),
        )
        for name, z, n in (("a", 0.0, 3), ("b", 1.0, 5), ("c", 2.0, 2))
    ]  # fmt: skip
    result = solved(
        structures=tuple(blocks), supports=(Support(on="a/bottom"),), loads=Loads(gravity=(0.5, 0.0, -G)),
        analysis=Statics(load_steps=1),
    )  # fmt: skip
    forces = told(result)
    for pair, above in ((("a", "b"), 2), (("b", "c"), 1)):
        k = between(result, *pair)
        assert forces.normal[k] == pytest.approx(above * GAMMA, rel=1e-6)
        x = forces.centre[k, 0] - 0.5
        assert x == pytest.approx(0.5 / G * above / 2, rel=1e-3)  # blocks are deformed
        assert forces.force[k, 0] == pytest.approx(-0.5 * above * STONE.density, rel=1e-6)


def test_cohesion_that_pulls_is_held():
    hanging = solved(
        dimension=2,
        fidelity="rigid",
        structures=(
            BlockStructure(name="roof", material="stone", size=(1.0, 0.2), position=(0.0, 0.5), support=True),
            BlockStructure(name="block", material="stone", size=(1.0, 0.5)),
        ),
        joints=(
            Joint(
                friction=0.5,
                law=law_record("elastic_brittle",
                    normal_stiffness=1e11, tangential_stiffness=1e11, normal_strength=1e6,
                    tangential_strength=1e6,
                ),
            ),
        ),
        analysis=Statics(load_steps=1),
    )  # fmt: skip
    forces = told(hanging)
    assert forces.status[0] == HELD
    assert forces.normal[0] == pytest.approx(-0.5 * GAMMA, rel=1e-6)
    assert np.isnan(forces.linear.pressure[0])
    assert np.isnan(forces.friction_used[0])


def test_what_carries_nothing_is_open():
    result = solved(
        dimension=2, fidelity="rigid",
        structures=(StackStructure(name="s", material="stone", size=(1.0, 1.0), count=2),),
        loads=Loads(gravity=(0.0, 0.0), points=(PointForce(block="s.b1", vector=(0.0, -1.0)),)),
        analysis=Statics(load_steps=1),
    )  # fmt: skip
    forces = told(result)
    assert sorted(forces.status) == [FREE, MIDDLE_THIRD]
    k = int(np.flatnonzero(forces.status == FREE)[0])
    assert np.isnan(forces.eccentricity[k]).all()
    assert np.isnan(forces.linear.pressure[k])


def test_blocks_that_touch_nothing_have_an_empty_table(tmp_path):
    scene = Scene(
        dimension=2, fidelity="rigid", materials={"stone": STONE},
        structures=(BlockStructure(name="block", material="stone", size=(1.0, 1.0)),),
        loads=Loads(gravity=(0.0, -G)), analysis=Dynamics(step=0.01, duration=0.02),
        output=Output(interfaces=True, pictures=False),
    )  # fmt: skip
    result = run(scene, tmp_path)
    assert "interfaces.csv" in [path.name for path in result.files]
    assert rows_of(tmp_path / "interfaces.csv") == []
    assert result.summary.joints is None


@pytest.mark.slow
def test_a_corner_that_stands_on_a_face_is_closed(tmp_path):
    floor = BlockStructure(
        name="floor", material="stone", size=(4.0, 0.2), position=(-2.0, -0.2), support=True
    )
    square = BlockStructure(name="square", material="stone", size=(1.0, 1.0), rotation=45.0)
    scene = Scene(
        dimension=2, fidelity="rigid", materials={"stone": STONE}, structures=(floor, square),
        loads=Loads(gravity=(0.0, -G)), analysis=Statics(load_steps=1), output=Output(interfaces=True),
    )  # fmt: skip
    run(scene, tmp_path)
    (row,) = rows_of(tmp_path / "interfaces.csv")
    assert row["status"] == "closed"
    assert float(row["area [m]"]) == 0.0
    assert float(row["normal_force [N/m]"]) == pytest.approx(GAMMA, rel=1e-9)
    assert row["linear_pressure [Pa]"] == row["kern [-]"] == ""


def test_table_has_a_line_a_joint_with_units_and_blanks(spread_arch: RunResult, tmp_path):
    model, state = spread_arch.march.model, spread_arch.march.state
    path = write_interfaces(tmp_path / "interfaces.csv", model, state, told(spread_arch))
    rows = rows_of(path)
    assert len(rows) == len(model.interfaces)
    assert [heading for heading in rows[0] if not heading.endswith("]")] == [
        "interface", "candidate", "antagonist", "label", "status", "edge", "slides", "low_side", "high_side"
    ]  # fmt: skip
    assert {row["status"] for row in rows} == {"middle third", "cracked", "hinge"}
    hinge = next(row for row in rows if row["status"] == "hinge")
    assert math.isinf(float(hinge["linear_pressure [Pa]"]))
    assert hinge["edge"] == "intrados"
    total = sum(float(r["force_y [N/m]"]) for r in rows if "springing" in r["antagonist"])
    assert total == pytest.approx(-spread_arch.summary.applied[1], rel=1e-6)


def test_face_in_parts_is_one_joint(tmp_path):
    """The fill of a bridge lies on each abutment in several facets of one plane, on the arch in one."""
    bridge = ArchBridgeStructure(
        name="b", material="stone", span=4.0, rise=1.0, thickness=0.4, voussoirs=9, cover=0.3,
    )  # fmt: skip
    result = solved(
        dimension=2, fidelity="rigid", structures=(bridge,), joints=(Joint(friction=0.6),),
        loads=Loads(gravity=(0.0, -G)), analysis=Statics(load_steps=1),
    )  # fmt: skip
    model, state, forces = result.march.model, result.march.state, told(result)
    parts = [np.flatnonzero(forces.faces.facets.joint == k) for k in range(len(forces.normal))]
    several = [k for k, rows in enumerate(parts) if len(rows) > 1]
    assert len(several) == 2
    assert sum(len(rows) for rows in parts) == len(model.interfaces)
    for k in several:
        own = np.isin(model.contacts.interface, parts[k])
        pressing, x = state.reaction[own, 0], state.points[own, 0]
        corners = np.concatenate([model.interfaces[row].polygon[:, 0] for row in parts[k]])
        assert np.ptp(corners) == pytest.approx(sum(model.interfaces[row].area for row in parts[k]))
        assert forces.faces.area[k] == pytest.approx(np.ptp(corners))
        e = pressing @ x / pressing.sum() - (corners.min() + corners.max()) / 2
        assert abs(forces.eccentricity[k, 0]) == pytest.approx(abs(e))
        assert forces.edge_share[k] == pytest.approx(2 * abs(e) / np.ptp(corners))
        assert forces.normal[k] == pytest.approx(pressing.sum())
        assert forces.tangential[k] == pytest.approx(abs(state.reaction[own, 1].sum()))
    columns = interface_columns(model, state, forces)
    assert {len(values) for values in columns.values()} == {len(parts)}
    counted = joint_summary(model, state)
    assert counted.open + counted.middle_third + counted.cracked + counted.hinge + counted.closed == len(
        parts
    )


def test_run_writes_what_was_asked_for(tmp_path):
    """The end of a run, with facts told from choices, and a series for ParaView; nothing unasked."""
    import pyvista as pv

    scene = Scene(
        dimension=3, fidelity="rigid", materials={"stone": STONE},
        structures=(StackStructure(name="s", material="stone", size=(1.0, 1.0, 0.5), count=2),),
        loads=Loads(gravity=(1.0, 0.0, -G)), analysis=Statics(load_steps=2),
        output=Output(interfaces=True, determinacy=True, pictures=False),
    )  # fmt: skip
    result = run(scene, tmp_path)
    assert {"interfaces.csv", "interfaces.pvd"} <= {path.name for path in result.files}
    row = rows_of(tmp_path / "interfaces.csv")[0]
    told = [row[f"{name}_determined"] for name in ("normal_force", "shear_force", "centre")]
    assert told == ["1", "1", "1"], "four corners choose, their resultant does not"
    last = sorted((tmp_path / "fields").glob("interfaces_*.vtu"))[-1]
    faces = pv.read(last)
    assert faces.n_cells == 2
    assert faces.cell_data["status"].tolist() == [MIDDLE_THIRD, MIDDLE_THIRD]
    assert faces.compute_cell_sizes().cell_data["Area"] == pytest.approx([1.0, 1.0])
    assert result.summary.joints.middle_third == 2
    plain = run(msgspec.structs.replace(scene, output=Output(pictures=False)), tmp_path / "plain")
    assert not list((tmp_path / "plain").rglob("interfaces*"))
    assert plain.summary.joints is None

"""A2.7: Hertz's cylinder and ball on a rigid plane, round faces as facets, against closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import (
    Contact,
    Joint,
    Loads,
    MeshSettings,
    Probe,
    Scene,
    Support,
    Traction,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.file import FileStructure
from tests.validation.discs import (
    RADIUS,
    ball_octant,
    foundation,
    half_discs,
    line_contact,
    point_contact,
)
from tests.validation.scenes import STONE


def pressed_cylinder(folder: Path, force: float, per_half_width: int = 12) -> RunResult:
    """The right half of a half disc on a rigid floor, pressed by a uniform pressure on its flat side."""
    half_width, _ = line_contact(force)
    fine = 1.6
    (folder / "disc.geo").write_text(half_discs(("disc",), half_width, per_half_width, fine, halves=(1,)))
    floor = BlockStructure(
        name="floor", material="stone", size=(0.3, 0.05), position=(-0.1, -0.05), support=True
    )
    scene = Scene(
        dimension=2,
        materials={"stone": STONE},
        structures=(FileStructure(name="c", material="stone", path="disc.geo", trusted=True), floor),
        mesh=MeshSettings(element="P1"),
        supports=(Support(on="c.disc/disc_cut", components=("x",)),),
        joints=(Joint(friction=0.0),),
        contact=Contact(reach=(fine * half_width) ** 2 / (2 * RADIUS)),
        loads=Loads(tractions=(Traction(on="c.disc/disc_flat", vector=(0.0, -force / 2 / RADIUS)),)),
    )
    return solve_scene(scene, folder)


@pytest.mark.parametrize(
    ("force", "half_width", "peak"), [(1e5, 1.105581e-3, 5.758236e7), (1e4, 3.496155e-4, 1.820914e7)]
)
def test_a2_7_cylinder(tmp_path: Path, force: float, half_width: float, peak: float) -> None:
    assert line_contact(force) == pytest.approx((half_width, peak), rel=1e-6)
    result = pressed_cylinder(tmp_path, force)
    assert result.outcome == "equilibrium"
    x, pressure, share = by_place(result)
    assert share.sum() == pytest.approx(force / 2, rel=1e-8)
    ellipse = peak * np.sqrt(np.maximum(0.0, 1 - (x / half_width) ** 2))
    inside = x < 0.95 * half_width
    assert inside.sum() >= 11
    assert np.abs(pressure - ellipse)[inside].max() < 0.03 * peak
    assert pressure[x < 0.3 * half_width].max() == pytest.approx(peak, rel=0.03)
    assert x[pressure > 1e-6 * peak].max() == pytest.approx(half_width, rel=0.1)  # to a mesh size


@pytest.mark.slow
@pytest.mark.parametrize("elements", [(30, 20), (20, 30)])
@pytest.mark.parametrize("ground", ["flat", "round"])
def test_a2_7_cylinder_on_another_mesh(tmp_path: Path, ground: str, elements: tuple[int, int]) -> None:
    """Half a cylinder on elastic stone, flat or as round, in facets 3:2: contact is on whole faces."""
    fine, flat = 1.6, ground == "flat"
    # both give way: half the stiffness; of two round faces also half the radius
    force, share = 1e5, 2.0 if flat else 1.0
    half_width, peak = line_contact(force * share)
    peak /= share
    names = ("disc",) if flat else ("disc", "ground")
    text = half_discs(names, half_width, elements[: len(names)], fine, halves=(1,))
    (tmp_path / "two.geo").write_text(text + foundation(half_width, elements[1], fine) * flat)
    base = "ground_base" if flat else "ground_flat"
    scene = Scene(
        dimension=2,
        materials={"stone": STONE},
        structures=(FileStructure(name="c", material="stone", path="two.geo", trusted=True),),
        mesh=MeshSettings(element="P1"),
        supports=(
            Support(on="c.disc/disc_cut", components=("x",)),
            Support(on="c.ground/ground_cut", components=("x",)),
            Support(on=f"c.ground/{base}", components=("y",)),
        ),
        joints=(Joint(friction=0.0),),
        contact=Contact(reach=(fine * half_width) ** 2 / RADIUS / share),
        loads=Loads(tractions=(Traction(on="c.disc/disc_flat", vector=(0.0, -force / 2 / RADIUS)),)),
    )
    result = solve_scene(scene, tmp_path)
    assert result.outcome == "equilibrium"
    assert result.built.model.contacts.means is not None
    x, pressure, total = by_place(result)
    assert total.sum() == pytest.approx(force / 2, rel=1e-8)
    ellipse = peak * np.sqrt(np.maximum(0.0, 1 - (x / half_width) ** 2))
    inside = x < 0.95 * half_width
    assert np.abs(pressure - ellipse)[inside].max() < 0.03 * peak
    assert x[pressure > 1e-6 * peak].max() == pytest.approx(half_width, rel=0.1)
    assert result.summary.solver.linear_solves <= 12


def by_place(result: RunResult) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes' places along the floor [m], their pressures [Pa] and forces [N].

    A node lies on two facets, and has a contact for each.
    """
    contacts, force = result.built.model.contacts, result.march.state.reaction[:, 0]
    x = np.abs(contacts.points[:, 0, 0])
    place, of = np.unique(np.round(x, 7), return_inverse=True)
    share = np.bincount(of, force)
    return place, share / np.bincount(of, contacts.area), share


@pytest.mark.slow
def test_a2_7_ball(tmp_path: Path) -> None:
    """An eighth of a ball under 1 kN, ten elements to the contact's radius."""
    force, radius, peak, approach = 1e3, 1.930979e-3, 1.280520e8, 3.728679e-5
    assert point_contact(force) == pytest.approx((radius, peak, approach), rel=1e-6)
    (tmp_path / "ball.geo").write_text(ball_octant(radius, 10))
    floor = BlockStructure(
        name="floor", material="stone", size=(0.3, 0.3, 0.05), position=(-0.1, -0.1, -0.05), support=True
    )
    scene = Scene(
        materials={"stone": STONE},
        structures=(FileStructure(name="c", material="stone", path="ball.geo", trusted=True), floor),
        mesh=MeshSettings(element="P1"),
        supports=(
            Support(on="c.ball/cut_x", components=("x",)),
            Support(on="c.ball/cut_y", components=("y",)),
        ),
        joints=(Joint(friction=0.0),),
        contact=Contact(reach=(1.3 * radius) ** 2 / (2 * RADIUS)),
        loads=Loads(
            tractions=(Traction(on="c.ball/ball_flat", vector=(0.0, 0.0, -force / (np.pi * RADIUS**2))),)
        ),
        probes=(Probe(name="far", block="c.ball", point=(0.0, 0.0, RADIUS)),),
    )
    result = solve_scene(scene, tmp_path)
    assert result.outcome == "equilibrium"
    contacts, normal = result.built.model.contacts, result.march.state.reaction[:, 0]
    away = np.linalg.norm(contacts.points[:, 0, :2], axis=1)
    assert 4 * normal.sum() == pytest.approx(force, rel=5e-3)  # the flat face is a polygon, too
    assert np.sqrt(2.5 * (normal * away**2).sum() / normal.sum()) == pytest.approx(radius, rel=0.03)
    for low, high in ((0.0, 0.3), (0.3, 0.6), (0.6, 0.9)):
        ring = (away >= low * radius) & (away < high * radius)
        hertz = peak * np.sqrt(1 - (away[ring] / radius) ** 2)
        mean = normal[ring].sum() / contacts.area[ring].sum()
        expected = (hertz * contacts.area[ring]).sum() / contacts.area[ring].sum()
        assert mean == pytest.approx(expected, abs=0.03 * peak)
    assert -result.summary.probes["far"][2] == pytest.approx(approach, rel=0.03)

"""A2.8: Cattaneo's and Mindlin's cylinders, pressed and then sheared, against the closed form.

Two equal half discs: round faces on both sides, and no coupling of pressure and shear. Facets coincide, or 3
of one disc face 2 of the other.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import (
    Contact,
    Joint,
    MeshSettings,
    Motion,
    Scene,
    Statics,
    Support,
    Table,
)
from masonry_fem.structures.file import FileStructure
from tests.validation.discs import RADIUS, half_discs, line_contact
from tests.validation.scenes import STONE

FRICTION = 0.4
PRESS, SHEAR = 1.0e-4, 3.2e-5  # how far the upper flat side goes down, then sideways [m]
STEPS = 8


class Tractions:
    """Forces [N/m], places, pressures and shears there [Pa], and whether they stick, after each step."""

    def __init__(self) -> None:
        self.steps: list[tuple[float, float, np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = []

    def record(self, model: Any, state: Any, report: Any) -> None:
        on_candidate = np.einsum("cij,ci->cj", state.frame, state.reaction)
        above = model.assembly.blocks[0].name == "c.upper"
        on_upper = on_candidate * np.where(model.contacts.blocks[:, :1] == (0 if above else 1), 1.0, -1.0)
        place, of = np.unique(np.round(model.contacts.points[:, 0, 0], 7), return_inverse=True)
        area = np.bincount(of, model.contacts.area)
        shear, normal = (np.bincount(of, on_upper[:, axis]) for axis in (0, 1))
        pressed, sheared = state.reaction[:, 0], np.abs(state.reaction[:, 1])
        sticks = (pressed > 0) & (sheared < FRICTION * pressed * (1 - 1e-6))
        held = np.bincount(of, sticks) > 0
        self.steps.append((-shear.sum(), normal.sum(), place, normal / area, -shear / area, held))


@pytest.fixture(
    scope="module",
    params=[
        (20, 20),
        pytest.param((30, 20), marks=pytest.mark.slow),
        pytest.param((20, 30), marks=pytest.mark.slow),
    ],
    ids="{0[0]}:{0[1]}".format,
)
def sheared(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Tractions:
    """Alike meshes, and 3:2 either way."""
    return tractions(tmp_path_factory.mktemp("discs"), request.param)


def tractions(folder: Path, elements: tuple[int, int]) -> Tractions:
    """Of discs with so many elements per half width of the contact on the upper and the lower one."""
    half_width, _ = line_contact(1.6e5)  # about what PRESS gives
    fine = 1.3
    (folder / "discs.geo").write_text(half_discs(("upper", "lower"), half_width, elements, fine))
    down = Table(points=((0.0, 0.0), (0.5, 1.0), (1.0, 1.0)))
    aside = Table(points=((0.0, 0.0), (0.5, 0.0), (1.0, 1.0)))
    scene = Scene(
        dimension=2,
        materials={"stone": STONE},
        structures=(FileStructure(name="c", material="stone", path="discs.geo", trusted=True),),
        mesh=MeshSettings(element="P1"),
        supports=(
            Support(on="c.lower/lower_flat"),
            Support(
                on="c.upper/upper_flat",
                components=("y",),
                motion=Motion(displacement=(0.0, -PRESS), time=down),
            ),
            Support(
                on="c.upper/upper_flat",
                components=("x",),
                motion=Motion(displacement=(SHEAR, 0.0), time=aside),
            ),
        ),
        joints=(Joint(friction=FRICTION),),
        contact=Contact(reach=(fine * half_width) ** 2 / RADIUS),
        analysis=Statics(load_steps=STEPS),
    )
    tape = Tractions()
    result = solve_scene(scene, folder, observers=(tape,))
    assert result.outcome == "equilibrium"
    assert (result.built.model.contacts.means is None) == (elements[0] == elements[1])
    return tape


def test_a2_8_pressing_alone_gives_hertz(sheared: Tractions, request: pytest.FixtureRequest) -> None:
    """Meshes that are mirror images rub nowhere; others do where the rim is in a step."""
    mirrored = "20:20" in request.node.name
    shear, force, place, pressure, tangential, _ = sheared.steps[STEPS // 2 - 1]
    half_width, peak = line_contact(force)
    assert abs(shear) < 1e-4 * force  # the two meshes are not quite mirror images
    assert np.abs(tangential).max() < (0.01 if mirrored else 0.02) * peak
    ellipse = peak * np.sqrt(np.maximum(0.0, 1 - (place / half_width) ** 2))
    inside = np.abs(place) < 0.95 * half_width
    assert np.abs(pressure - ellipse)[inside].max() < 0.03 * peak


@pytest.mark.slow
def test_a2_8_rubbing_alone_falls_with_the_size_of_elements(tmp_path: Path) -> None:
    """3:2, three times as fine: a third in root mean square, and less than 1 % of the peak at any point."""
    mean = []
    for elements in ((30, 20), (90, 60)):
        _, force, place, _, tangential, _ = tractions(tmp_path, elements).steps[STEPS // 2 - 1]
        half_width, peak = line_contact(force)
        rubbed = tangential[np.abs(place) < half_width] / peak
        mean.append(np.sqrt((rubbed**2).mean()))
    assert mean[1] < 0.4 * mean[0]
    assert np.abs(tangential).max() < 0.01 * peak


@pytest.mark.parametrize("step", range(STEPS // 2, STEPS))
def test_a2_8_stick_zone(sheared: Tractions, step: int) -> None:
    """Half width c of the part that sticks: c/a = √(1 − Q/μP); the shear is Mindlin's."""
    shear, force, place, _, tangential, held = sheared.steps[step]
    half_width, peak = line_contact(force)
    stick = np.sqrt(1 - shear / (FRICTION * force))
    spacing = np.diff(place).max() / half_width
    assert place[held].max() / half_width == pytest.approx(stick, abs=0.05 * stick + 0.5 * spacing)
    assert -place[held].min() / half_width == pytest.approx(stick, abs=0.05 * stick + 0.5 * spacing)
    inner = np.maximum(0.0, stick**2 - (place / half_width) ** 2)
    mindlin = FRICTION * peak * (np.sqrt(np.maximum(0.0, 1 - (place / half_width) ** 2)) - np.sqrt(inner))
    # at c the shear has a kink of infinite slope, which elements round off
    smooth = np.abs(np.abs(place) / half_width - stick) > 1.5 * spacing
    inside = (np.abs(place) < 0.95 * half_width) & smooth
    assert np.abs(tangential - mindlin)[inside].max() < 0.05 * FRICTION * peak
    middle = np.abs(place) < 0.2 * half_width
    # the mean over the middle tells c to a fraction of the mesh: q/μp₀ = 1 − c/a there
    told = stick - (tangential[middle] - mindlin[middle]).mean() / (FRICTION * peak)
    assert told == pytest.approx(stick, rel=0.05)


def test_a2_8_covers_a_quarter_to_a_half(sheared: Tractions) -> None:
    shares = [shear / (FRICTION * force) for shear, force, *_ in sheared.steps[STEPS // 2 :]]
    assert shares[0] < 0.25
    assert shares[-1] > 0.5

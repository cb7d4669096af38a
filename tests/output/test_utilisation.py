"""Utilisation: the envelope by hand, columns by Navier, rigid stones by balance, loads that grow."""

import csv

import numpy as np
import pytest

from masonry_fem.analyses.collapse import collapse
from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.build.strengths import strengths_of
from masonry_fem.errors import SceneError
from masonry_fem.output.mean_stress import contact_moments, mean_stress
from masonry_fem.output.strength import Strengths, shares, utilisation
from masonry_fem.output.terminal import print_summary
from masonry_fem.output.utilisation import stone_utilisation, worst_region
from masonry_fem.records.told import plain
from masonry_fem.scene import loads

FORCE, WIDTH, HEIGHT = 120e3, 0.6, 1.2  # of the column [N/m, m]
COLUMN = f"""
dimension = 2
fidelity = "elastic"
mesh = {{ element = "Q2", divisions = [12, 6] }}
overrides = [{{ blocks = "it.b2", fidelity = "rigid" }}]
joints = [{{ friction = 0.6 }}]
contact.update = "fixed"  # else the load goes along with the column that bends
output = {{ pictures = false, fields = false }}

[materials.stone]
density = 1e-3
young = "10 GPa"
poisson = 0.0
compressive_strength = "4 MPa"
tensile_strength = "0.2 MPa"

[[structures]]
kind = "stack"
name = "it"
material = "stone"
size = [{WIDTH}, {HEIGHT}]
count = 2

[[loads.points]]
block = "it.b2"
point = [0.36, {2 * HEIGHT}]
vector = [0.0, {-FORCE}]
"""
ECCENTRICITY = 0.06


def told_of(result, scene):
    strengths = strengths_of(scene, result.built.stones)
    return stone_utilisation(result.march.model, result.march.state, strengths)


@pytest.mark.parametrize(
    ("principal", "expected"),
    [
        ((0.0, 0.0, -4.0), 0.5),
        ((0.0, -4.0, -4.0), 0.5),  # lateral pressure adds nothing
        ((-2.0, -4.0, -6.0), 0.75),
        ((0.25, 0.0, 0.0), 0.5),
        ((0.25, 0.25, 0.0), 0.5),
        ((0.25, 0.0, -4.0), 1.0),  # the straight line between both
        ((0.1, 0.0, -1.6), 0.4),
    ],
)
def test_the_envelope_by_hand(principal, expected):
    """In any order, in proportion to the stress."""
    tension, compression = np.array(0.5), np.array(8.0)
    for order in ([0, 1, 2], [2, 0, 1]):
        stress = np.array(principal)[order]
        assert utilisation(stress, tension, compression) == pytest.approx(expected, rel=1e-14)
        assert utilisation(3 * stress, tension, compression) == pytest.approx(3 * expected, rel=1e-14)


def test_where_a_strength_is_unknown_stresses_of_its_sign_do_not_count():
    stress = np.array([[0.25, 0.0, -4.0]] * 3)
    used = utilisation(stress, np.array([0.5, np.nan, np.nan]), np.array([np.nan, 8.0, np.nan]))
    assert used[:2].tolist() == [0.5, 0.5]
    assert np.isnan(used[2])
    assert shares(stress, np.full(3, np.nan), np.full(3, 8.0)).tolist() == [[0.0, 0.5]] * 3


def test_no_region_of_that_volume_has_a_greater_mean():
    random = np.random.default_rng(1)
    used, weight, share = random.random((4, 50)), random.random(50) + 0.1, 0.13
    region = worst_region(used, weight, share)
    assert region.sum(axis=1) == pytest.approx(share * weight.sum(), rel=1e-12)
    assert (region >= 0).all()
    assert (region <= weight + 1e-15).all()
    best = (region * used).sum(axis=1)
    for _ in range(200):  # parts of points as large, at random
        other = weight * random.random(50)
        other *= share * weight.sum() / other.sum()
        if (other <= weight).all():
            assert ((other * used).sum(axis=1) <= best * (1 + 1e-12)).all()


def test_a_column_under_an_eccentric_load_is_navier():
    """ν = 0 between rigid plates: σ = N/B (1 + 12 e x/B²), which quadratic elements hold exactly."""
    scene = loads(COLUMN)
    result = solve_scene(scene)
    assert result.outcome == "equilibrium"
    told = told_of(result, scene)
    names = [block.name for block in result.march.model.assembly.blocks]
    b, mean, strength = names.index("it.b1"), FORCE / WIDTH, 4e6
    gauss = WIDTH / 2 - 0.5 * (WIDTH / 12) * (1 - np.sqrt(0.6))  # the outermost Gauss point
    assert told.of_mean[b] == pytest.approx(mean / strength, rel=1e-6)
    assert told.greatest[b] == pytest.approx(
        mean * (1 + 12 * ECCENTRICITY * gauss / WIDTH**2) / strength, rel=1e-6
    )
    middle = WIDTH / 2 - 0.025 * WIDTH  # of the strip with a twentieth of the volume
    local = mean * (1 + 12 * ECCENTRICITY * middle / WIDTH**2) / strength
    assert told.local[b] == pytest.approx(local, rel=5e-3)
    assert told.error[b] <= 1e-6 * told.local[b]  # nothing is left to estimate
    assert told.parts[b, 0] <= 1e-6
    summary = result.summary.utilisation
    assert summary.worst[0].block == "it.b1"
    assert summary.worst[0].governs == "compression"
    assert summary.load_factor == pytest.approx(1 / told.local[b], rel=1e-12)
    assert summary.rigid == 1
    assert (summary.unchecked, summary.over, summary.one_sided) == (0, 0, 0)


def test_of_a_rigid_stone_the_mean_stress_is_known():
    """The plate on the column: pressed by N at both faces, at the load's place and at the reaction's."""
    scene = loads(COLUMN)
    result = solve_scene(scene)
    stress, volume = mean_stress(result.march.model, result.march.state)
    names = [block.name for block in result.march.model.assembly.blocks]
    b = names.index("it.b2")
    assert volume[b] == pytest.approx(WIDTH * HEIGHT, rel=1e-12)
    # contacts act where they were at the start, and the column has become shorter by 2e-5 of its height
    assert stress[b, 1] == pytest.approx(-FORCE / WIDTH, rel=5e-5)
    assert np.abs(stress[b, [0, 3]]).max() <= 1e-4 * FORCE / WIDTH
    told = told_of(result, scene)
    assert np.isnan([told.local[b], told.greatest[b], told.error[b]]).all()
    assert told.ranking[b] == told.of_mean[b] == pytest.approx(FORCE / WIDTH / 4e6, rel=1e-4)


def test_a_rigid_stone_under_its_weight_is_pressed_by_half_of_it():
    heavy = COLUMN.partition("[[loads.points]]")[0].replace("density = 1e-3", "density = 2000.0")
    scene = loads(
        "loads.gravity = [0.0, -10.0]\n"
        + heavy.replace('"it.b2"', '"it.b1"').replace("count = 2", "count = 1"),
        ["fidelity='rigid'"],
    )
    result = solve_scene(scene)
    stress, _ = mean_stress(result.march.model, result.march.state)
    b = [block.name for block in result.march.model.assembly.blocks].index("it.b1")
    assert stress[b, 1] == pytest.approx(-2000.0 * 10.0 * HEIGHT / 2, rel=1e-9)


def test_forces_give_elastic_stones_the_mean_that_their_elements_have():
    """Signorini's mean stress against that of the Gauss points, to the strain that moves the points."""
    scene = loads(ARCH)
    result = solve_scene(scene)
    model, state = result.march.model, result.march.state
    stress, volume = mean_stress(model, state)
    given = contact_moments(model, state)
    free = np.flatnonzero(~np.isnan(volume))
    assert len(free) == 7
    for group, moved in zip(model.groups, state.bodies, strict=True):
        if group.prescribed:
            continue
        turn, shift = group.motion(moved)
        for row, b in enumerate(group.blocks):
            centre = turn[row] @ model.assembly.solid(int(b)).mass_properties().centroid + shift[row]
            total = given[b, :-1] - np.outer(centre, given[b, -1])
            mean = 0.5 * (total + total.T) / volume[b]
            own = stress[b][[0, 3, 3, 1]].reshape(2, 2)
            assert np.abs(mean - own).max() <= 1e-4 * np.abs(own).max()


ARCH = """
dimension = 2
fidelity = "elastic"
mesh = { element = "Q1", divisions = [3, 4] }
joints = [{ friction = 0.6 }]
loads.gravity = [0.0, -9.81]
output = { pictures = false }

[materials.stone]
density = 2400.0
young = "10 GPa"
compressive_strength = "1 MPa"
tensile_strength = "0.1 MPa"

[[structures]]
kind = "arch"
name = "arch"
material = "stone"
radius = 1.0
thickness = 0.25
voussoirs = 7
"""


def test_dry_joints_take_all_loads_in_proportion():
    """Twice all loads, twice the utilisation; half the strength, too."""
    once, twice, weaker = (
        solve_scene(loads(ARCH, changes)).summary
        for changes in ([], ["design.loads.gravity=2"], ["design.material_factor=2"])
    )
    for other in (twice, weaker):
        used, before = other.utilisation, once.utilisation
        assert used.worst[0].local == pytest.approx(2 * before.worst[0].local, rel=1e-4)
        assert used.load_factor == pytest.approx(0.5 * before.load_factor, rel=1e-4)
    assert (once.load_factors, twice.load_factors) == (None, {"gravity": 2.0})


def test_table_fields_and_console_say_the_same(tmp_path, capsys):
    result = run(loads(ARCH), tmp_path)
    worst = result.summary.utilisation.worst[0]
    with (tmp_path / "stones.csv").open(encoding="utf-8") as file:
        rows = {row["block"]: row for row in csv.DictReader(file)}
    assert len(rows) == 7
    assert float(rows[worst.block]["utilisation [-]"]) == pytest.approx(worst.local, rel=1e-12)
    assert float(rows[worst.block]["utilisation_error [-]"]) == pytest.approx(worst.error, rel=1e-12)
    assert max(rows.values(), key=lambda row: float(row["utilisation [-]"]))["block"] == worst.block
    (file,) = (tmp_path / "fields").glob("blocks_*.vtu")
    assert file.read_bytes().count(b'Name="utilisation"') == 2  # of points and of cells
    print_summary(plain(result.summary))
    printed = " ".join(capsys.readouterr().out.split())
    own = f"{worst.local:.2g} ± {worst.error:.1g} {worst.governs} ({worst.greatest:.2g}, {worst.of_mean:.2g})"
    assert f"{worst.block} {own}" in printed
    assert "strengths are divided by 1" in printed


def test_without_strengths_nothing_is_said(tmp_path):
    text = ARCH.replace('compressive_strength = "1 MPa"', "").replace('tensile_strength = "0.1 MPa"', "")
    result = run(loads(text), tmp_path / "none")
    assert result.summary.utilisation is None
    assert not (tmp_path / "none" / "stones.csv").exists()
    run(loads(text, ["output.stones=true"]), tmp_path / "asked")
    with (tmp_path / "asked" / "stones.csv").open(encoding="utf-8") as file:
        row = next(csv.DictReader(file))
    assert row["utilisation [-]"] == row["utilisation_of_mean [-]"] == row["governs"] == ""
    assert float(row["mean_sigma_3 [Pa]"]) < 0


def test_a_stone_that_has_yielded_uses_all_of_its_strength():
    """Its law has the strength; where it softened, the stress that is left says nothing."""
    scene = loads(
        """
        dimension = 2
        fidelity = "inelastic"
        mesh = { element = "Q1", divisions = [4, 2] }
        output = { pictures = false }
        design.material_factor = 1.5
        materials.stone = { density = 2000.0, young = "10 GPa", inelastic = { law = "brittle_damage", tensile_strength = "1 MPa", fracture_energy = 100 } }
        structures = [{ kind = "block", name = "bar", material = "stone", size = [1.0, 0.5] }]
        supports = [
          { on = "bar/left" },
          { on = "bar/right", components = ["x"], motion = { displacement = [1.4e-4, 0.0] } },
        ]
        analysis = { kind = "statics", load_steps = 4 }
        """  # noqa: E501
    )
    result = solve_scene(scene)
    assert result.summary.stress.yielded
    worst = result.summary.utilisation.worst[0]
    assert worst.governs == "yield"
    assert worst.greatest >= 1.5
    assert result.summary.utilisation.one_sided == 1


def test_a_strength_is_given_once():
    twice = """
    dimension = 2
    materials.stone = { density = 2000.0, young = "10 GPa", tensile_strength = "1 MPa", inelastic = { law = "brittle_damage", tensile_strength = "1 MPa", fracture_energy = 100 } }
    structures = [{ kind = "stack", name = "it", material = "stone", size = [1.0, 1.0], count = 1 }]
    """  # noqa: E501
    with pytest.raises(SceneError, match=r"tensile_strength is .* expected none beside .*inelastic"):
        loads(twice)


def test_stones_without_strengths_are_counted():
    strengths = Strengths(np.array([np.nan, 1.0]), np.array([np.nan, np.nan]))
    assert strengths.known.tolist() == [False, True]


def test_partial_factors_of_loads_are_never_hidden(capsys):
    """Without strengths, and in analyses that have no summary of their own for them."""
    bare = ARCH.replace('compressive_strength = "1 MPa"', "").replace('tensile_strength = "0.1 MPa"', "")
    scene = loads(bare, ["design.loads.gravity=1.35", "fidelity='rigid'"])
    print_summary(plain(solve_scene(scene).summary))
    assert "by partial factors gravity × 1.35" in " ".join(capsys.readouterr().out.split())
    note = "loads are multiplied by the partial factors of design.loads: gravity × 1.35"
    assert note in analyse(scene).notes
    assert note in collapse(scene, acceleration="x").summary.notes
    assert analyse(loads(bare, ["fidelity='rigid'"])).notes == ()


PLATE = """
dimension = 2
plane = "stress"
fidelity = "elastic"
materials.stone = { density = 2000.0, young = 1e10, compressive_strength = 8e6, tensile_strength = 1e6 }
structures = [{ kind = "block", name = "plate", material = "stone", size = [0.5, 0.3] }]
supports = [
  { on = "plate/left", components = ["x"] },
  { on = "plate/bottom", components = ["y"] },
]
loads.tractions = [{ on = "plate/right", vector = [3e5, 0.0] }, { on = "plate/top", vector = [0.0, -2e6] }]
"""


def test_a_plate_in_tension_and_pressure():
    """Uniform stress: all measures are ⟨σ1⟩/f_t + ⟨−σ3⟩/f_c, and nothing is uncertain."""
    scene = loads(PLATE)
    (stone,) = solve_scene(scene).summary.utilisation.worst
    expected = 0.3 + 2 / 8
    for measure in (stone.local, stone.p95, stone.greatest, stone.of_mean):
        assert measure == pytest.approx(expected, rel=1e-9)
    assert stone.error <= 1e-6


def test_a_cantilever_is_that_of_beam_theory():
    """Bending M y/I and parabolic shear; the worst twentieth lies at the edges beside the clamp."""
    length, depth, shear, strength = 1.2, 0.3, 1e5, 4e6
    scene = loads(
        f"""
        dimension = 2
        plane = "stress"
        fidelity = "elastic"
        mesh = {{ element = "Q2", divisions = [32, 8] }}
        materials.stone = {{ density = 2000.0, young = 1e10, poisson = 0.0, compressive_strength = {strength}, tensile_strength = {strength} }}
        structures = [{{ kind = "block", name = "beam", material = "stone", size = [{length}, {depth}] }}]
        supports = [{{ on = "beam/left" }}]
        loads.tractions = [{{ on = "beam/right", vector = [0.0, {-shear / depth}] }}]
        """  # noqa: E501
    )
    (stone,) = solve_scene(scene).summary.utilisation.worst
    x, y = np.meshgrid(
        (np.arange(960) + 0.5) * length / 960, (np.arange(240) + 0.5) * depth / 240 - depth / 2
    )
    bending = 12 * shear * (length - x) * y / depth**3
    tangential = 1.5 * shear / depth * (1 - (2 * y / depth) ** 2)
    radius = np.hypot(bending / 2, tangential)
    used = (np.maximum(bending / 2 + radius, 0) + np.maximum(radius - bending / 2, 0)) / strength
    expected = np.sort(used.ravel())[-used.size // 20 :].mean()
    assert stone.local == pytest.approx(expected, rel=0.02)
    assert abs(stone.local - expected) <= stone.error + 0.01 * expected
    assert stone.p95 == pytest.approx(np.quantile(used, 0.95), rel=0.02)
    # bending cancels, and the mean shear is left
    assert stone.of_mean == pytest.approx(2 * shear / depth / strength, rel=1e-9)

"""Reading scenes: what is taken, and one sentence for everything that is not."""

import logging
import shutil

import numpy as np
import pytest

from masonry_fem.errors import SceneError
from masonry_fem.scene import check, load, loads
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    Motion,
    Scene,
    Support,
    Tie,
    TiePoint,
    material_record,
)
from masonry_fem.structures import kinds
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure

KINDS = ", ".join(map(repr, kinds()))


def message(text: str, *overrides: str) -> str:
    with pytest.raises(SceneError) as caught:
        loads(text, overrides, source="arch.toml")
    return str(caught.value)


def test_a_scene_with_every_record_is_read_in_si_units(everything):
    scene = load(everything)
    assert scene.materials["limestone"].young == 10e9
    assert scene.materials["limestone"].damping.stiffness == 1e-3
    assert scene.mesh.size == 0.125
    assert scene.structures[1].brick == (0.5, 0.25)
    assert scene.structures[3].rotation == pytest.approx(np.degrees(0.01))
    assert scene.supports[1].motion.rotation == pytest.approx(np.radians(0.1))
    assert scene.supports[1].motion.time.points[1] == (10.0, 1.0)
    assert scene.loads.gravity == (0.0, -9.81)
    assert scene.loads.gravity_time.phase == pytest.approx(np.pi / 2)
    assert scene.loads.tractions[0].vector == (0.0, -1e5)
    assert scene.loads.lines[0].vector == (0.0, -3000.0)
    assert scene.initial[0].spin == pytest.approx(np.radians(1))
    assert scene.solver.time_limit == 120.0


# each case: what to replace in arch.toml by what, and the whole message
BAD = [
    ("young =", "yuong =", "line 4: unknown key 'yuong' in materials.stone; did you mean 'young'?"),
    ('"10 GPa"', "-3", "line 4: materials.stone.young is -3, expected a pressure > 0 in Pa"),
    ('"10 GPa"', "true", "line 4: materials.stone.young is true, expected a pressure > 0 in Pa"),
    ('"10 GPa"', "[1]", "line 4: materials.stone.young is [1], expected a pressure > 0 in Pa"),
    ('"10 GPa"', "inf", "line 4: materials.stone.young is inf, expected a pressure > 0 in Pa"),
    ('"10 GPa"', "nan", "line 4: materials.stone.young is nan, expected a pressure > 0 in Pa"),
    ('"10 GPa"', "'10 kg'", "line 4: materials.stone.young is '10 kg', expected a pressure > 0 in Pa"),
    ('"10 GPa"', "'soft'", "line 4: materials.stone.young is 'soft', expected a pressure > 0 in Pa"),
    (
        '"10 GPa"',
        "'10 Gpa'",
        "line 4: materials.stone.young is '10 Gpa', expected a pressure > 0 in Pa; "
        "'Gpa' is no known unit; did you mean 'GPa'?",
    ),
    (
        '"10 GPa"',
        "'10'",
        "line 4: materials.stone.young is '10', expected a pressure > 0 in Pa; "
        "give it a unit ('10 Pa') or write it without quotes",
    ),
    (
        'young = "10 GPa"',
        "young = 1e9\npoisson = 0.5",
        "line 5: materials.stone.poisson is 0.5, expected a number > -1 and < 0.5",
    ),
    (
        'kind = "arch"',
        'kind = "vall"',
        f"line 6: structures.arch.kind is 'vall', expected one of {KINDS}; did you mean 'wall'?",
    ),
    (
        'kind = "arch"\n',
        "",
        f"line 5: structures.arch lacks the key 'kind', one of {KINDS}",
    ),
    ("thickness = 0.5\n", "", "line 5: structures.arch lacks the key 'thickness' (a length > 0 in m)"),
    (
        "thickness = 0.5",
        "thickness = 11",
        "line 10: structures.arch.thickness is 11.0, expected less than twice the mean radius (10 m)",
    ),
    (
        "voussoirs = 11",
        "voussoirs = 11.5",
        "line 11: structures.arch.voussoirs is 11.5, expected a whole number >= 1",
    ),
    (
        "voussoirs = 11",
        "voussoirs = 0",
        "line 11: structures.arch.voussoirs is 0, expected a whole number >= 1",
    ),
    (
        "voussoirs = 11",
        "voussoirs = 1",
        "line 11: structures.arch.voussoirs is 1, "
        "expected more than 1, so that a stone spans less than half a circle",
    ),
    (
        'name = "arch"',
        'name = "my arch"',
        "line 7: structures.my arch.name is 'my arch', "
        "expected a name of letters, digits, _ and - that begins with a letter",
    ),
    (
        'material = "stone"',
        'material = "ston"',
        "line 8: structures.arch.material is 'ston', expected one of the materials 'stone'; "
        "did you mean 'stone'?",
    ),
    (
        '[0, "-9.81 m/s^2"]',
        "[0, 0, -9.81]",
        "line 13: loads.gravity is [0, 0, -9.81], "
        "expected a list of 2 (the scene's dimension), each an acceleration in m/s^2",
    ),
    (
        '[0, "-9.81 m/s^2"]',
        "[0,\n '-9.81 m']",
        "line 14: loads.gravity.1 is '-9.81 m', expected an acceleration in m/s^2",
    ),
    (
        '[0, "-9.81 m/s^2"]',
        "-9.81",
        "line 13: loads.gravity is -9.81, "
        "expected a list of 2 (the scene's dimension), each an acceleration in m/s^2",
    ),
    ("dimension = 2", "dimension = 4", "line 1: dimension is 4, expected one of 2, 3"),
    ("dimension = 2", "dimension = true", "line 1: dimension is true, expected one of 2, 3"),
    (
        "[[structures]]",
        "[structures]",
        "line 5: structures is a table, expected one or more tables ([[structures]])",
    ),
    (
        "[loads]",
        "[[loads]]",
        "line 12: loads is [a table], expected a table ([loads] with single brackets)",
    ),
    (
        "[materials.stone]",
        "[materials.stone.fine]",
        "line 2: unknown key 'fine' in materials.stone; known keys: 'density', 'young', 'poisson', "
        "'thermal_expansion', 'damping', 'orthotropic', 'compressive_strength', 'tensile_strength', "
        "'inelastic', 'promote_at', 'degree'",
    ),
    (
        "dimension = 2",
        "dimension = 2\nmesh = { element = 'q1' }",
        "line 2: mesh.element is 'q1', expected one of 'P1', 'P2', 'Q1', 'Q2'; did you mean 'Q1'?",
    ),
    (
        "dimension = 2",
        "dimension = 2\nmesh = { size = 0.1, divisions = [1, 1] }",
        "line 2: mesh.divisions is [1, 1], expected none beside 'size': take one of them",
    ),
    (
        "[loads]",
        "[[joints]]\nfriction = -0.2\n[loads]",
        "line 13: joints.0.friction is -0.2, expected a number >= 0, or 'no slip'",
    ),
    (
        "[loads]",
        "[[joints]]\nfriction = '30 deg'\n[loads]",
        "line 13: joints.0.friction is '30 deg', expected a number >= 0, or 'no slip'",
    ),
    (
        "[loads]",
        "[[supports]]\non = 'a/b/c'\n[loads]",
        "line 13: supports.0.on is 'a/b/c', expected a selector of blocks 'wall.*' or of faces 'wall.*/top'",
    ),
    (
        "[loads]",
        "[[supports]]\non = 'a'\ncomponents = ['x', 'z']\n[loads]",
        "line 14: supports.0.components is ['x', 'z'], expected only 'x' and 'y' in a 2D scene",
    ),
    (
        "[loads]",
        "[[supports]]\non = 'a'\nmotion.rotation = [0, 0, 1]\n[loads]",
        "line 14: supports.0.motion.rotation is [0.0, 0.0, 1.0], expected one number in rad in a 2D scene",
    ),
    (
        "[loads]",
        "[[supports]]\non = 'a'\nmotion.time = {kind='table', points=[[0, 0], [1, 1], [1, 2]]}\n[loads]",
        "line 14: supports.0.motion.time.points.2.0 is 1.0, expected a time after the one before (1 s)",
    ),
    (
        "[loads]",
        "[[probes]]\nname='a'\nblock='b'\npoint=[0,0]\n[[probes]]\nname='a'\nblock='b'\npoint=[0,0]\n[loads]",
        "line 17: probes.1.name is 'a', expected a name of its own (probes.0 has it)",
    ),
    (
        "[loads]",
        "[analysis]\nkind='dynamics'\nstep=1\nduration=0.1\n[loads]",
        "line 15: analysis.duration is 0.1, expected a time not shorter than the step (1 s)",
    ),
    (
        "[loads]",
        "[[loads.tractions]]\non = 'arch.v0'\nvector = [0, 1]\n[loads]",
        "line 13: loads.tractions.0.on is 'arch.v0', expected a selector of faces 'blocks/face'",
    ),
    (
        'young = "10 GPa"\n',
        "",
        "line 2: materials.stone lacks the key 'young' that the elastic blocks of "
        "structures.0 ('arch') need; give it (a pressure > 0 in Pa) or make them fidelity = 'rigid'",
    ),
    (
        "[loads]",
        "[analysis]\nkind='equilibrium'\nstrategy='large_step'\nstep=0.1\n[solver]\ntolerance=1e-5\n[loads]",
        "line 17: solver.tolerance is 1e-05, expected at most the tolerance of the equilibrium "
        "(analysis.tolerance = 1e-06); tighten it or loosen that",
    ),
    (
        "[loads]",
        "[solver]\nthreads = 2\n[loads]",
        "line 13: solver.threads is 2, expected none with solver.method = 'auto': only 'nsgs' has it; "
        "leave it out or choose that method",
    ),
    (
        "[loads]",
        "[solver]\nmethod = 'admm'\n[loads]",
        "line 13: solver.method is 'admm', expected one of 'auto', 'interior_point', 'newton', "
        "'nsgs'; 'admm' is gone, and 'auto' solves what it solved; write 'auto', or leave method out",
    ),
    (
        "[loads]",
        "[solver]\nmethod = 'nsgs'\nrelaxation = 2.0\n[loads]",
        "line 14: solver.relaxation is 2.0, expected a number > 0 and < 2",
    ),
    (
        "[loads]",
        "[loads",
        "not valid TOML: Expected ']' at the end of a table declaration (at line 12, column 7): '[loads'; "
        "correct it",
    ),
]


@pytest.mark.parametrize(("old", "new", "expected"), BAD, ids=[case[2][:60] for case in BAD])
def test_a_bad_scene_is_refused_with_place_value_expectation_and_cure(arch, old, new, expected):
    assert old in arch
    separator = ": " if expected.startswith("not valid") else ", "
    assert message(arch.replace(old, new, 1)) == f"arch.toml{separator}{expected}"


def test_a_key_that_a_scene_made_in_python_does_not_have_is_told_as_in_files():
    with pytest.raises(SceneError) as error:
        Scene(materials={}, structures=[], jonits=[{"friction": 0.5}])
    assert str(error.value) == "scene: unknown key 'jonits' in the scene; did you mean 'joints'?"
    with pytest.raises(SceneError) as error:
        Scene(joints=[{"friction": 0.5}])
    assert str(error.value) == "scene: the scene lacks the key 'materials' (a table)"
    with pytest.raises(TypeError):
        Scene({})


def test_a_missing_part_of_the_scene_is_named():
    assert message("") == "arch.toml: the scene lacks the key 'materials' (a table)"
    assert message("fidelty = 'rigid'") == (
        "arch.toml, line 1: unknown key 'fidelty' in the scene; did you mean 'fidelity'?"
    )


def test_braces_in_values_do_not_disturb_messages(arch):
    text = arch.replace('"stone"', '"{path}{0}"')
    assert "structures.arch.material is '{path}{0}'" in message(text)


def test_a_folder_is_not_proposed_for_a_file(everything, tmp_path):
    for name in ("quake.csv", "rubble.msh"):
        shutil.copy(everything.parent / name, tmp_path)
    (tmp_path / "quak.csv").mkdir()
    text = everything.read_text().replace("quake.csv", "quak.csv")
    with pytest.raises(SceneError, match=r"time.path is 'quak.csv', expected an existing file.*'quake.csv'"):
        loads(text, base=tmp_path)


def test_a_missing_file_is_named_with_what_lies_beside_it(everything):
    text = everything.read_text().replace("quake.csv", "quak.csv")
    with pytest.raises(SceneError, match=r"time.path is 'quak.csv', expected an existing file.*'quake.csv'"):
        loads(text, base=everything.parent)
    text = everything.read_text().replace("rubble.msh", "rubble.dwg")
    with pytest.raises(
        SceneError, match=r"structures.rubble.path is 'rubble.dwg', expected a file that ends"
    ):
        loads(text, base=everything.parent)


def test_a_scene_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(SceneError, match=r"nowhere.toml: no such scene file"):
        load(tmp_path / "nowhere.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match=r"binary.toml: cannot be read as UTF-8"):
        load(tmp_path / "binary.toml")


def test_a_byte_order_mark_is_no_error(arch, tmp_path):
    (tmp_path / "arch.toml").write_text(arch, encoding="utf-8-sig")
    assert load(tmp_path / "arch.toml") == loads(arch)


def python_scene(**changes) -> Scene:
    parts = {
        "dimension": 2,
        "materials": {"stone": Material(density="2400 kg/m^3", young="10 GPa")},
        "structures": (
            ArchStructure(name="arch", material="stone", radius=5.0, thickness=0.5, voussoirs=11),
        ),
        "loads": Loads(gravity=np.array([0.0, -9.81])),
    }
    return Scene(**{**parts, **changes})


def test_python_objects_are_checked_and_converted_like_files(arch):
    assert check(python_scene()) == loads(arch)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {"materials": {"stone": Material(density=-1.0, young=1e9)}},
            "scene: materials.stone.density is -1.0, expected a density > 0 in kg/m^3",
        ),
        (
            {
                "materials": {
                    "stone": Material(
                        density=2400.0,
                        young=1e9,
                        inelastic=material_record("mohr_coulomb", cohesion=0.0, friction_angle=30.0),
                    )
                }
            },
            "scene: materials.stone.inelastic.cohesion is 0.0, expected a pressure > 0 in Pa; take "
            "f_c (1 - sin φ)/(2 cos φ), that of stone of compressive strength f_c and friction_angle φ",
        ),
        (
            {"joints": (Joint(friction=np.float64(-2)),)},
            "scene: joints.0.friction is -2.0, expected a number >= 0, or 'no slip'",
        ),
        ({"structures": ()}, "scene: structures is [], expected one or more tables ([[structures]])"),
        (
            {"ties": (Tie(name="bar", points=(TiePoint(block="b"),), young=190e9, diameter=0.03),)},
            "scene: ties.bar.points is [a table], expected 2 or more tables ([[ties.0.points]])",
        ),
        ({"fidelity": "elastik"}, "scene: fidelity is 'elastik', expected one of 'auto', 'elastic', "
                                  "'inelastic', 'reduced', 'rigid'; did you mean 'elastic'?"),
        (
            {"supports": (Support(on="x", motion=Motion(rotation=(0.0, 0.0, 1.0))),)},
            "scene: supports.0.motion.rotation is [0.0, 0.0, 1.0], expected one number in rad in a 2D scene",
        ),
        (
            {"structures": (BlockStructure(name="b", material="stone", size=(1, 1), axis=(0, 0, 1)),)},
            "scene: structures.b.axis is [0.0, 0.0, 1.0], "
            "expected no axis in a 2D scene (rotation is about z)",
        ),
    ],
)  # fmt: skip
def test_python_objects_get_the_same_messages(changes, expected):
    with pytest.raises(SceneError) as caught:
        check(python_scene(**changes))
    assert str(caught.value) == expected


@pytest.mark.parametrize(
    ("old", "new", "doubt"),
    [
        ("[loads]", "[contact]\n#", "nothing acts on the blocks"),
        ("voussoirs = 11", "voussoirs = 11\nspringings = false", "nothing holds the blocks"),
        ("[loads]", "[[joints]]\nfriction = 0.3\ndynamic_friction = 0.5\n[loads]", "exceeds the static 0.3"),
        ("[loads]", "[[joints]]\nrestitution = 0.5\n[loads]", "acts in the velocity form only"),
        ("[loads]", "[[joints]]\ndensity = 3\n[loads]", "belongs to placement 'gauss'"),
        ('"10 GPa"', "10_000.0", "materials.stone.young is 10000 Pa, masonry has 1e+06 to 1e+12"),
        ('"2400 kg/m^3"', "2.4", "materials.stone.density is 2.4 kg/m^3, masonry has 200 to 12000"),
        ("[loads]", "[[initial]]\nblocks = 'a'\n[loads]", "has no effect"),
        (
            "[loads]",
            "[[joints]]\nlaw = {kind = 'mohr_coulomb', cohesion = 1e5, residual_friction = 0.9}\n[loads]",
            "joints.0.law.residual_friction 0.9 exceeds the friction 0.6",
        ),
        (
            "[loads]",
            "[[stages]]\nname = 'hung'\n[[stages.loads.accelerations]]\nvector = [1.0, 0.0]\n[loads]",
            "nothing weighs any more in stage 'hung'",
        ),
    ],
)
def test_what_is_seldom_meant_is_a_warning(arch, caplog, old, new, doubt):
    with caplog.at_level(logging.WARNING, logger="masonry_fem"):
        check(loads(arch))
        assert not caplog.records
        check(loads(arch.replace(old, new).replace("#\ngravity", "#gravity")))
    assert doubt in caplog.text


def test_the_demos_are_sound_scenes(repository, caplog):
    files = sorted((repository / "demos").glob("*.toml"))
    assert files
    for file in files:
        scene = load(file)
        assert check(scene, base=file.parent) == scene
    assert not caplog.records


def test_a_folder_is_no_scene(tmp_path):
    with pytest.raises(SceneError, match="is a folder; expected a TOML file"):
        load(tmp_path)

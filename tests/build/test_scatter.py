"""Properties that scatter, from the scene to the laws and the output."""

import logging
from pathlib import Path

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.output.fields import contact_arrays
from masonry_fem.scene import check, loads, save, specs
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

MOHR = specs.law_record("mohr_coulomb", cohesion=0.3e6, residual_friction=0.5)
SPRINGS = specs.law_record("bilinear",
    normal_stiffness=8e10, tangential_stiffness=4e10, normal_strength=0.25e6, tangential_strength=0.35e6,
    normal_energy=18.0, tangential_energy=125.0,
)  # fmt: skip


def wall(joint, *, columns=10, courses=12, dimension=2):
    brick = (0.2, 0.1) if dimension == 2 else (0.2, 0.1, 0.1)
    structure = WallStructure(name="w", material="m", brick=brick, columns=columns, courses=courses)
    return specs.Scene(
        dimension=dimension, fidelity="rigid", materials={"m": specs.Material(density=2000.0)},
        structures=(structure,), joints=(joint,),
        loads=specs.Loads(gravity=(0.0,) * (dimension - 1) + (-9.81,)),
    )  # fmt: skip


def model_of(joint, **keys):
    return build(check(wall(joint, **keys)), Path()).model


def joint_of(law=MOHR, **keys):
    variation = keys.pop("variation", {"cohesion": 0.2})
    rest = {
        name: keys.pop(name)
        for name in ("friction", "mortar", "dilatancy", "dynamic_friction")
        if name in keys
    }
    return specs.Joint(law=law, scatter=specs.Scatter(seed=5, variation=variation, **keys), **rest)


def each(model, values):
    """One value an interface; they must be the same at all its points."""
    first = np.array([values[model.contacts.interface == i][0] for i in range(len(model.interfaces))])
    np.testing.assert_array_equal(values, first[model.contacts.interface])
    return first


@pytest.mark.parametrize("distribution", ["lognormal", "truncated_normal", "weibull"])
def test_each_interface_draws_a_value(distribution):
    model = model_of(joint_of(distribution=distribution), columns=16, courses=20)
    ((law, points),) = model.laws.parts
    np.testing.assert_array_equal(points, np.arange(model.contacts.count))
    drawn = each(model, law.cohesion) / 0.3e6
    assert drawn.mean() == pytest.approx(1.0, abs=3 * 0.2 / np.sqrt(len(drawn)))
    assert drawn.std() == pytest.approx(0.2, rel=0.1)
    assert law.friction == 0.6


def test_the_same_seed_gives_the_same_wall():
    one, again = (model_of(joint_of()).scatter["cohesion"] for _ in range(2))
    np.testing.assert_array_equal(one, again)
    other = msgspec.structs.replace(joint_of(), scatter=specs.Scatter(seed=6, variation={"cohesion": 0.2}))
    assert (model_of(other).scatter["cohesion"] != one).all()


def test_neighbours_are_alike_within_the_correlation_length():
    model = model_of(joint_of(correlation_length=0.6), columns=20, courses=20)
    values = np.log(each(model, model.scatter["cohesion"]))
    middle = np.array([one.polygon.mean(axis=0) for one in model.interfaces])
    apart = np.linalg.norm(middle[:, None] - middle[None], axis=2)
    product = np.multiply.outer(values - values.mean(), values - values.mean()) / values.var()
    assert product[(apart > 0) & (apart < 0.15)].mean() > 0.8
    assert abs(product[apart > 1.5].mean()) < 0.3


def test_friction_takes_all_its_kin_along():
    joint = joint_of(variation={"friction": 0.3, "cohesion": 0.1}, friction=0.7,
                     dilatancy=specs.Dilatancy(tangent=0.45, bound=1e-3))  # fmt: skip
    model = model_of(joint)
    ((rough, _),) = model.laws.parts
    factor = model.scatter["friction"]
    np.testing.assert_allclose(rough.law.friction, 0.7 * factor)
    np.testing.assert_allclose(rough.law.residual_friction, 0.5 * factor)
    np.testing.assert_allclose(rough.dilatancy, 0.45 * np.minimum(factor, 1.0))
    assert rough.bound == 1e-3
    weak = model.scatter["cohesion"] < 1
    np.testing.assert_array_equal(weak & (factor < 0.9), factor < 0.9)  # one field for all


def test_dry_joints_rub_by_the_place():
    model = model_of(joint_of(None, variation={"friction": 0.1}, dynamic_friction=0.5))
    ((law, _),) = model.laws.parts
    factor = each(model, model.scatter["friction"])
    assert factor.std() == pytest.approx(0.1, rel=0.2)
    np.testing.assert_allclose(each(model, law.friction), 0.6 * factor)
    np.testing.assert_allclose(each(model, law.dynamic_friction), 0.5 * factor)


@pytest.mark.parametrize("mortar", [
    specs.Mortar(thickness=0.01, young=1e9, crushing=5e6),
    specs.Mortar(normal_stiffness=1e11, tangential_stiffness=4e10, crushing=5e6),
])  # fmt: skip
def test_mortar_scatters(mortar):
    name = "young" if mortar.young else "normal_stiffness"
    model = model_of(joint_of(mortar=mortar, variation={f"mortar.{name}": 0.3, "mortar.crushing": 0.1}))
    ((bed, _),) = model.laws.parts
    mean = 1e9 * 0.8 / (1.2 * 0.6) / 0.01 if mortar.young else 1e11
    np.testing.assert_allclose(bed.normal_stiffness, mean * model.scatter[f"mortar.{name}"])
    np.testing.assert_allclose(bed.crushing, 5e6 * model.scatter["mortar.crushing"])
    assert bed.law.cohesion == 0.3e6


def test_energies_stay_above_what_springs_store(caplog):
    """Ten times the elastic energy never is too little at a variation of 0.2; 1.2 times often is."""
    with caplog.at_level(logging.WARNING):
        model_of(joint_of(SPRINGS, variation={"normal_strength": 0.2, "normal_energy": 0.4}))
    assert not caplog.records
    brittle = msgspec.structs.replace(SPRINGS, normal_energy=1.2 * 0.25e6**2 / 16e10)
    model = model_of(joint_of(brittle, variation={"normal_strength": 0.3}))
    assert "drew a normal_energy below what their springs store" in caplog.text
    ((law, _),) = model.laws.parts
    ratio = law.normal_energy / (law.normal_strength**2 / 16e10)
    assert ratio.min() == pytest.approx(1.05)
    enough = ratio > 1.06
    np.testing.assert_allclose(law.normal_energy[enough], brittle.normal_energy)
    wrong = msgspec.structs.replace(SPRINGS, normal_energy=0.1)
    with pytest.raises(SceneError, match=r"joints\.0\.law: .*normal_energy is 0\.1 J/m²"):
        model_of(joint_of(wrong, variation={"normal_strength": 0.2}))


def test_two_records_keep_their_own_scatter():
    heads = specs.Joint(interface="head", law=SPRINGS,
                        scatter=specs.Scatter(seed=1, variation={"normal_strength": 0.2}))  # fmt: skip
    scene = msgspec.structs.replace(wall(joint_of()), joints=(joint_of(), heads))
    model = build(check(scene), Path()).model
    is_head = np.array([one.label == "head" for one in model.interfaces])[model.contacts.interface]
    assert (model.scatter["cohesion"][is_head] == 1).all()
    assert (model.scatter["cohesion"][~is_head] != 1).all()
    assert (model.scatter["normal_strength"][~is_head] == 1).all()
    laws = {law.name: (law, points) for law, points in model.laws.parts}
    law, points = laws["bilinear"]
    np.testing.assert_allclose(law.normal_strength, 0.25e6 * model.scatter["normal_strength"][points])


def test_a_law_of_the_users_scatters(tmp_path):
    (tmp_path / "cork.py").write_text(
        "from masonry_fem.joints import MohrCoulomb\nclass Cork(MohrCoulomb):\n    name = 'cork'\n"
    )
    law = specs.PythonLaw(file="cork.py", law="Cork", trusted=True, parameters={"cohesion": 1e5})
    scene = check(wall(joint_of(law)), base=tmp_path)
    ((made, _),) = build(scene, tmp_path).model.laws.parts
    assert made.cohesion.std() / 1e5 == pytest.approx(0.2, rel=0.2)


def test_weakest_joint_of_a_chain():
    """Three blocks glued in a row, pulled: stands just below the weakest draw, falls just above."""

    def pulled(stress):
        stack = StackStructure(name="s", material="m", size=(1.0, 1.0), count=3)
        law = specs.law_record("constant_threshold", strength=1e5)
        scene = specs.Scene(
            dimension=2, fidelity="rigid", materials={"m": specs.Material(density=2000.0)},
            structures=(stack,), joints=(joint_of(law, variation={"strength": 0.3}),),
            loads=specs.Loads(tractions=(specs.Traction(on="s.b3/top", vector=(0.0, stress)),)),
        )  # fmt: skip
        return solve_scene(check(scene))

    result = pulled(1.0)
    drawn = 1e5 * result.built.model.scatter["strength"]
    assert len(np.unique(drawn)) == 3
    assert pulled(0.98 * drawn.min()).outcome == "equilibrium"
    assert pulled(1.02 * drawn.min()).outcome == "no_equilibrium"
    arrays = contact_arrays(result.built.model, result.march.state)
    np.testing.assert_array_equal(arrays["scatter_strength"] * 1e5, drawn)
    told = result.summary.scatter
    assert told.seeds == (5,)
    assert told.factors["strength"] == (drawn.min() / 1e5, drawn.max() / 1e5)


def test_written_and_read(tmp_path):
    scene = check(wall(joint_of(mortar=specs.Mortar(thickness=0.01, young=1e9),
                                variation={"cohesion": 0.2, "mortar.young": 0.1})))  # fmt: skip
    save(scene, tmp_path / "s.toml")
    assert loads((tmp_path / "s.toml").read_text()) == scene


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"variation": {"cohesoin": 0.2}}, r"variation names 'cohesoin'.*did you mean 'cohesion'"),
        ({"variation": {"tensile_strength": 0.2}}, r"names 'tensile_strength', expected numbers that"),
        ({"variation": {"mortar.young": 0.2}}, r"names 'mortar\.young'"),
        ({"variation": {"cohesion": 0.0}}, r"cohesion is 0\.0, expected a number > 0 and < 2"),
        ({"distribution": "truncated_normal", "variation": {"cohesion": 0.7}}, r"at most 0\.5 with"),
        ({"distribution": "gauss"}, r"distribution is 'gauss', expected one of"),
        ({"variation": {"3": 0.1}}, r"expected the name of a parameter"),
    ],
)  # fmt: skip
def test_what_cannot_scatter(keys, words):
    with pytest.raises(SceneError, match=words):
        check(wall(joint_of(**keys)))

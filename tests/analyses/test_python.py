"""From Python: scenes of dicts and lists, callbacks, pictures, notebooks and pickles."""

import pickle
import re

import numpy as np
import pytest

import masonry_fem as mf
from masonry_fem.errors import MasonryError, OutputError, SceneError
from masonry_fem.joints import kinds
from masonry_fem.output.notebook import summary_html
from masonry_fem.output.render import can_render
from masonry_fem.scene import of_records
from masonry_fem.scene.specs import Joint, Material

JOINTS = [{"friction": 0.5, "law": {"kind": "mohr_coulomb", "cohesion": "0.1 MPa"}}]


def stack(**changes):
    given = {
        "title": "Säule <1>",
        "dimension": 2,
        "fidelity": "rigid",
        "materials": {"stone": {"density": "2400 kg/m^3"}},
        "structures": [{"kind": "stack", "name": "s", "material": "stone", "size": [1, "50 cm"], "count": 2}],
        "loads": {"gravity": [0, -9.81]},
    }
    return mf.Scene(**given | changes)


def test_a_scene_of_dicts_is_the_scene_of_a_file(tmp_path):
    scene = stack(joints=[{"friction": 0.5}])
    mf.save(mf.check(scene), tmp_path / "stack.toml")
    assert mf.load(tmp_path / "stack.toml") == mf.check(scene) == of_records(scene)
    assert mf.solve(scene).outcome == "equilibrium"


@pytest.mark.parametrize(
    "changes",
    [
        {"output": {"pictures": False}},
        {"materials": {"stone": {"density": 2400}}},
        {"joints": (Joint(), {"friction": 0.4})},
        {"loads": {}},
    ],
    ids=lambda value: next(iter(value)),
)
def test_a_dict_anywhere_is_seen(changes):
    records = of_records(stack())
    assert of_records(records) is records
    given = {key: getattr(records, key) for key in records.__struct_fields__}
    mixed = mf.Scene(**given | changes)
    assert of_records(mixed) is not mixed
    assert of_records(of_records(mixed)) is of_records(mixed) or of_records(mixed) == mf.check(mixed)


def test_what_is_wrong_in_a_dict_is_told():
    with pytest.raises(SceneError, match=r"densty.*density"):
        mf.solve(stack(materials={"stone": {"densty": 2400}}))
    with pytest.raises(SceneError, match="expected a Scene"):
        mf.solve({"dimension": 2})


def test_callbacks_see_every_step(tmp_path):
    falling = stack(analysis={"kind": "dynamics", "duration": 0.05, "step": 0.01}, output={"pictures": False})
    seen, shapes = [], set()

    def see(model, state, report):
        seen.append(report.time)
        shapes.add(state.reaction.shape == (model.contacts.count, 2))

    mf.solve(falling, observers=[see])
    assert seen == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05])
    seen.clear()
    mf.run(falling, tmp_path, observers=[see])
    assert len(seen) == 5
    assert shapes == {True}
    with pytest.raises(MasonryError, match="a function of model, state and report"):
        mf.solve(falling, observers=[3])


def test_stages_tell_their_steps_too(tmp_path):
    seen = []
    staged = stack(stages=[{"name": "one"}, {"name": "two"}], output={"pictures": False})
    mf.run(staged, tmp_path, observers=[lambda model, state, report: seen.append(report.time)])
    assert len(seen) == 2


def test_results_are_pickled_with_their_model():
    result = mf.solve(stack(joints=JOINTS))
    again = pickle.loads(pickle.dumps(result))
    assert again.outcome == result.outcome
    assert np.array_equal(again.march.state.reaction, result.march.state.reaction)
    assert again.scene == result.scene
    assert again.built.model.loads[0].factor(0.5) == 0.5


def test_records_of_laws_are_pickled():
    record = kinds()["mohr_coulomb"].record(cohesion=1e5)
    assert pickle.loads(pickle.dumps(record)) == record
    stone = Material(density=2400.0, young=1e10, inelastic=None)
    assert pickle.loads(pickle.dumps(stone)) == stone
    brittle = {"law": "brittle_damage", "tensile_strength": "1 MPa", "fracture_energy": 50}
    stone = {"density": 2400, "young": "10 GPa", "inelastic": brittle}
    law = mf.check(stack(fidelity="inelastic", materials={"stone": stone}))
    assert pickle.loads(pickle.dumps(law)) == law


def test_a_notebook_shows_what_the_console_does():
    result = mf.solve(stack())
    page = result._repr_html_()
    assert page.startswith("<div>")
    for words in ("equilibrium", "Säule &lt;1&gt;", "natural map", "support"):
        assert words in page
    assert page.index("forces") < page.index("certificate")
    assert len(re.findall("<tr>", page)) == len(re.findall("</tr>", page)) > 8
    assert "no equilibrium" in summary_html({"outcome": "no_equilibrium", "message": "<b>"})
    assert "&lt;b&gt;" in summary_html({"outcome": "no_equilibrium", "message": "<b>"})
    assert "kind = &quot;stack&quot;" in mf.check(stack())._repr_html_()


@pytest.mark.skipif(not can_render(), reason="nothing to draw with")
def test_a_picture_is_shown_and_saved(tmp_path):
    result = mf.solve(stack())
    picture = result.plot("reactions")
    assert picture._repr_png_().startswith(b"\x89PNG")
    assert picture.save(tmp_path / "stack.png").read_bytes() == picture.png
    assert result.plot().name == "deformed"
    with pytest.raises(OutputError, match=r"'von_mises' cannot be drawn.*'reactions'"):
        result.plot("von_mises")


@pytest.mark.skipif(not can_render(), reason="nothing to draw with")
def test_a_mechanism_is_drawn():
    pushed = mf.solve(stack(loads={"gravity": [0, -9.81], "accelerations": [{"vector": [9, 0]}]}))
    assert pushed.outcome == "no_equilibrium"
    assert len(pushed.plot("mechanism").png) > 5000

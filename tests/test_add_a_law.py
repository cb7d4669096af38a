"""docs/add_a_law.md followed literally: its blocks become files, which run and give what it says."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from masonry_fem.build.laws import law_of_file
from masonry_fem.cli import main
from masonry_fem.joints import Rough, probe
from masonry_fem.scene import load
from tests.joints import test_all_laws as owed
from tests.joints.samples import wander

S, C, G = 0.25e6, 82e9, 18.0
FILES = ("convex.py", "look.py", "convex.toml", "polished.py", "polished.toml", "trust.py")


@pytest.fixture(scope="module")
def folder(repository, tmp_path_factory):
    """Where a reader of the page has copied its blocks."""
    text = (repository / "docs/add_a_law.md").read_text(encoding="utf-8")
    blocks = dict(re.findall(r"`([\w.]+)`:\n\n```(?:python|toml)\n(.*?)```", text, re.S))
    assert set(blocks) == set(FILES)
    folder = tmp_path_factory.mktemp("laws")
    for name, block in blocks.items():
        (folder / name).write_text(block, encoding="utf-8")
    return folder


def law(folder, name):
    """The law of a scene of the page."""
    scene = load(folder / f"{name}.toml")
    joint = next(one for one in scene.joints if one.law is not None)
    return law_of_file(joint.law, joint.friction, folder, "law")


def summary(folder, name, out):
    assert main(["run", str(folder / f"{name}.toml"), "--out", str(out)]) == 0
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("script", [pytest.param("look", marks=pytest.mark.slow), "trust"])
def test_a_script_prints_what_the_page_shows(folder, repository, script):
    env = {**os.environ, "PYTHONPATH": str(repository)}
    done = subprocess.run(
        [sys.executable, f"{script}.py"], cwd=folder, env=env, capture_output=True, text=True, check=True
    )
    page = (repository / "docs/add_a_law.md").read_text(encoding="utf-8")
    assert done.stdout == re.search(rf"`python {script}.py` prints\n\n```text\n(.*?)```", page, re.S)[1]


@pytest.mark.slow  # the script that draws it is
def test_picture_of_the_page_is_drawn(folder, repository):
    assert (folder / "convex.png").stat().st_size > 10_000
    assert 10_000 < (repository / "docs/images/laws/convex.png").stat().st_size < 60_000


def test_convex_joint_is_pulled_open(folder, tmp_path):
    found = summary(folder, "convex", tmp_path)
    assert found["outcome"] == "equilibrium"
    opening, critical = found["probes"]["mid"][2], S / C
    end = 3 * (G / S - critical / 2)
    stress = S * (1 - (opening - critical) / end) ** 2
    assert found["supports"]["low"]["force"][2] == pytest.approx(-0.04 * stress, rel=1e-6)
    assert round(0.04 * stress / 1e3, 2) == 6.81
    assert opening == pytest.approx(40e-6 - stress / 1e15, abs=1e-12)
    beta = stress / (C * opening)
    lost = G - end * S / 3 * (1 - (opening - critical) / end) ** 3 - 0.5 * beta * C * opening**2
    assert found["energy"]["joint_dissipation"] == pytest.approx(0.04 * lost, rel=1e-6)


def test_polished_joint_slides(folder, tmp_path):
    found = summary(folder, "polished", tmp_path)
    assert found["outcome"] == "equilibrium"
    assert found["supports"]["stop"]["force"][0] == pytest.approx(-4246.25, abs=1e-2)
    assert found["supports"]["stop"]["force"][0] == pytest.approx(-1e4 * (0.4 + 0.3 * np.exp(-2.5)), rel=1e-8)
    assert found["energy"]["joint_dissipation"] == 0.0


def test_convex_curve_of_each_mode(folder):
    """Quarter, half and three quarters of the way down; the areas are the energies."""
    convex = law(folder, "convex")
    for axis, (strength, stiffness, energy) in enumerate(((S, C, G), (0.35e6, 36e9, 125.0))):
        critical = strength / stiffness
        end = 3 * (energy / strength - critical / 2)
        path = np.zeros((4, 2))
        path[:, axis] = critical + np.array([0.25, 0.5, 0.75, 1.01]) * end
        history = probe(convex, path, pressure=None if axis == 0 else 0.0)
        left = np.array([0.75, 0.5, 0.25, 0.0])
        assert history.stress[:, axis] == pytest.approx(strength * left**2, rel=1e-9, abs=1e-6)
        assert history.dissipated[-1] == pytest.approx(energy, rel=1e-12)
        assert history.state.broken.all()


def test_polishing_heat_converges_to_the_integral(folder):
    polished = law(folder, "polished")
    exact = 1e6 * (0.4 * 0.05 + 0.3 * 0.02 * (1 - np.exp(-2.5)))
    errors = []
    for steps in (50, 100, 200):
        slide = np.linspace(0.0, 0.05, steps + 1)[1:]
        history = probe(polished, np.stack([0 * slide, slide], axis=1), pressure=1e6)
        errors.append(abs(history.rubbed[-1] / exact - 1))
        assert history.adhesion == pytest.approx(np.exp(-slide / 0.02), rel=1e-12)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.05)
    assert errors[2] < 2e-3


@pytest.mark.parametrize("name", ["convex", "polished"])
def test_reversed_slide_wears_on(folder, name):
    """Rough faces of the reader's law: what the package wraps takes it as any."""
    rough = Rough(law(folder, name), dilatancy=0.2, bound=1e-4)
    slide = np.concatenate([np.linspace(0, 1e-4, 50), np.linspace(1e-4, -1e-4, 100)])
    history = probe(rough, np.stack([0 * slide, slide], axis=1), pressure=1e5)
    assert history.settled.all()
    assert (np.diff(history.adhesion) <= 0).all()
    assert (np.diff(history.rubbed) >= -1e-12).all()


PROPERTIES = [
    owed.test_losses_never_shrink_and_adhesion_never_heals, owed.test_energy_is_not_created,
    owed.test_objective_in_the_tangent_plane, owed.test_plane_is_space_with_one_direction,
    owed.test_no_tension_after_rupture, owed.test_finer_steps_converge,
]  # fmt: skip


@pytest.mark.parametrize("name", ["convex", "polished"])
@pytest.mark.parametrize("owes", PROPERTIES, ids=lambda one: one.__name__)
@seed(1)
@settings(max_examples=3)
@given(data=st.data())
def test_it_owes_what_every_law_owes(folder, name, owes, data):
    """The properties of tests/joints/test_all_laws.py, asked of the page's laws."""
    drawn = {
        "seed": st.integers(0, 2**32 - 1), "dimension": st.sampled_from([2, 3]), "pressed": st.booleans(),
        "angle": st.floats(0, 6.0),
    }  # fmt: skip
    inner = owes.hypothesis.inner_test
    wanted = inner.__code__.co_varnames[1 : inner.__code__.co_argcount]
    inner(law(folder, name), **{key: data.draw(drawn[key]) for key in wanted})


@pytest.mark.parametrize("name", ["convex", "polished"])
def test_it_owes_what_every_law_owes_at_one_point(folder, name):
    one = law(folder, name)
    owed.test_committed_state_is_left_alone(one)
    owed.test_law_scales_with_area(one)
    owed.test_sticks_under_pressure(one)
    path = wander(5, 3)
    whole, first = probe(one, path, pressure=2e5), probe(one, path[:6], pressure=2e5)
    rest = probe(one, path[6:], pressure=2e5, state=first.state, start=first.jump[-1])
    assert (rest.reaction == whole.reaction[6:]).all()

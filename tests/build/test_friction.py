"""Contact that never slides, and friction that falls once a joint slides."""

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.scene import check, loads, specs
from masonry_fem.scene.joint import NO_SLIP
from masonry_fem.structures.stack import StackStructure

G = 9.81
BRITTLE = specs.law_record(
    "elastic_brittle",
    normal_stiffness=1e8,
    tangential_stiffness=1e8,
    normal_strength=1e3,
    tangential_strength=1e3,
)


def block_on_block(dimension, joint, push, *, size=(0.4, 0.8), fidelity="rigid", **keys):
    """A slender block on the ground, pushed sideways by ``push`` times its weight."""
    flat = dimension == 2
    structure = StackStructure(
        name="s", material="m", size=size if flat else (size[0], 0.3, size[1]), count=1
    )  # fmt: skip
    up = (0.0,) * (dimension - 1)
    side = (push * G, *up)
    given = {
        "dimension": dimension,
        "fidelity": fidelity,
        "mesh": specs.MeshSettings(divisions=(4,) * dimension),
        "materials": {"m": specs.Material(density=2000.0, young=1e10)},
        "structures": (structure,),
        "joints": (joint,),
        "overrides": (specs.Override(blocks="s.ground", fidelity="rigid"),) * (fidelity == "elastic"),
        "loads": specs.Loads(gravity=(*up, -G), accelerations=(specs.Acceleration(vector=side),)),
    }
    return check(specs.Scene(**(given | keys)))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("method", ["auto", "newton"])
def test_without_slip_a_joint_opens_but_never_slides(dimension, fidelity, method):
    """Pushed by 0.45 of its weight a block stands on its edge; friction of 0.4 would let it slide."""
    keys = {"fidelity": fidelity, "solver": specs.Solver(method=method)}
    result = solve_scene(block_on_block(dimension, specs.Joint(friction="no slip"), 0.45, **keys))
    assert result.outcome == "equilibrium"
    state = result.march.state
    normal, tangent = state.reaction[:, 0], np.linalg.norm(state.reaction[:, 1:], axis=1)
    open_ = normal <= 1e-9 * normal.max()
    if fidelity == "elastic":
        assert open_.any()
        assert (state.gap[open_] > 0).any()
    assert tangent[open_].max(initial=0.0) <= 1e-8 * normal.max()
    slip = np.linalg.norm(state.velocity[~open_, 1:], axis=1)  # in statics an increment [m]
    assert slip.max() <= 1e-10
    along = np.linalg.norm(state.reaction[:, 1:].sum(axis=0))
    assert along == pytest.approx(0.45 * normal.sum(), rel=1e-6)
    assert result.march.report.slip == 0
    slides = solve_scene(block_on_block(dimension, specs.Joint(friction=0.4), 0.45, **keys))
    assert slides.outcome == "no_equilibrium"


@pytest.mark.parametrize("dimension", [2, 3])
def test_without_slip_a_block_still_tips(dimension):
    """b/h = 0.5."""
    joint = specs.Joint(friction="no slip")
    assert solve_scene(block_on_block(dimension, joint, 0.499)).outcome == "equilibrium"
    assert solve_scene(block_on_block(dimension, joint, 0.501)).outcome == "no_equilibrium"


def test_without_slip_in_dynamics():
    """A block that tips about its edge leaves the ground with the other; the edge stays where it was."""
    probes = (specs.Probe(name="edge", block="s.b1", point=(0.4, 0.0)),)
    dynamics = specs.Dynamics(step=1e-3, duration=0.1)
    scene = block_on_block(2, specs.Joint(friction="no slip"), 0.8, analysis=dynamics, probes=probes)
    result = solve_scene(scene)
    assert result.outcome == "finished"
    assert np.abs(result.march.report.probes["edge"]).max() < 1e-5
    assert result.march.state.gap.max() > 1e-3


def test_a_strong_threshold_without_slip():
    """Springs and thresholds take it; what r_T may be goes with the pressure and the threshold."""
    joint = specs.Joint(friction="no slip", law=specs.law_record("constant_threshold", strength=1e4))
    assert solve_scene(block_on_block(2, joint, 0.501)).outcome == "equilibrium"


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"law": specs.law_record("mohr_coulomb", cohesion=1e5)},
         r"'no slip', expected a number beside mohr_coulomb"),
        ({"dynamic_friction": 0.4}, r"'no slip', expected a number beside joints\.0\.dynamic_friction"),
        ({"dilatancy": specs.Dilatancy(tangent=0.1, bound=1e-3)}, r"beside joints\.0\.dilatancy; drop one"),
        ({"scatter": specs.Scatter(seed=1, variation={"friction": 0.1})}, r"variation\.friction; drop"),
        ({"friction": "none"}, r"joints\.0\.friction is 'none', expected a number >= 0, or 'no slip'"),
    ],
)  # fmt: skip
def test_what_no_slip_goes_with(keys, words):
    with pytest.raises(SceneError, match=words):
        block_on_block(2, specs.Joint(**({"friction": "no slip"} | keys)), 0.1)


def test_no_slip_is_read_from_a_file():
    text = """
    fidelity = "rigid"
    materials.m.density = 2000.0
    structures = [{kind = "stack", name = "s", material = "m", size = [1, 1, 1], count = 1}]
    joints = [{friction = "no slip"}]
    """
    assert loads(text).joints[0].coefficient == NO_SLIP


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("law", [None, specs.law_record("mohr_coulomb", cohesion=100.0), BRITTLE])
@pytest.mark.parametrize("mortar", [None, specs.Mortar(normal_stiffness=1e11, tangential_stiffness=1e11)])
def test_a_broken_joint_slides_with_its_dynamic_friction(dimension, law, mortar):
    """a = (0.6 − μ_d) g once it slides."""
    joint = specs.Joint(friction=0.5, dynamic_friction=0.3, law=law, mortar=mortar)
    probes = (specs.Probe(name="p", block="s.b1", point=(0.0, 0.0) if dimension == 2 else (0.0, 0.0, 0.0)),)
    scene = block_on_block(dimension, joint, 0.6, size=(0.8, 0.2), probes=probes,
                           analysis=specs.Dynamics(step=1e-3, duration=0.06))  # fmt: skip
    result = solve_scene(scene)
    reached = result.march.report
    assert result.outcome == "finished"
    assert reached.slip == 2 ** (dimension - 1)
    speed = np.linalg.norm(result.march.state.velocity[:, 1:], axis=1)
    assert speed == pytest.approx(0.3 * G * 0.06, rel=0.06)  # it sticks or is glued at first
    np.testing.assert_allclose(result.march.last.problem.friction, 0.3)


def test_dynamic_friction_beside_a_law_without_any(tmp_path):
    (tmp_path / "slick.py").write_text(
        "from masonry_fem.joints import Dry\n"
        "class Slick(Dry):\n"
        "    name = 'slick'\n"
        "    def __init__(self):\n"
        "        super().__init__(friction=0.0)\n"
    )
    law = specs.PythonLaw(file="slick.py", law="Slick", trusted=True)
    joint = specs.Joint(law=law, dynamic_friction=0.2)
    stack = StackStructure(name="s", material="m", size=(1.0, 1.0), count=1)
    scene = specs.Scene(dimension=2, fidelity="rigid", materials={"m": specs.Material(density=2e3)},
                        structures=(stack,), joints=(joint,))  # fmt: skip
    with pytest.raises(SceneError, match=r"joints\.0\.law: .*0\.2 beside a friction of 0"):
        build(check(scene, base=tmp_path), Path(tmp_path))

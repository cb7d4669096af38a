"""Gaps and overlaps from 1e-15 m to a block's size, within and beyond ``contact.reach``."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.scene.specs import Contact, Dynamics, Joint, Statics
from tests.extremes.scenes import arrived, certificate
from tests.extremes.solids import G, crushed, jam_pressure, jammed, lifted, rest_error

GAPS = [1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3]
WIDE = [1e-2, 0.1, 0.4]
FALL = Dynamics(step=0.01, duration=0.6, theta=1.0)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("gap", [*GAPS, *(-gap for gap in GAPS)])
def test_small_gaps_close_and_small_overlaps_are_held(gap: float, fidelity: str) -> None:
    """Within the default reach of 1e-3 of a block's size, in statics; the cube carries its weight after."""
    result = solve_scene(lifted(gap, fidelity=fidelity))
    assert result.outcome == "equilibrium"
    assert rest_error(result, gap) < 1e-9
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("gap", [1e-12, 1e-6, *WIDE, 1.0, -1e-6, *(-gap for gap in WIDE)])
def test_wide_reach_sees_a_block_from_afar_and_not_through_it(gap: float, fidelity: str) -> None:
    """With a reach of two edges: statics closes the gap in one step, dynamics falls and comes to rest."""
    for analysis in (None, FALL):
        scene = lifted(gap, fidelity=fidelity, reach=2.0, analysis=analysis)
        result = solve_scene(scene)
        assert len(result.built.model.interfaces) == 1  # not the cube's top on the floor's bottom
        assert result.outcome == arrived(scene)
        assert rest_error(result, gap) < 1e-8
        assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("gap", WIDE)
def test_beyond_the_reach_nothing_touches(gap: float, caplog: pytest.LogCaptureFixture) -> None:
    result = solve_scene(lifted(gap))
    assert result.outcome == "no_equilibrium"
    assert "cube falls" in result.message
    assert any("contact.reach" in record.getMessage() for record in caplog.records)


@pytest.mark.parametrize(("gap", "reach", "told"), [
    (-1e-2, None, "no more than contact.reach"), (-0.4, 0.1, "no more than contact.reach"),
    (-0.6, 2.0, "half of the thinner one"), (-1.0, 2.0, "half of the thinner one"),
])  # fmt: skip
def test_deep_overlaps_are_refused(gap: float, reach: float | None, told: str) -> None:
    with pytest.raises(SceneError, match=f"'cube' and 'floor' by .* m, .*{told}|{told}"):
        solve_scene(lifted(gap, reach=reach))


@pytest.mark.parametrize("speed", [0.01, 1.0, 1e3])
@pytest.mark.parametrize("overlap", [1e-12, 1e-6, 1e-3, 0.1, 0.4])
def test_overlaps_are_driven_out_no_faster_than_asked(overlap: float, speed: float) -> None:
    """The foot is out by then, or as far as that speed takes it, and flies no higher than it throws.

    Overlaps up to 1e-6 of a block's size are none.
    """
    march = Dynamics(step=0.01, duration=0.5, theta=1.0)
    result = solve_scene(lifted(-overlap, reach=2.0, expulsion=speed, analysis=march))
    rise = float(result.summary.probes["foot"][1])
    thrown = min(speed, overlap / 0.01)
    assert rise >= min(overlap, speed * 0.5) - 1.5e-6
    assert rise <= overlap + thrown * max(0.0, 0.5 - overlap / thrown) + 1e-9
    assert result.march.report.speed <= max(thrown, 1e-9) * (1 + 1e-9)
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("analysis", [None, Statics()], ids=["dynamics", "statics"])
@pytest.mark.parametrize("overlap", [1e-12, 1e-6, 9e-4])
def test_jammed_block_is_held_without_expulsion(overlap: float, analysis: Statics | None) -> None:
    scene = jammed(overlap, expulsion=0.0, analysis=analysis)
    result = solve_scene(scene)
    assert result.outcome == arrived(scene)
    assert abs(result.summary.probes["middle"]).max() < 1e-8
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("speed", [0.01, pytest.param(1.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("overlap", [1e-12, 1e-9, pytest.param(2e-6, marks=pytest.mark.slow), 9e-4])
def test_rigid_block_that_cannot_be_driven_out_stays_and_is_told(
    overlap: float, speed: float, caplog: pytest.LogCaptureFixture
) -> None:
    """No motion takes it out of both sides: impulses of 1e29 N s hid that, and it fell through the floor."""
    brief = Dynamics(step=0.005, duration=0.04, theta=1.0)  # each try to drive it out takes a second
    result = solve_scene(jammed(overlap, expulsion=speed, analysis=brief))
    assert result.outcome == "finished"
    assert abs(result.summary.probes["middle"]).max() < 1e-6
    assert max(certificate(result).values()) < 1e-9
    told = any("could not be driven apart" in record.getMessage() for record in caplog.records)
    assert told == (overlap > 1.5e-6)  # less is none


@pytest.mark.parametrize("overlap", [1e-6, 1e-4, 9e-4])
def test_elastic_block_is_squeezed_instead(overlap: float) -> None:
    """Twice the overlap of a metre's length: strain 2·overlap, to what friction under its weight adds."""
    result = solve_scene(jammed(overlap, expulsion=1.0, fidelity="elastic"))
    assert result.outcome == "finished"
    assert jam_pressure(result) == pytest.approx(2 * overlap, rel=0.6, abs=2e-6)
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize(
    ("closing", "outcome"),
    [
        pytest.param(1e-6, "finished", marks=pytest.mark.slow),
        (1e-3, "no_convergence"),
        (0.05, "no_convergence"),
    ],
)
def test_rigid_block_that_supports_crush(
    closing: float, outcome: str, caplog: pytest.LogCaptureFixture
) -> None:
    """There is no motion: statics and marches say so; where small errors are borne it does not fall."""
    statics = solve_scene(crushed(closing, analysis=Statics(load_steps=2)))
    assert statics.outcome == "no_convergence"
    assert "make these blocks elastic" in statics.message
    short = Dynamics(step=0.05, duration=0.1, theta=1.0)
    marched = solve_scene(crushed(closing, analysis=short))
    assert marched.outcome == outcome
    if outcome == "finished":
        assert "missed the solver's tolerance" in caplog.text
    assert abs(marched.summary.probes["middle"]).max() < max(closing, 1e-6)


@pytest.mark.parametrize("closing", [1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("analysis", [None, Statics(load_steps=2)], ids=["dynamics", "statics"])
def test_elastic_block_that_supports_crush(analysis: Statics | None, closing: float) -> None:
    """It is strained by what they close, to what friction under its weight (2e-6 of E) adds.

    Forces are balanced relative to what presses, and told relative to the weight.
    """
    scene = crushed(closing, fidelity="elastic", analysis=analysis)
    result = solve_scene(scene)
    assert result.outcome == arrived(scene)
    assert jam_pressure(result) == pytest.approx(closing, rel=1e-3, abs=2e-6)
    assert result.summary.probes["middle"][0] == pytest.approx(-closing / 2, rel=2e-2)
    assert max(certificate(result).values()) < 1e-10 * max(10.0, closing / 2e-6)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["gap", "velocity"])
@pytest.mark.parametrize("step", [pytest.param(1e-3, marks=pytest.mark.slow), 4e-3])
@pytest.mark.parametrize("gap", [1e-6, 0.1, 1.0])
def test_a_fall_ends_on_the_floor_with_contacts_found_anew(gap: float, step: float, form: str) -> None:
    """The velocity form lets it in by a step's fall, deeper than the reach: it was lost there, and fell."""
    fall = Dynamics(step=step, duration=0.6, theta=1.0)
    scene = lifted(gap, analysis=fall, joints=(Joint(form=form),), contact=Contact(update="redetect"))
    result = solve_scene(scene)
    deep = step * (2 * G * gap) ** 0.5 + 2 * G * step**2 if form == "velocity" else 1e-9
    assert rest_error(result, gap) <= deep
    assert len(result.march.model.interfaces) == 1
    assert result.march.report.speed < 1e-9

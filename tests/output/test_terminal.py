"""Console: silent where it should be, the outcome first where not."""

import io

import pytest
from rich.console import Console

from masonry_fem.host.phases import heard
from masonry_fem.output.refinement_table import round_line
from masonry_fem.output.sheet import quantity, round_down
from masonry_fem.output.terminal import Progress, print_summary

SUMMARY = {
    "title": "Arch", "outcome": "equilibrium", "message": "Equilibrium after 1 step.",
    "time": 1.0, "steps": 1,
    "blocks": 13, "shapes": 2, "contacts": 1504, "unknowns": 22345,
    "supports": {"left": {"force": [1234.5, 0, 5678.0], "moment": [0, 1, 2]},
                 "right": [-1234.5, 1e-12, 5678, 0, 0, 0]},
    "applied": [0, 0, -11356.0, 0, 0, 0],
    "certificate": {"natural_map": 1e-12, "max_penetration": 2e-17, "energy_balance": None},
    "stress": {"max_von_mises": {"value": 123456.0, "block": "arch.v3"},
               "p95_von_mises": 45678.0, "blocks": []},
    "probes": {"crown": [0, 1e-19, -2.3e-5]}, "status": {"open": 12, "stick": 1400, "slip": 92},
    "seconds": {"mesh": 0.1, "step": 0.25}, "peak_memory_mb": 312.4, "versions": {"numpy": "2"},
}  # fmt: skip


def printed(summary, width=110):
    out = io.StringIO()
    print_summary(summary, Console(file=out, width=width))
    return out.getvalue()


def test_summary_starts_with_the_outcome_and_names_where():
    text = printed(SUMMARY)
    assert text.index("equilibrium") < text.index("13 blocks")
    for words in ("123 kPa", "−11.356 kN", "arch.v3", "1 400 stick", "−23 µm", "312 MB", "after 1 step "):
        assert words in text


def test_forces_of_plane_structures_are_per_metre():
    text = printed({"applied": [0.0, -5.0], "certificate": {"min_normal_reaction": -1e-3}})
    assert "y −5 N/m" in text
    assert "-1.00e-03 N/m" in text
    assert "N/m" not in printed(SUMMARY)


def test_motions_that_are_rounding_beside_the_greatest_are_zero():
    """Of 10 µm the solver leaves 1.4e-13 m sideways; 2e-10 m is more than that."""
    moved = {"crown": [-1.4e-13, -1.02e-5], "foot": [3e-13, 2e-10], "held": [0.0, 0.0]}
    text = printed({"probes": moved})
    for words in ("x 0 m  y −10.2 µm", "x 0 m  y 0.2 nm", "x 0 m  y 0 m"):
        assert words in text
    alone = printed({"probes": {"foot": [3e-13, 2e-10]}})
    assert "x 0.0003 nm" in alone
    forces = printed({"applied": [1e-3, -1e5]})
    assert "x 1 mN/m" in forces, "the balance of forces is more exact"


def test_the_two_maxima_of_stress_are_told_apart():
    both = {
        "max_von_mises": {"value": 165e3, "block": "a"},
        "max_von_mises_nodal": {"value": 203e3, "block": "b"},
    }
    text = printed(SUMMARY | {"stress": both, "shapes": 1})
    lines = text.splitlines()
    assert any("165 kPa at Gauss points in a" in line for line in lines)
    assert any("as pictured" in line and "203 kPa at nodes in b" in line for line in lines)
    assert "1 shape," in text


@pytest.mark.parametrize("missing", list(SUMMARY))
def test_any_part_may_be_missing(missing):
    assert printed({key: value for key, value in SUMMARY.items() if key != missing})


def test_each_stage_tells_what_its_supports_gave():
    """Of many supports those with the greatest forces, at the end of a run too."""
    supports = {f"s{k}": {"force": [0.0, 1e3 * k]} for k in range(12)}
    stages = [
        {"name": "built", "outcome": "equilibrium", "supports": {"left": {"force": [0.0, 5e3]}}},
        {"name": "sunk", "outcome": "no_equilibrium", "supports": supports},
    ]
    told = printed({"outcome": "equilibrium", "stages": stages, "supports": supports, "applied": [0.0, -6e4]})
    text = " ".join(told.split())
    assert "stages built equilibrium; forces of its supports: left x 0 N/m y 5 kN/m" in text
    assert "sunk no equilibrium; forces of its supports: s8 x 0 N/m y 8 kN/m" in text
    assert "8 more with smaller forces" in text
    assert "2 more with smaller forces, in summary.json" in text


@pytest.mark.parametrize(
    ("outcome", "relative", "told"),
    [("equilibrium", 0.43, True), ("equilibrium", 0.05, False), ("no_equilibrium", 0.43, False)],
)
def test_a_large_error_comes_with_what_lessens_it(outcome, relative, told):
    error = {"relative": relative, "unjudged": 0, "worst": [{"block": "v2"}]}
    text = printed({"outcome": outcome, "stress": {"error": error}})
    assert ("finer elements" in text) == told


def test_brackets_in_names_are_no_markup():
    assert "[bold]" in printed(SUMMARY | {"message": "block [bold] slides"})


def test_bad_outcomes_are_shown_too():
    assert "no equilibrium" in printed({"outcome": "no_equilibrium", "message": "v3 slides"})


def test_a_march_tells_its_steps(report):
    told = []

    class Listener:
        def begin(self, what, total):
            told.append((what, total))
            return lambda done, note="", total=None: told.append((done, note))

        def end(self, at):
            told.append("end")

    with heard(Listener()):
        progress = Progress(10)
        progress.start(None)
        for step in range(1, 4):
            progress.record(None, None, report(step))
        assert progress.close({}) == []
        assert progress.close({}) == []
    assert told[0] == ("steps", 10)
    assert told[3][0] == 3
    assert "step 3/10" in told[3][1]
    assert "1.0e-11" in told[3][1]
    assert told[4:] == ["end"]


def test_progress_is_silent_where_nobody_listens(report, capsys):
    progress = Progress()
    progress.start(None)
    progress.record(None, None, report(1))
    progress.close({})
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0 Pa"), (1234.0, "1.23 kPa"), (-2.5e6, "−2.5 MPa"), (1000.0, "1 kPa"), (999.9999999999, "1 kPa"),
     (3e-13, "0.0003 nPa")],
)  # fmt: skip
def test_quantities_carry_a_prefix(value, text):
    assert quantity(value, "Pa") == text


@pytest.mark.parametrize(
    ("value", "rounded"), [(1.0, 1.0), (1.99, 1.0), (4.9, 2.0), (5.0, 5.0), (0.0099, 0.005)]
)
def test_scales_are_1_2_5(value, rounded):
    assert round_down(value) == pytest.approx(rounded)


def test_nothing_and_its_rounding_are_told_as_such():
    """No load: zeros without a sign, an error without a worst block; what joints feed back is negative."""
    error = {"relative": 0.0, "unjudged": 0, "worst": [{"block": "arch.v3"}]}
    text = printed({"applied": [-0.0, -0.0], "stress": {"error": error}})
    assert "x 0 N/m  y 0 N/m" in text
    assert "0 %" in text
    assert "arch.v3" not in text
    lost = printed({"errors": {"time": {"dissipated": -0.05}}})
    assert "−5 % of the largest energy" in lost
    assert "< 1e-06 %" in printed({"errors": {"time": {"dissipated": -1e-17}}})


def test_one_mesh_is_one_mesh():
    made = {
        "round": 1,
        "unknowns": 1234,
        "meshes": 1,
        "made": 1,
        "error": 0.0896,
        "refined": 0,
        "seconds": 0.1,
    }
    assert round_line(made) == "round 1: 1 234 unknowns, 1 mesh (1 new), error 8.96 %, 0.1 s"


def test_the_console_goes_from_verdict_to_cost():
    """Verdict, stresses and utilisation, forces, joints, certificate, cost."""
    furthest = {"value": 1e-3, "interface": "a / b"}
    joints = dict.fromkeys(("open", "closed", "middle_third", "cracked", "hinge", "held", "slide"), 0) | {
        "cracked": 3, "hinge": 2, "slide": 1, "greatest_opening": furthest, "greatest_sliding": furthest,
        "nearest_edge": {"value": 0.62, "interface": "c / d"},
        "least_margin": {"value": 0.21, "interface": "e / f"},
    }  # fmt: skip
    stone = {
        "block": "v3",
        "of_mean": 0.1,
        "local": 0.2,
        "governs": "tension",
        "greatest": 0.3,
        "error": 0.05,
    }
    used = {"share": 0.05, "worst": [stone], "material_factor": 1.0, "over": 0, "rigid": 0, "one_sided": 0,
            "unchecked": 0}  # fmt: skip
    text = printed(SUMMARY | {"joints": joints, "utilisation": used})
    headings = [line.split()[0] for line in text.splitlines() if line[:1].isalpha()]
    assert headings == [
        "stress", "utilisation", "forces", "displacements", "joints", "contacts", "certificate", "model",
        "seconds", "memory",
    ]  # fmt: skip
    for words in (
        "3 cracked, 2 hinges; 1 slides",
        "1 mm in a / b",
        "62 % of the way from the middle in c / d",
        "0.21 in e / f",
    ):
        assert words in text

"""Response of probes: what a run in dynamics leaves of its peaks and residuals."""

import csv
import json

import numpy as np
import pytest
from matplotlib import image
from matplotlib.figure import Figure

from masonry_fem.analyses.run import run
from masonry_fem.output.response import ProbeMotion, response_of
from masonry_fem.output.response_picture import _ways
from masonry_fem.scene import loads

SCENE = """
dimension = 2
fidelity = "elastic"
materials.stone = { density = 2000.0, young = 1e7, poisson = 0.0 }
mesh = { element = "Q2", divisions = [1, 4] }
structures = [{ kind = "block", name = "column", material = "stone", size = [0.5, 4.0] }]
supports = [{ on = "column/bottom" }]
probes = [{ name = "top", block = "column", point = [0.25, 4.0] },
          { name = "foot", block = "column", point = [0.25, 0.0] }]
analysis = { kind = "dynamics", step = 0.002, duration = 0.6, theta = 0.5 }
loads.accelerograms = [{ y = "record.csv", acts = "ACTS" }]
output = { pictures = false, fields = false }
"""


@pytest.fixture
def made(tmp_path):
    """Runs on the same record, on the ground and as inertia."""
    time = np.arange(201) * 0.002
    np.savetxt(tmp_path / "record.csv", np.column_stack([time, np.sin(10 * np.pi * time)]), delimiter=",")

    def make(acts, **changes):
        text = SCENE.replace("ACTS", acts)
        for old, new in changes.items():
            text = text.replace(old, new)
        return run(loads(text, base=tmp_path), tmp_path / acts, base=tmp_path)

    return make


def test_peaks_and_residuals_are_relative_to_the_ground(made):
    """Of a column on a ground that moves they are those under inertia."""
    told = {acts: made(acts).summary.response["top"] for acts in ("ground", "inertia")}
    one, other = told["ground"], told["inertia"]
    scale = np.abs(one.peak).max()
    assert scale > 1e-3
    for key in ("peak", "residual", "swing"):
        np.testing.assert_allclose(getattr(one, key), getattr(other, key), atol=1e-3 * scale)
    assert one.greatest_time == other.greatest_time


def test_the_table_agrees_with_the_history_and_the_summary(made):
    """Peak, its time and the residual, from the lines of the history."""
    result = made("inertia")
    folder = result.files[0].parent
    with (folder / "history.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    way = np.array([float(line["probes.top_y"]) for line in lines])
    place = int(np.abs(way).argmax())
    with (folder / "response.csv").open(newline="") as file:
        across, along = list(csv.DictReader(file))[:2]
    assert (across["axis"], along["probe"], along["axis"]) == ("x", "top", "y")
    assert float(along["peak [m]"]) == way[place]
    assert float(along["peak_time [s]"]) == float(lines[place]["time"])
    assert float(along["residual [m]"]) == way[-1]
    assert 0 < float(along["swing [m]"]) == np.abs(way[-30:] - way[-1]).max()
    told = json.loads((folder / "summary.json").read_text())["response"]["top"]
    assert told["peak"][1] == way[place]
    assert folder / "response.csv" in result.files


def test_statics_has_no_response(made):
    """Nothing is told, and no table written."""
    result = made("inertia", **{
        'analysis = { kind = "dynamics", step = 0.002, duration = 0.6, theta = 0.5 }': "",
        'loads.accelerograms = [{ y = "record.csv", acts = "inertia" }]': "loads.gravity = [0, -9.81]",
    })  # fmt: skip
    assert result.summary.response is None
    assert not (result.files[0].parent / "response.csv").exists()


@pytest.mark.parametrize("acts", ["ground", "inertia"])
def test_a_probe_on_the_ground_has_its_spectrum(made, acts):
    """Of a clamped point as of the accelerogram, with oscillators that begin and end with the record."""
    result = made(acts)
    table = np.genfromtxt(
        result.files[0].parent / "spectra.csv", delimiter=",", names=True, deletechars="", replace_space=" "
    )
    assert table.dtype.names[:2] == ("period [s]", "accelerograms.0.y displacement [m]")
    within = (table["period [s]"] > 0.06) & (table["period [s]"] < 0.25)  # peaks come before the end
    assert within.sum() > 15
    one = table["accelerograms.0.y pseudo_acceleration [m/s^2]"][within]
    other = table["probes.foot.y pseudo_acceleration [m/s^2]"][within]
    np.testing.assert_allclose(other, one, rtol=5e-3)
    told = result.summary.spectra
    assert told.damping == 0.05
    peak = told.peaks["accelerograms.0.y"]
    column = table["accelerograms.0.y pseudo_acceleration [m/s^2]"]
    assert (peak.pseudo_acceleration, peak.period) == (column.max(), table["period [s]"][column.argmax()])
    assert "probes.top.y" in told.peaks


def test_the_damping_of_spectra_is_a_key(made):
    """More of it lowers the peak."""
    less, more = (
        made("inertia", **{"fields = false": f"fields = false, spectrum_damping = {one}"}).summary.spectra
        for one in (0.02, 0.2)
    )
    assert (less.damping, more.damping) == (0.02, 0.2)
    name = "accelerograms.0.y"
    assert less.peaks[name].pseudo_acceleration > 1.3 * more.peaks[name].pseudo_acceleration


@pytest.mark.parametrize(
    ("pictures", "drawn"), [("true", True), ('["response"]', True), ('["thrust"]', False)]
)
def test_the_picture_is_drawn_where_it_is_asked_for(made, pictures, drawn):
    """With all pictures or by its name."""
    result = made("ground", **{"pictures = false": f"pictures = {pictures}"})
    path = result.files[0].parent / "response.png"
    assert path.exists() == (path in result.files) == drawn
    if drawn:
        pixels = image.imread(path)
        assert pixels.shape[1] == 1540
        for colour in (0x0B6E99, 0x1D2126):  # the probe that went farthest, the accelerogram
            parts = np.array([colour >> 16, colour >> 8 & 255, colour & 255])
            assert (np.abs(255 * pixels[:, :, :3] - parts).max(axis=2) < 2).sum() > 100


@pytest.mark.parametrize(
    ("steps", "pictures", "drawn"),
    [(3, '["response"]', True), (2, '["response"]', False), (3, '["thrust"]', False)],
)
def test_statics_draws_where_probes_went_from_step_to_step(made, steps, pictures, drawn):
    result = made("inertia", **{
        'kind = \"dynamics\", step = 0.002, duration = 0.6, theta = 0.5':
            f'kind = \"statics\", load_steps = {steps}',
        'loads.accelerograms = [{ y = "record.csv", acts = "inertia" }]': "loads.gravity = [0, -9.81]",
        "pictures = false": f"pictures = {pictures}",
    })  # fmt: skip
    path = result.files[0].parent / "response.png"
    assert path.exists() == drawn
    assert (path in result.files) == drawn


def test_the_picture_tells_a_residual_of_rounding_as_none():
    """A probe on the ground moves relative to it by rounding alone."""
    times, way = np.linspace(0.1, 1.0, 10), np.linspace(0.0, 2.0, 10)[:, None]
    motions = [ProbeMotion(str(size), times, size * way, 0 * way) for size in (1.0, 1e-14)]
    panel = Figure().subplots()
    _ways(panel, 0, "x", motions, [response_of(one) for one in motions], "time [s]")
    assert [text.get_text() for text in panel.texts] == ["2 m", "0 m"]

"""Report: what the page says; it needs nothing else, and nothing of a scene gets into its code."""

import json
import os
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from benchmarks.report_page import browser, clicked, opened
from masonry_fem.analyses.run import run
from masonry_fem.cli import main
from masonry_fem.errors import OutputError
from masonry_fem.output.report import write_report
from masonry_fem.output.report.lights import lights, worst
from masonry_fem.output.report.plots import plots
from masonry_fem.records.told import plain
from masonry_fem.scene import load, loads

ARCH = """
title = "Arch <script>alert('x')</script> & </title>"
dimension = 2
fidelity = "elastic"
mesh = { element = "Q1", divisions = [3, 4] }
joints = [{ friction = 0.7 }]
loads.gravity = [0.0, -9.81]
probes = [{ name = "crown", block = "arch.v04", point = [0.0, 1.0] }]
output = { pictures = false, report = true }

[materials.stone]
density = 2400.0
young = "10 GPa"
compressive_strength = "1 MPa"
tensile_strength = "1 MPa"

[[structures]]
kind = "arch"
name = "arch"
material = "stone"
radius = 1.0
thickness = 0.25
voussoirs = 7
"""
VOID = {"meta", "link", "input", "img", "br", "line", "polyline"}
LONGEST = 10_000_000


class Page(HTMLParser):
    """Text, elements and addresses of a page; complains where elements are not nested."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.addresses, self.words = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.addresses += [value for name, value in attrs if name in ("src", "href", "srcset", "action")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("script", "style"):
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def arch(tmp_path_factory):
    out = tmp_path_factory.mktemp("arch")
    return run(loads(ARCH), out), out


def page_of(folder):
    return Page((folder / "report.html").read_text(encoding="utf-8"))


def test_the_page_tells_of_the_run(arch):
    result, out = arch
    assert out / "report.html" in result.files
    page, summary = page_of(out), result.summary
    assert "Arch <script>alert('x')</script> & </title>" in page.text
    assert "Does it stand? Equilibrium after 1 step." in page.text
    stone = summary.utilisation.worst[0]
    used = f"{stone.block} uses most: {stone.local:.2g} ± {stone.error:.1g} of its design strength"
    assert used in page.text
    for part in (
        "Reactions",
        "arch.springing_left",
        "crown",
        "Joints",
        "Certificate",
        "Assumptions",
        "10 GPa",
        "0.7",
    ):
        assert part in page.text
    assert "The structure is plane" in page.text
    assert (out / "report.html").stat().st_size < LONGEST
    assert {path.name for path in out.glob("*.csv")} == {"history.csv", "interfaces.csv", "stones.csv"}


def test_it_needs_no_other_file(arch):
    _, out = arch
    page = page_of(out)
    assert all(address.startswith("data:") for address in page.addresses)
    policy = next(attrs["content"] for tag, attrs in page.elements if attrs.get("http-equiv"))
    assert policy.startswith("default-src 'none'")
    text = (out / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?://|@import|url\((?!data:)", text)


def test_nothing_of_a_scene_is_code(arch):
    """The script of the title is text in the page, and in no script of the page either."""
    _, out = arch
    text = (out / "report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert" in text
    scripts = sum(tag == "script" for tag, _ in page_of(out).elements)
    assert scripts == 3  # of the tables, the model's data and its viewer


def test_the_scene_of_a_run_can_be_run_again(arch):
    _, out = arch
    scene = load(out / "as_run.toml")
    assert plain(scene.materials["stone"])["compressive_strength"] == 1e6
    assert scene.title == loads(ARCH).title


def test_it_is_made_of_the_folder_alone(arch, tmp_path):
    _, out = arch
    shutil.copytree(out, tmp_path / "elsewhere")
    (tmp_path / "elsewhere" / "report.html").unlink()
    assert main(["report", str(tmp_path / "elsewhere")]) == 0
    assert (tmp_path / "elsewhere" / "report.html").read_bytes().replace(b"elsewhere", b"") == (
        out / "report.html"
    ).read_bytes().replace(out.name.encode(), b"")


def test_what_is_missing_is_left_out(arch, tmp_path):
    _, out = arch
    shutil.copy(out / "summary.json", tmp_path)
    page = Page(write_report(tmp_path).read_text(encoding="utf-8"))
    assert "Does it stand? Equilibrium" in page.text
    assert "The run left no as_run.toml" in page.text
    assert "canvas" not in {tag for tag, _ in page.elements}


def test_what_is_rounding_is_told_as_zero(arch, tmp_path):
    """Of the energy its terms are shown, and of the table of joints each column."""
    _, out = arch
    for name in ("summary.json", "as_run.toml", "interfaces.csv"):
        shutil.copy(out / name, tmp_path)
    rows = (out / "interfaces.csv").read_text(encoding="utf-8").splitlines()
    place = rows[0].split(",").index("opening [m]")
    cells = [row.split(",") for row in rows[1:]]
    for number, row in enumerate(cells):
        row[place] = "2e-3" if number == 0 else "3e-14"
    (tmp_path / "interfaces.csv").write_text("\n".join([rows[0], *map(",".join, cells)]), encoding="utf-8")
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    summary["energy"] |= {"external_work": 5.0, "strain": 4.0, "kinetic": 4e-12}
    summary["energy"] |= {"largest": 5.0, "unaccounted": 1.0}
    (tmp_path / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    page = Page(write_report(tmp_path).read_text(encoding="utf-8"))
    told = {attrs["data-value"] for tag, attrs in page.elements if tag == "td" and "data-value" in attrs}
    assert "2.0" in told
    assert "3e-11" not in told
    assert "work of the loads 5" in page.text
    assert "in none of these 1" in page.text
    assert "in motion at the end" not in page.text


def test_pictures_that_do_not_fit_are_packed_and_not_left_out(arch, tmp_path):
    """Noise is what packs worst: two pictures of it take 12 MB, and less than 10 MB as WebP."""
    _, out = arch
    shutil.copy(out / "summary.json", tmp_path)
    noise = np.random.default_rng(0).integers(0, 256, (1200, 1600, 3), dtype=np.uint8)
    for name in ("overview.png", "cut_middle_von_mises.png"):
        Image.fromarray(noise).save(tmp_path / name)
    assert sum(path.stat().st_size for path in tmp_path.glob("*.png")) > LONGEST
    text = write_report(tmp_path).read_text(encoding="utf-8")
    assert len(text) < LONGEST
    assert text.count("data:image/webp;base64,") == 2
    assert "Left out" not in text


def test_a_folder_without_a_summary_is_refused(tmp_path, capsys):
    assert main(["report", str(tmp_path)]) == 1
    assert "has no summary.json, expected the results folder of 'masonry-fem run'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "summary.json").write_text("{", encoding="utf-8")
    with pytest.raises(OutputError, match=r"summary\.json is no JSON .*; run it again"):
        write_report(tmp_path)
    (tmp_path / "summary.json").write_text('{"schema": "study/1"}', encoding="utf-8")
    with pytest.raises(OutputError, match=r"has no summary\.json of a run"):
        write_report(tmp_path)


def test_a_run_that_was_ended_is_red(tmp_path):
    told = {"schema": "run/2", "title": "pier", "outcome": "failed", "message": "The disk was full."}
    (tmp_path / "summary.json").write_text(json.dumps(told), encoding="utf-8")
    page = Page(write_report(tmp_path).read_text(encoding="utf-8"))
    assert "The disk was full." in page.text
    assert ("p", {"class": "verdict red"}) in page.elements


def test_what_falls_is_told(tmp_path):
    changes = ["joints.0.friction=0.05", "fidelity='rigid'"]
    result = run(loads(ARCH, changes), tmp_path)
    assert result.outcome == "no_equilibrium"
    page = page_of(tmp_path)
    assert ("p", {"class": "verdict red"}) in page.elements
    assert result.summary.mechanism.sentence in page.text
    assert "stones are rigid: only their mean stress is known" in page.text


def test_histories_are_drawn(tmp_path):
    changes = ["analysis={kind='dynamics', step=1e-4, duration=1e-3}"]
    run(loads(ARCH, changes), tmp_path)
    page = page_of(tmp_path)
    lines = [attrs for tag, attrs in page.elements if tag == "polyline"]
    assert lines
    assert "Force of arch.springing_left" in page.text
    for line in lines:
        points = np.array([pair.split(",") for pair in line["points"].split()], dtype=float)
        assert ((points >= [69, 13]) & (points <= [631, 205])).all()


def test_curves_and_ticks_are_where_the_values_are():
    time = np.linspace(0.0, 2.0, 5)
    (plot,) = plots({"time": time, "probes.top_x": -2e-3 * time, "probes.top_y": 0 * time}, 2)
    assert (plot.title, plot.unit) == ("Displacement of top", "mm")
    (line,) = plot.lines
    assert line.name == "x"
    assert line.points.split()[0] == "70.0,14.0"  # from 0 at the top
    assert line.points.split()[-1] == "630.0,204.0"  # to -4 mm
    assert [label for _, label in plot.up] == ["-4", "-3", "-2", "-1", "0"]
    assert [place for place, _ in plot.up] == pytest.approx([204, 156.5, 109, 61.5, 14])
    assert plots({"time": np.array([1.0])}, 2) == []


GOOD = {
    "outcome": "equilibrium", "message": "Equilibrium after 1 step.",
    "certificate": {"natural_map": 1e-12, "block_balance": 1e-12},
    "stress": {"error": {"relative": 0.05, "unjudged": 0}},
    "utilisation": {
        "worst": [{"block": "b", "local": 0.9, "error": 0.05, "of_mean": 0.5, "governs": "tension"}],
        "over": 0, "unchecked": 0, "one_sided": 0, "rigid": 0,
    },
}  # fmt: skip


def changed(path, value):
    told = json.loads(json.dumps(GOOD))
    *way, last = path
    part = told
    for key in way:
        part = part[key]
    part[last] = value
    return told


@pytest.mark.parametrize(
    ("path", "value", "colour"),
    [
        (["message"], "Equilibrium after 1 step.", "green"),
        (["outcome"], "no_convergence", "red"),
        (["start"], {"reached": False, "message": "It needs a thrust."}, "amber"),
        (["certificate", "natural_map"], 1e-8, "amber"),
        (["certificate", "block_balance"], 1e-5, "red"),
        (["certificate", "block_balance"], float("nan"), "red"),
        (["stress", "error", "relative"], 0.2, "amber"),
        (["stress", "error", "relative"], 0.4, "red"),
        (["stress", "error", "unjudged"], 3, "amber"),
        (["utilisation", "worst", 0, "error"], 0.2, "amber"),
        (["utilisation", "worst", 0, "local"], 1.1, "red"),
        (["utilisation", "worst", 0, "local"], 0.08, "amber"),  # ± 0.05
        (["utilisation", "unchecked"], 1, "amber"),
        (["remarks"], [{"code": "abrupt", "sentence": "gave way"}], "amber"),
    ],
)
def test_the_light_at_the_top_is_the_worst(path, value, colour):
    assert worst(lights(changed(path, value))) == colour


def test_what_was_not_asked_is_grey_and_spoils_nothing():
    told = {key: value for key, value in GOOD.items() if key not in ("stress", "utilisation")}
    found = lights(told)
    assert [light.colour for light in found] == ["green", "green", "grey", "grey", "green"]
    assert worst(found) == "green"


def test_what_rounding_makes_of_the_energy_of_a_structure_at_rest_is_no_fault():
    told = changed(["certificate", "energy_balance"], 0.4)
    assert lights(told)[1].colour == "red"
    told["certificate"]["rounding"] = {"energy_balance": 18.0}
    light = lights(told)[1]
    assert light.colour == "green"
    assert "Balance of energy is 4.0e-01, as rounding alone makes it (good: up to 2e+01)" in light.answer


@pytest.fixture(scope="module")
def chromium():
    """A command that starts it."""
    command = browser()
    if command is None:
        pytest.skip("needs Chromium")
    return command


@pytest.mark.slow
def test_a_browser_shows_the_model_without_an_error(arch, chromium):
    """Its legend is written by the viewer once the model is drawn."""
    _, out = arch
    done = subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--dump-dom",
         "--enable-unsafe-swiftshader", "--enable-logging=stderr", "--virtual-time-budget=5000",
         f"--user-data-dir={out / 'profile'}", f"file://{out / 'report.html'}"],
        capture_output=True, text=True, timeout=120, check=True, env=os.environ | {"HOME": str(out)},
    )  # fmt: skip
    assert "CONSOLE" not in done.stderr
    legend = re.search(r'<div id="ends">(.*?)</div>', done.stdout).group(1)
    assert legend.count("<span>") == 3


@pytest.mark.slow
def test_a_hundred_clicks_name_stones_and_make_no_error(arch, chromium):
    _, out = arch
    told = clicked(chromium, out / "report.html")
    assert told.errors == ()
    assert {f"arch.v{number:02}" for number in range(1, 8)} <= set(told.named)


@pytest.mark.slow
def test_a_click_on_a_row_shows_the_stone_in_the_model(arch, chromium):
    _, out = arch
    click = r"""<script>setTimeout(() => {
      const rows = [...document.querySelectorAll("#stones tbody tr")];
      rows.find((row) => row.cells[0].textContent === "arch.v03").click();
      const name = document.getElementById("picked").textContent.split("\n")[0];
      const chosen = document.querySelectorAll("tr.chosen").length;
      document.body.insertAdjacentHTML("beforeend", `<output id="row">${name} ${chosen}</output>`);
    }, 500);</script></body>"""
    text = (out / "report.html").read_text(encoding="utf-8").replace("</body>", click, 1)
    page, log = opened(chromium, text)
    assert "CONSOLE" not in log
    assert '<output id="row">arch.v03 1</output>' in page

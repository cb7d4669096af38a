"""The pages of docs/laws: snippets are scenes, figures are what the program gives, pictures are light."""

import importlib
import re
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.joints import kinds, probe

FRICTION, UNDER = 0.75, (0.1e6, 0.3e6, 0.5e6)
FOLDER = Path(__file__).parents[1] / "docs/laws"
LAWS = {name: kind for name, kind in kinds().items() if (FOLDER / f"{name}.md").is_file()}
PAGES = {name: name for name in ("dry", *LAWS)} | {
    "bed": "mortar",
    "closure": "closure",
    "rough": "dilatancy",
}
SOFTENING = ("monerie_acary", "bilinear", "trapezoidal", "exponential")
TENSION = {  # strength by the formulas of the page [Pa]
    "constant_threshold": 0.25e6, "mohr_coulomb": 0.25e6, "elastic_brittle": 0.25e6, "mortar": 0.25e6,
    "fremond_cangemi": np.sqrt(2.0 * 3e10), "elastic": 82e9 * 20e-6, **dict.fromkeys(SOFTENING, 0.25e6),
}  # fmt: skip
COHESION = {  # shear strength without pressure [Pa]
    "dry": 0.0, "constant_threshold": FRICTION * 0.25e6, "mohr_coulomb": 0.35e6, "elastic_brittle": 0.35e6,
    "mortar": 0.35e6, "closure": 0.0, "dilatancy": 0.0,
    "fremond_cangemi": np.sqrt(2.0 * 3e10), "elastic": 36e9 * 100e-6,
    **dict.fromkeys(SOFTENING, 0.35e6),
}  # fmt: skip
LAYER = 0.74e9 / 0.01 / 1.2  # E/((1 + ν) t) of the mortar's page
DAMAGE = {  # in tension and in shear [J/m²]
    "elastic_brittle": (0.25e6**2 / 2e10, 0.35e6**2 / 2e10),
    "fremond_cangemi": tuple(2.0 * (1 - 2.0 / (3e10 * u**2)) for u in (25e-6, 60e-6)),
    "monerie_acary": (18.0, 125.0), "trapezoidal": (18.0, 125.0), "bilinear": (18.0, 122.47),
    "mortar": (0.25e6**2 / (2 * LAYER * 0.8 / 0.6), 0.35e6**2 / LAYER),
}  # fmt: skip


@pytest.fixture(scope="module")
def maker(repository):
    """The module docs/make_law_images.py."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(repository / "docs")
        yield importlib.import_module("make_law_images")


@pytest.fixture(scope="module")
def stated(repository):
    """The figures that a page states: name to numbers in words."""

    def figures(page):
        text = (repository / f"docs/laws/{page}.md").read_text(encoding="utf-8")
        table = text.split("<!-- figures")[1].split("<!-- end")[0]
        rows = re.findall(r"^\| (.+?) \| (.*?) \|$", table, re.M)
        return {what: [float(number) for number in re.findall(r"[\d.]+", value)] for what, value in rows}

    return figures


def test_every_page_has_its_pictures_and_is_listed(repository, maker):
    assert set(maker.SPECIMENS) == set(PAGES.values())
    joints = (repository / "docs/joints.md").read_text(encoding="utf-8")
    for page in [*PAGES.values(), "identification"]:
        assert f"(laws/{page}.md)" in joints
        assert f"\nlaws/{page}\n" in joints


@pytest.mark.parametrize("name", PAGES)
def test_a_snippet_makes_the_law_of_its_page(name, maker):
    assert maker.law_of(PAGES[name]).name == name


def test_joints_in_the_other_pages_are_joints(repository, maker):
    """Those with laws from files are run by tests/test_add_a_law.py."""
    for page in (repository / "docs").glob("*.md"):
        for snippet in re.findall(r"```toml\n(\[\[joints\]\].*?)```", page.read_text("utf-8"), re.S):
            assert maker.law_in(snippet).name in PAGES


@pytest.mark.parametrize("page", PAGES.values())
def test_a_page_says_what_it_owes(page, repository):
    text = (repository / f"docs/laws/{page}.md").read_text(encoding="utf-8")
    for part in ("Law", "Parameters", "From a test", "Limits", "Checked by"):
        assert f"\n## {part}\n" in text
    for file in re.findall(r"`((?:tests/)?[\w/]*test_\w+\.py)`", text):
        assert list(repository.glob(f"tests/**/{file.removeprefix('tests/')}")), file


@pytest.mark.parametrize("page", TENSION)
def test_tension_is_that_of_the_formulas(page, stated):
    assert stated(page)["strength in tension"][0] == pytest.approx(TENSION[page] / 1e6, abs=0.6e-3)


@pytest.mark.parametrize("page", COHESION)
def test_shear_is_cohesion_and_friction(page, stated):
    slide = next(what.split("after ")[1] for what in stated(page) if "greatest" in what)
    for pressure in UNDER:
        peak = stated(page)[f"shear under {pressure / 1e6:g} MPa: greatest; after {slide}"][0]
        assert peak == pytest.approx((COHESION[page] + FRICTION * pressure) / 1e6, abs=0.6e-3)


@pytest.mark.parametrize("page", DAMAGE)
def test_lost_energies_are_those_of_the_formulas(page, stated):
    lost = [value[0] for what, value in stated(page).items() if what.startswith("lost to damage")]
    assert lost == pytest.approx(DAMAGE[page], abs=0.006)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "steepest", "at"),
    [
        ("bilinear", 0.5, 0.5),
        ("trapezoidal", 1.0, 0.9),
        ("exponential", 1.0, 0.0),
        ("monerie_acary", 4 / 3, 1.0),
    ],
)
def test_a_softening_law_falls_as_steeply_as_its_page_says(page, steepest, at, maker):
    """Slope over s²/(G − s²/2c), ``at`` a part of the way from the peak to where nothing is left."""
    strength, stiffness, energy = 0.25e6, 82e9, 18.0
    end = {"bilinear": 2.0, "trapezoidal": 1.5, "exponential": 2.0, "monerie_acary": 1.5}[page]
    left = energy / strength - strength / stiffness / 2  # m
    path = strength / stiffness + np.linspace(1e-4, end - 1e-4, 2001) * left
    stress = probe(maker.law_of(page), np.stack([path, 0 * path], axis=1)).stress[:, 0]
    slope = -np.diff(stress) / np.diff(path) * left / strength
    assert slope.max() == pytest.approx(steepest, rel=1e-3)
    assert slope[int(at * (len(slope) - 1))] == pytest.approx(steepest, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("page", ["mohr_coulomb", "monerie_acary"])
def test_figures_are_fresh(page, maker):
    """Else run ``python docs/make_law_images.py``."""
    assert maker.main(["--check", page]) == 0


@pytest.mark.slow
def test_all_figures_are_fresh(maker):
    assert maker.main(["--check"]) == 0


def test_pictures_are_there_and_light(repository, maker):
    for name in [*maker.SPECIMENS, "shapes"]:
        assert 5_000 < (repository / f"docs/images/laws/{name}.png").stat().st_size < 60_000


def test_probe_on_the_page_of_tests_gives_what_it_says(repository):
    text = (repository / "docs/laws/identification.md").read_text(encoding="utf-8")
    found: dict[str, object] = {}
    exec(re.search(r"```python\n(.*?)```", text, re.S)[1], found)
    assert found["peak"] == pytest.approx(0.725e6, rel=1e-3)
    assert found["plateau"] == pytest.approx(0.375e6, rel=1e-9)
    assert found["area"] == pytest.approx(125.0, rel=0.02)

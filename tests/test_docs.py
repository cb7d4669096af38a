"""The documentation says what the program does: generated parts are fresh, links lead somewhere."""

import importlib.util
import re
from pathlib import Path

import msgspec
import pytest
from PIL import Image

from masonry_fem.analyses.run import solve_scene
from masonry_fem.output.terminal import print_summary
from masonry_fem.records.told import plain
from masonry_fem.scene import loads, specs
from masonry_fem.scene.specs import Loads, Material, Scene
from masonry_fem.structures.stack import StackStructure

ROOT = Path(__file__).parents[1]
PAGES = [str(page.relative_to(ROOT)) for page in sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])]


@pytest.fixture(scope="module")
def reference(repository):
    """The module docs/scene_reference.py."""
    spec = importlib.util.spec_from_file_location("scene_reference", repository / "docs/scene_reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_scene_reference_is_fresh(reference):
    """The keys on the pages of laws, too; else run ``python docs/scene_reference.py``."""
    assert reference.main(["--check"]) == 0


def test_every_record_and_key_is_explained(reference):
    records = {
        one
        for one in vars(specs).values()
        if isinstance(one, type) and issubclass(one, msgspec.Struct) and one.__struct_fields__
    }
    assert records <= {*reference.TABLES, specs.Structure, specs.Strategy}  # these are bases


def test_a_key_without_a_meaning_is_named(reference, monkeypatch):
    monkeypatch.setattr(StackStructure, "__doc__", "Stack of boxes.")
    with pytest.raises(SystemExit, match=r"stack\.py: the key 'size' of StackStructure .*write 'size : "):
        reference.page()


@pytest.mark.parametrize("page", PAGES)
def test_links_of_a_page_lead_somewhere(page, repository):
    """To a file, and in it to a heading or an anchor; from pages of the site to no file outside of it."""
    file = repository / page
    lost = []
    for link in re.findall(r"\]\(([^)\s]+)\)", without_code(file)):
        name, _, place = link.partition("#")
        target = file.parent / name if name else file
        known = "://" in link or (target.exists() and (not place or place in anchors(target)))
        strays = page.startswith("docs/") and name.endswith(".md") and leaves(target, ROOT / "docs")
        lost += [] if known and not strays else [link]
    assert lost == []


def leaves(target, folder):
    return folder not in target.resolve().parents


def without_code(page):
    return re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)


def anchors(page):
    """Places of a page that links can name: in docs, headings of two levels (``myst_heading_anchors``)."""
    text = without_code(page)
    levels = "#{1,2}" if (ROOT / "docs") in page.resolve().parents else "#+"
    plain = [
        re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", line)
        for line in re.findall(rf"^{levels} (.*)$", text, re.MULTILINE)
    ]
    headings = [re.sub(r"[^\w\- ]", "", line.strip().lower()).replace(" ", "-") for line in plain]
    return {*headings, *re.findall(r'id="([^"]+)"', text)}


def test_pictures_are_whole(repository):
    pictures = sorted((repository / "docs").rglob("images/*.png"))
    assert len(pictures) > 50
    for picture in pictures:
        with Image.open(picture) as image:
            image.load()  # raises where the file ends too early


def test_the_beam_of_the_page_on_pre_stress_says_what_the_page_says(repository):
    page = (repository / "docs/reached.md").read_text(encoding="utf-8")
    ((scene, said),) = re.findall(
        r"`beam\.toml`:\n\n```toml\n(.*?)```.*?says\n\n((?:    [^\n]*\n)+)", page, re.S
    )
    assert solve_scene(loads(scene)).message == " ".join(said.split())


def test_the_arch_of_the_page_on_strength_says_what_the_page_says(repository, capsys):
    page = (repository / "docs/strength.md").read_text(encoding="utf-8")
    ((scene, said),) = re.findall(r"```toml\n(.*?)```.*?The console says\n\n((?:    [^\n]*\n)+)", page, re.S)

    def console(*changes):
        print_summary(plain(solve_scene(loads(scene, changes)).summary))
        return " ".join(capsys.readouterr().out.split())

    assert " ".join(said.split()) in console()
    assert "arch.v04 0.34 ±" in console("design.loads.gravity=2.7", "design.loads.points=3")
    assert "arch.v02 0.95 ±" in console("design.loads.points=3")


def test_results_page_lists_every_key_of_the_summary(repository):
    stack = StackStructure(name="s", material="m", size=(1.0, 1.0), count=1)
    material = Material(density=2000.0)
    scene = Scene(dimension=2, fidelity="rigid", materials={"m": material}, structures=(stack,),
                  loads=Loads(gravity=(0.0, -10.0)))  # fmt: skip
    summary = plain(solve_scene(scene).summary)
    text = (repository / "docs" / "results.md").read_text(encoding="utf-8")
    keys = [
        *summary,
        *(key for part in ("certificate", "energy", "seconds", "solver") for key in summary[part]),
    ]
    assert [key for key in keys if f"`{key}`" not in text] == []


def test_pages_of_parts_are_fresh(repository):
    """Else run ``python docs/make_parts.py``."""
    spec = importlib.util.spec_from_file_location("make_parts", repository / "docs/make_parts.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.main(["--check"]) == 0
    made = dict(module.pages())
    assert {"contact_solver_newton.md", "analysis_statics.md", "material_brittle_damage.md"} <= set(made)

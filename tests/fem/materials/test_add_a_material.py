"""docs/add_a_material.md followed literally: its law conforms, and its mistake is told as the page says."""

import re
import sys
from importlib.util import module_from_spec, spec_from_file_location

import pytest

from masonry_fem.fem.material_conformance import violations


@pytest.fixture(name="page")
def _page(repository):
    return (repository / "docs/add_a_material.md").read_text(encoding="utf-8")


@pytest.fixture(name="law")
def _law(page, tmp_path, monkeypatch):
    """Makes the class of the page's file, with some of its text replaced."""
    (block,) = re.findall(r"`[\w/]*compaction\.py`:\n\n```python\n(.*?)```", page, re.S)

    def made(old="", new=""):
        assert old in block
        path = tmp_path / "compaction.py"
        path.write_text(block.replace(old, new) if old else block, encoding="utf-8")
        spec = spec_from_file_location("compaction", path)
        module = module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "compaction", module)
        spec.loader.exec_module(module)
        return module.Compaction(crushing_pressure=4e6)

    return made


def test_the_law_of_the_page_conforms(law):
    assert violations(law(), strain=1e-3) == []


def test_the_mistake_of_the_page_is_told_as_it_says(law, page):
    told = violations(law("grown = volume", "grown = -volume"), strain=1e-3)
    shown = re.search(r"the answer is\n\n((?:    .*\n)+)", page)[1]
    assert [line.strip() for line in shown.splitlines()] == told


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("flat = elastic.matrix - ", "flat = elastic.matrix - 0.5 * ", "the tangent is not the derivative"),
        (
            "stress = trial - ",
            "stress = 1.01 * trial - ",
            "small strains of the fresh material are not elastic",
        ),
        ("/ 3 * UNIT", "* np.array([1.0, 0, 0, 0, 0, 0])", "a step that goes nowhere changes the stress"),
        (
            "nothing = ",
            "committed[:, 0] += 1.0\n        nothing = ",
            "committed internal variables are changed",
        ),
    ],
)
def test_mistakes_are_told(law, old, new, sentence):
    assert any(one.startswith(sentence) for one in violations(law(old, new), strain=1e-3))


def test_strains_that_are_too_small_are_told(law):
    assert any(one.startswith("nothing yields at strains of 1e-06") for one in violations(law(), strain=1e-6))

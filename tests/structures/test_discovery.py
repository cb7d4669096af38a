"""Discovery: a file that is put into the folder is a structure; what it lacks is said in a sentence."""

import os
import subprocess
import sys

import pytest

from masonry_fem.errors import ExtensionError
from masonry_fem.structures.parts.discovery import discovered

HEAD = """
from masonry_fem.records.record import Sizes
from masonry_fem.records.structure import Structure
"""
RECORD = """
class {name}(Structure, frozen=True, kw_only=True{tag}):
    size: Sizes
"""
BUILD = """
def build(spec, dimension):
    return None
"""


def pier(name="PierStructure", kind="pier"):
    """Source of a record; without a ``kind`` of its own where that is empty."""
    return RECORD.format(name=name, tag=f', tag="{kind}"' if kind else "")


@pytest.fixture
def found(tmp_path, monkeypatch):
    """Kinds of a package of these files."""

    def look(**files):
        package = f"rooms_{tmp_path.name}"
        folder = tmp_path / package
        (folder / "parts").mkdir(parents=True)  # which holds no structures
        for place in (folder, folder / "parts"):
            (place / "__init__.py").touch()
        for name, text in files.items():
            (folder / f"{name}.py").write_text(HEAD + text, encoding="utf-8")
        monkeypatch.syspath_prepend(tmp_path)
        return discovered(package, [str(folder)])

    return look


def test_a_file_is_a_kind(found):
    kinds = found(pier=pier() + BUILD, slab=pier("SlabStructure", "slab") + BUILD)
    kind = kinds["pier"]
    assert list(kinds) == ["pier", "slab"]
    assert kind.record.__name__ == "PierStructure"
    assert kind.build(None, 3) is None
    assert kind.file.endswith("pier.py")


@pytest.mark.parametrize(
    ("files", "sentence"),
    [
        ({"pier": BUILD}, r"pier\.py has 0 records of a structure \(none\), expected one.*folder 'parts'"),
        (
            {"pier": pier() + pier("SlabStructure", "slab") + BUILD},
            r"pier\.py has 2 records of a structure \(PierStructure, SlabStructure\), expected one.*its own",
        ),
        ({"pier": pier(kind="") + BUILD}, r'pier\.py: PierStructure has no kind.*write .*tag="name"\)'),
        ({"pier": pier()}, r"pier\.py has no function build.*write def build\(spec: PierStructure, "),
        ({"pier": pier() + "build = 3"}, r"pier\.py has no function build"),
        (
            {"pier": pier() + BUILD, "slab": pier("SlabStructure") + BUILD},
            r"slab\.py and .*pier\.py both have the kind 'pier'.*another tag",
        ),
    ],
    ids=["no record", "two records", "no kind", "no build", "no function", "one kind twice"],
)
def test_what_a_file_lacks_is_said(found, files, sentence):
    with pytest.raises(ExtensionError, match=sentence):
        found(**files)


SCENE = """
fidelity = "rigid"
materials.stone.density = 2400.0
structures = [{ kind = "block", name = "it", material = "stone", size = [1.0, 1.0, 0.5] }]
"""
CHECK = """
import sys
import masonry_fem.structures
from masonry_fem.cli import main
masonry_fem.structures.__path__.append(sys.argv[1])
sys.exit(main(["check", "scene.toml"]))
"""


def test_the_command_line_says_what_a_new_file_lacks(tmp_path, repository):
    (tmp_path / "pier.py").write_text(HEAD + pier(), encoding="utf-8")
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", CHECK, str(tmp_path)],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(repository)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert "pier.py has no function build, expected one that makes the blocks" in done.stderr

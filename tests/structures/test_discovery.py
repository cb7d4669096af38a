"""What a file among the structures lacks is said by every command."""

import os
import subprocess
import sys

PIER = """
from masonry_fem.records.record import Sizes
from masonry_fem.records.structure import Structure

class PierStructure(Structure, frozen=True, kw_only=True, tag="pier"):
    size: Sizes
"""
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
    (tmp_path / "pier.py").write_text(PIER, encoding="utf-8")
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", CHECK, str(tmp_path)],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(repository)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert "pier.py has no function build, expected one that makes the blocks" in done.stderr

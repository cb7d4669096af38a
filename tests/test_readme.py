"""What the README tells a newcomer to type and to look at exists and is understood."""

import re

import pytest

from masonry_fem.cli import parser
from masonry_fem.scene import loads


@pytest.fixture(scope="module")
def readme(repository):
    return (repository / "README.md").read_text(encoding="utf-8")


def test_first_screen_has_the_picture_and_the_two_commands(readme):
    first_screen = readme.split("## ")[0]
    assert len(first_screen.splitlines()) < 24
    assert "docs/images/arch.png" in first_screen
    assert re.findall(r"^make (\w+)", first_screen, re.M) == ["demo", "test"]


def test_make_targets_exist(readme, repository):
    targets = set(re.findall(r"^(\w+):", (repository / "Makefile").read_text(encoding="utf-8"), re.M))
    contributing = (repository / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"(?:^|`)make (\w+)", readme + contributing, re.M))
    assert named >= {"demo", "test", "lint"}
    assert named <= targets


def test_links_lead_somewhere(readme, repository):
    links = re.findall(r"\]\(([^)#]+)\)", readme)
    here = [link for link in links if "://" not in link]
    assert len(here) >= 5
    assert [link for link in here if not (repository / link).exists()] == []


def test_scene_example_is_a_scene(readme):
    scene = loads(re.search(r"```toml\n(.*?)```", readme, re.S)[1])
    assert scene.structures[0].courses == 5
    assert scene.materials["limestone"].young == pytest.approx(10e9)


def test_commands_are_understood(readme):
    """Every command of the table parses, with files standing for its placeholders."""
    commands = re.findall(r"^\| `masonry-fem ([^`]+)` \|", readme, re.M)
    assert {line.split()[0] for line in commands} == {
        "run", "check", "limit", "collapse", "threshold", "study", "mesh", "resume", "view", "report",
        "contact", "compile", "new", "explain", "completion", "info",
    }  # fmt: skip
    for line in commands:
        options = parser().parse_args(re.sub(r"[][]", "", line).split())
        assert callable(options.command)

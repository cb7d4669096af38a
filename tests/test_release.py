"""What a release states in several places is the same in each."""

import re
import tomllib

import masonry_fem


def test_one_version(repository):
    package = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (repository / "CITATION.cff").read_text(encoding="utf-8")
    assert package["version"] == masonry_fem.__version__
    assert re.findall(r"^version: (.+)$", citation, re.MULTILINE) == [masonry_fem.__version__]
    changes = (repository / "CHANGELOG.md").read_text(encoding="utf-8")
    sections = re.findall(r"^## \[(.+?)\]", changes, re.MULTILINE)
    assert sections[:2] == ["Unreleased", masonry_fem.__version__]


def test_pages_for_the_host_lead_somewhere(repository):
    for page in ("SECURITY.md", "RELEASING.md", "CONTRIBUTING.md"):
        text = (repository / page).read_text(encoding="utf-8")
        links = [link for link in re.findall(r"\]\(([^)#]+)", text) if "://" not in link]
        assert links
        assert [link for link in links if not (repository / link).exists()] == []


def test_the_workflow_runs_targets_of_the_makefile(repository):
    targets = set(re.findall(r"^([\w-]+):", (repository / "Makefile").read_text(encoding="utf-8"), re.M))
    workflow = (repository / ".github" / "workflows" / "checks.yml").read_text(encoding="utf-8")
    run = set(re.findall(r"make ([\w-]+)", workflow))
    assert {"test-all", "test-kernels", "lint", "docs", "wheel", "demo"} <= run <= targets


def test_files_that_contributing_names_exist(repository):
    text = (repository / "CONTRIBUTING.md").read_text(encoding="utf-8")
    folders = ("masonry_fem", "tests", "docs", "tools", "benchmarks")
    known = {f"/{path.as_posix()}" for folder in folders for path in (repository / folder).rglob("*.py")}
    named = set(re.findall(r"`([\w/]+\.py)`", text)) - {"utils.py"}  # which is never to be
    assert len(named) > 20
    assert [name for name in sorted(named) if not any(path.endswith(f"/{name}") for path in known)] == []

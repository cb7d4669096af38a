"""What a release states in several places is the same in each."""

import re
import tomllib

import masonry_fem


def test_one_version(repository):
    package = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (repository / "CITATION.cff").read_text(encoding="utf-8")
    assert package["version"] == masonry_fem.__version__
    assert re.findall(r"^version: (.+)$", citation, re.MULTILINE) == [masonry_fem.__version__]


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
    assert {"test", "test-kernels", "lint", "docs", "wheel", "demo"} <= run <= targets

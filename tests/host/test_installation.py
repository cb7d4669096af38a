"""What is asked of a machine, and the sentence where it lacks it."""

import pytest

from masonry_fem.errors import InstallationError
from masonry_fem.host import installation


def test_a_missing_dolfinx_is_told_with_its_cure(monkeypatch):
    monkeypatch.setattr(installation, "dolfinx_version", lambda: None)
    with pytest.raises(InstallationError, match=r"need DOLFINx, which is not installed; install it \(pip"):
        installation.require_fenicsx()


@pytest.mark.parametrize("old", ["0.5.2", "0.8.0.post1"])
def test_an_old_dolfinx_is_refused(monkeypatch, old):
    monkeypatch.setattr(installation, "dolfinx_version", lambda: old)
    with pytest.raises(InstallationError, match=rf"DOLFINx {old} is too old, expected 0.9 or later"):
        installation.require_fenicsx()


@pytest.mark.parametrize("good", ["0.9.0", "0.10", "0.11.0.post0", "1.0rc1"])
def test_a_recent_dolfinx_is_taken(monkeypatch, good):
    monkeypatch.setattr(installation, "dolfinx_version", lambda: good)
    installation.require_fenicsx()


def test_a_missing_compiler_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(InstallationError, match=r"need a C compiler and none was found; install one"):
        installation.require_compiler()
    monkeypatch.setenv("CC", "nocc -O2")
    with pytest.raises(InstallationError, match=r"CC is 'nocc -O2', which cannot be run"):
        installation.require_compiler()


def test_a_named_compiler_is_taken(monkeypatch, tmp_path):
    mycc = tmp_path / "mycc"
    mycc.write_text("#!/bin/sh\n")
    mycc.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CC", "mycc -m64")
    installation.require_compiler()


def test_missing_renderers_are_told(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(installation, "_loadable", lambda name: False)
    monkeypatch.setattr(installation.sys, "platform", "linux")
    told = installation.why_no_pictures()
    assert "neither libEGL nor libOSMesa can be loaded and there is no X server; install" in told
    monkeypatch.setattr(installation, "_loadable", lambda name: name == "libOSMesa.so.8")
    assert installation.why_no_pictures() is None
    assert installation.renderers() == ("OSMesa",)


@pytest.mark.parametrize(
    ("text", "numbers"), [("0.11.0.post0", (0, 11, 0)), ("1.0rc1", (1, 0)), ("x", ()), ("2", (2,))]
)
def test_versions_are_compared_by_their_numbers(text, numbers):
    assert installation.numbers_of(text) == numbers


def test_the_report_names_a_cure_for_what_is_missing(monkeypatch):
    monkeypatch.setattr(installation, "dolfinx_version", lambda: None)
    findings = {finding.name: finding for finding in installation.report()}
    assert findings["dolfinx"].state == "missing"
    assert "pip install 'masonry-fem[fenicsx]'" in findings["dolfinx"].cure
    assert findings["numpy"].cure == ""

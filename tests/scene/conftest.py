"""Scenes that the tests of this folder share."""

from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def everything() -> Path:
    """A scene file in which every record occurs."""
    return HERE / "arch_and_wall.toml"


@pytest.fixture(scope="session")
def arch() -> str:
    """The text of a small sound scene."""
    return (HERE / "arch.toml").read_text()

"""The names that scripts import from ``masonry_fem`` itself."""

import inspect
import subprocess
import sys

import pytest

import masonry_fem


def test_every_public_name_is_there_and_documented():
    for name in masonry_fem.__all__:
        assert name in dir(masonry_fem)
        assert inspect.getdoc(getattr(masonry_fem, name)), name


def test_a_name_that_is_not_there_is_told_with_those_that_are():
    names = "Scene, check, collapse, load, refine, resume, run, save, solve, steps, study, threshold"
    with pytest.raises(AttributeError, match=f"no 'sovle'; its names are {names}"):
        _ = masonry_fem.sovle


def test_nothing_heavy_is_loaded_before_it_is_used():
    code = (
        "import sys, masonry_fem\n"
        "dir(masonry_fem)\n"
        "assert not {'numpy', 'numba', 'dolfinx', 'gmsh', 'pyvista'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_scene_that_is_only_read_loads_neither_scipy_nor_numba():
    """``check`` and editors wait for what this loads."""
    code = "import masonry_fem.scene, sys; assert not {'scipy', 'numba'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_docs_have_every_public_function(repository):
    page = (repository / "docs" / "api.md").read_text(encoding="utf-8")
    functions = [
        name for name in masonry_fem.__all__ if name != "Scene"
    ]  # whose keys are the scene reference
    assert [name for name in functions if f":: masonry_fem.{name}\n" not in page] == []

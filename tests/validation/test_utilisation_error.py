"""The error beside a utilisation: estimated against that of elements half as large."""

import numpy as np
import pytest

from masonry_fem import load, solve
from masonry_fem.build.strengths import strengths_of
from masonry_fem.output.utilisation import stone_utilisation

ARCH = (
    "demos/arch.toml",
    "limestone",
    '{element="Q1",divisions=[3,1,4]}',
    '{element="Q2",divisions=[6,2,8]}',
)
WALL = ("demos/low_wall.toml", None, '{element="Q1",divisions=[4,2,2]}', '{element="Q1",divisions=[8,4,4]}')


def utilisation(path, material, mesh, strengths):
    scene = load(path)
    material = material or next(iter(scene.materials))
    keys = [f"materials.{material}.{key}='{value}'" for key, value in strengths.items()]
    scene = load(path, overrides=[f"mesh={mesh}", *keys])
    made = solve(scene)
    return stone_utilisation(made.march.model, made.march.state, strengths_of(scene, made.built.stones))


@pytest.mark.slow
@pytest.mark.parametrize(("path", "material", "coarse", "fine"), [ARCH, WALL], ids=["arch", "wall"])
@pytest.mark.parametrize(
    "strengths",
    [
        {"compressive_strength": "1 MPa", "tensile_strength": "1 GPa"},
        {"compressive_strength": "10 GPa", "tensile_strength": "0.1 MPa"},
        {"compressive_strength": "1 MPa", "tensile_strength": "0.1 MPa"},
    ],
    ids=["pressure", "tension", "both"],
)
def test_the_estimate_has_the_size_of_the_error(repository, path, material, coarse, fine, strengths):
    """Root mean square over the stones: between .7 and 6 times the true one."""
    first = utilisation(repository / path, material, coarse, strengths)
    truth = utilisation(repository / path, material, fine, strengths)
    known = ~np.isnan(first.local)
    true = np.sqrt(np.mean((first.local - truth.local)[known] ** 2))
    told = np.sqrt(np.mean(first.error[known] ** 2))
    assert 0.7 <= told / true <= 6.0
    assert np.sqrt(np.mean(truth.error[known] ** 2)) < told

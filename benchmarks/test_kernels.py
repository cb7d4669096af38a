"""Kernels under pytest-benchmark: `pytest benchmarks --benchmark-enable`."""

from pathlib import Path

import pytest

from benchmarks.cases import scene, wall
from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.contact.detection import detect
from masonry_fem.scene import check
from masonry_fem.scene.specs import Dynamics, MeshSettings


@pytest.fixture(scope="module")
def thousand():
    return build(check(scene(wall(32, 31), fidelity="rigid")), Path()).model.assembly


def test_pairing_of_a_thousand_bricks(benchmark, thousand):
    """Bar: under 1 s."""
    assert len(benchmark(detect, thousand)) > 2000


def test_build_of_meshed_bricks(benchmark):
    given = check(scene(wall(10, 10), mesh=MeshSettings(size=0.1)))
    assert benchmark(build, given, Path()).model.contacts.count > 1000


def test_step_of_a_rigid_wall(benchmark):
    given = check(scene(wall(5, 5), fidelity="rigid", analysis=Dynamics(step=0.01, duration=0.01)))
    assert benchmark(solve_scene, given).outcome == "finished"

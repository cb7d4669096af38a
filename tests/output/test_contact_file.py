"""Contact files: what a step found, and what others make of it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.analyses.run import run
from masonry_fem.cli import main
from masonry_fem.nscd import SolverSettings, load_problem, solve
from masonry_fem.scene.specs import (
    Dynamics,
    Joint,
    Loads,
    Material,
    Motion,
    Output,
    Scene,
    Statics,
    Support,
    Table,
)
from masonry_fem.structures.stack import StackStructure


def saved(tmp_path, analysis, **keys):
    """Arrays of a step of a stack on ground that leans."""
    stack = StackStructure(name="s", material="stone", size=(1.0, 0.5), count=3)
    lean = Motion(rotation=0.1, time=Table(points=((0.0, 0.0), (1.0, 1.0))))
    scene = Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": Material(density=2400.0)},
        structures=(stack,),
        supports=(Support(on="s.ground", motion=lean),),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=(0.0, -9.81)),
        analysis=analysis,
        output=Output(fields=False, pictures=False),
        **keys,
    )
    run(scene, tmp_path / "out", save_contact=1)
    path = tmp_path / "out" / "contact_1.npz"
    with np.load(path) as file:
        return path, {name: file[name] for name in file.files}


def test_a_static_step_balances_from_its_file_alone(tmp_path):
    """Bᵀp + f_r = 0, and forces at points balance the weights of the turned stones."""
    path, told = saved(tmp_path, Statics())
    assert "W_data" not in told  # without inertia there is no plain form
    pushed = np.zeros_like(told["rigid_impulse"])
    for side in (0, 1):
        body = told["bodies"][:, side]
        own = np.einsum("kdm,kd->km", told["rigid_map"][:, side], told["impulse"])
        np.add.at(pushed, body[body >= 0], own[body >= 0])
    size = np.abs(told["rigid_impulse"]).max()
    np.testing.assert_allclose(pushed, -told["rigid_impulse"], atol=1e-8 * size)
    assert told["frame"][0, 0, 1] == pytest.approx(np.cos(0.1) * np.sign(told["frame"][0, 0, 1]), abs=1e-9)
    force = np.einsum("kij,ki->kj", told["frame"], told["impulse"]) / told["h"]
    names = told["block_names"].tolist()
    ground = told["blocks"] == names.index("s.ground")
    given = (force * (ground[:, 1].astype(float) - ground[:, 0])[:, None]).sum(axis=0)
    np.testing.assert_allclose(given, [0.0, 3 * 0.5 * 2400 * 9.81], atol=1e-4)
    assert told["body_names"].tolist() == ["s.b1", "s.b2", "s.b3"]
    assert told["area"].sum() == pytest.approx(3.0)
    again = solve(load_problem(path), SolverSettings())
    assert again.solved


def test_a_dynamic_step_has_the_plain_form_beside_its_solution(tmp_path, capsys):
    path, told = saved(tmp_path, Dynamics(step=1e-3, duration=1e-3))
    W = sparse.csr_array((told["W_data"], told["W_indices"], told["W_indptr"]), shape=tuple(told["shape"]))
    v = W @ told["impulse"].ravel() + told["q"]
    np.testing.assert_allclose(v, told["velocity"].ravel(), atol=1e-12)
    assert (told["mu"] == told["friction"]).all()
    assert main(["contact", str(path)]) == 0
    assert json.loads(capsys.readouterr().out)["contacts"] == len(told["mu"])
    # a file of an earlier version, and one with the plain form alone
    first = ("impulse", "velocity", "U", "contact", "blocks", "frame", "points", "gap", "area", "h", "theta")
    plain = ("W_data", "W_indices", "W_indptr", "shape", "q", "mu", "dim")
    old = {name: values for name, values in told.items() if name not in (*first, *plain)}
    for arrays in (old, {name: told[name] for name in plain}):
        np.savez(tmp_path / "other.npz", **arrays)
        assert main(["contact", str(tmp_path / "other.npz")]) == 0
        assert json.loads(capsys.readouterr().out)["outcome"] == "converged"

"""An arch whose centring is struck: the drop of its crown is that of an elastic arch that is clamped."""

from __future__ import annotations

import math

import numpy as np
import pytest

from masonry_fem.analyses.run import run
from masonry_fem.scene import loads

RADIUS, THICK, EMBRACE, YOUNG, WEIGHT = 3.0, 0.2, 95.0, 1e9, 2000.0 * 10.0 * 0.2
SCENE = """
dimension = 2
fidelity = "elastic"
mesh = {{ element = "Q2", divisions = [2, 4] }}
loads.gravity = [0.0, -10.0]
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.0 }}
supports = [{{ on = "centring.*" }}]
joints = [{{ friction = 3.0 }}, {{ between = ["centring.*", "arch.*"], friction = 0.0 }}]
probes = [{{ name = "crown", block = "arch.v08", point = [0.0, 3.0] }}]
output = {{ pictures = false, fields = false }}

[[structures]]
kind = "arch"
name = "arch"
material = "stone"
radius = 3.0
thickness = 0.2
voussoirs = 15
straight = true
embrace = 95

[[structures]]
kind = "arch"
name = "centring"
material = "stone"
radius = 2.85
thickness = 0.1
voussoirs = 15
straight = true
embrace = 95
springings = false

[[stages]]
name = "built"

[[stages]]
name = "struck"
without = ["centring.*"]
analysis = {{ kind = "statics", load_steps = {steps} }}
"""


def clamped_arch() -> tuple[float, float]:
    """Thrust [N/m] and drop of the crown [m] of a circular arch under its weight, by the principle of work.

    Bending, axial force and shear (k = 5/6) over the half from the crown; thrust and moment there are what
    neither turns nor parts it.

    References
    ----------
    S. Timoshenko, Strength of Materials, part II, §§ 16 to 18 (1941).
    """
    points, weights = np.polynomial.legendre.leggauss(40)
    half = math.radians(EMBRACE / 2)
    phi, ds = 0.5 * half * (points + 1), 0.5 * half * weights * RADIUS
    sine, cosine = np.sin(phi), np.cos(phi)
    ones, zero = np.ones_like(phi), np.zeros_like(phi)
    # moment, axial force and shear by unit moment and thrust at the crown, by the weight, by a unit drop
    moment = np.array([ones, RADIUS * (1 - cosine)])
    axial, shear = np.array([zero, cosine]), np.array([zero, sine])
    load = [
        -WEIGHT * RADIUS**2 * (phi * sine - 1 + cosine),
        WEIGHT * RADIUS * phi * sine,
        -WEIGHT * RADIUS * phi * cosine,
    ]
    unit = [-0.5 * RADIUS * sine, 0.5 * sine, -0.5 * cosine]
    give = [12 / (YOUNG * THICK**3), 1 / (YOUNG * THICK), 1 / (5 / 6 * YOUNG / 2 * THICK)]
    forces = (moment, axial, shear)
    matrix = sum(c * np.einsum("is,js,s->ij", one, one, ds) for c, one in zip(give, forces, strict=True))
    right = sum(c * one @ (ds * own) for c, one, own in zip(give, forces, load, strict=True))
    crown = np.linalg.solve(matrix, -right)
    whole = [own + crown @ one for own, one in zip(load, forces, strict=True)]
    drop = 2 * sum(c * (own * one) @ ds for c, own, one in zip(give, whole, unit, strict=True))
    return float(crown[1]), float(drop)


@pytest.mark.parametrize("steps", [1, 10])
def test_the_crown_drops_as_that_of_a_clamped_elastic_arch(steps, tmp_path):
    made = run(loads(SCENE.format(steps=steps)), tmp_path)
    assert made.outcome == "equilibrium"
    model, state = made.march.model, made.march.state
    radial = np.array([one.label == "radial" for one in model.interfaces])[model.contacts.interface]
    assert (state.reaction[radial, 0] > 0).all()  # joints are closed all over
    thrust, drop = clamped_arch()
    assert made.summary.supports["arch.springing_left"].force[0] == pytest.approx(thrust, rel=2e-2)
    assert -made.march.report.probes["crown"][1] == pytest.approx(drop, rel=2e-2)

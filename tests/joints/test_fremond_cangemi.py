"""Frémond–Cangémi at one point against closed forms. Set S: c = 1e10 N/m³, w = 50 J/m²."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import FremondCangemi, probe, pull

C, ENERGY = 1e10, 50.0
U0, S0 = np.sqrt(ENERGY / C), np.sqrt(ENERGY * C)


def law(**changes):
    values = {"normal_stiffness": C, "tangential_stiffness": C, "energy": ENERGY, "friction": 0.6}
    return FremondCangemi(**(values | changes))


def opening(*stretches):
    return np.array([[x * U0, 0.0] for x in stretches])


def test_tension_follows_the_hyperbola():
    """A7.1: r = w²/(c u³) past the peak."""
    table = {1.2: (0.6944444444, 0.5787037037), 1.5: (0.4444444444, 0.2962962963), 2: (0.25, 0.125),
             3: (1 / 9, 1 / 27), 5: (0.04, 0.008), 10: (0.01, 0.001)}  # fmt: skip
    history = probe(law(), opening(0.5, 1.0, *table))
    assert history.stress[:2, 0] == pytest.approx([0.5 * S0, S0], rel=1e-12)
    assert history.adhesion[2:] == pytest.approx([beta for beta, _ in table.values()], rel=1e-9)
    assert history.stress[2:, 0] / S0 == pytest.approx([r for _, r in table.values()], rel=1e-9)
    exact = np.array(list(table))
    assert history.stress[2:, 0] == pytest.approx(S0 / exact**3, rel=1e-12)
    assert history.dissipated == pytest.approx(ENERGY * (1 - history.adhesion), abs=1e-10)


@pytest.mark.slow
def test_area_below_the_curve_is_the_energy():
    path = opening(1.0, *np.geomspace(1, 1e3, 2001)[1:])
    history = probe(law(), path)
    assert history.work()[-1] == pytest.approx(ENERGY, rel=2e-5)  # trapezoids of 0.2 %
    assert history.dissipated[-1] + history.stored[-1] == pytest.approx(ENERGY, rel=1e-6)


def test_unloads_to_the_origin_and_closes_rigid():
    """A7.2."""
    history = probe(law(), opening(2, 1, 0, 1, 2))
    assert history.adhesion == pytest.approx([0.25] * 5, rel=1e-12)
    assert history.stress[:, 0] / S0 == pytest.approx([0.125, 0.0625, 0, 0.0625, 0.125], abs=1e-12)
    pressed = probe(law(), opening(0), pressure=1e6, state=history.state, start=[2 * U0, 0.0])
    assert pressed.jump[-1, 0] == 0.0
    assert pressed.stress[-1, 0] == -1e6
    assert pressed.adhesion[-1] == history.adhesion[-1]
    with pytest.raises(LawError, match="rigid in compression"):
        probe(law(), opening(-0.1))


def viscous_run(V, last, steps, **changes):
    """Constant rate of opening; V = b v/(w u0)."""
    b = 10.0
    rate = V * ENERGY * U0 / b
    x = np.linspace(0, last, steps + 1)[1:]
    history = probe(law(viscosity=b, **changes), opening(*x), step=last * U0 / rate / steps)
    return x, history


@pytest.mark.slow
def test_viscous_tension():
    """A7.3, from the differential equation dβ/dx = −(β x² − 1)⁺/V."""
    x, history = viscous_run(0.1, 3.0, 1500)
    r = history.stress[:, 0] / S0
    assert r.max() == pytest.approx(1.013260, rel=5e-3)
    assert x[r.argmax()] == pytest.approx(1.0274, rel=5e-3)
    assert np.interp([2.0, 3.0], x, r) == pytest.approx([0.131776, 0.037598], rel=5e-3)
    x, history = viscous_run(0.01, 1.2, 1500)
    r = history.stress[:, 0] / S0
    assert r.max() == pytest.approx(1.001365, rel=1e-3)
    assert x[r.argmax()] == pytest.approx(1.0029, rel=1e-3)


@pytest.mark.slow
def test_viscous_work():
    """Up to 50 u0; beyond 8 u0 (β ≈ 1/64) in coarser steps."""
    b, V = 10.0, 0.1
    slow, fast = np.linspace(0, 8, 2001)[1:], np.linspace(8, 50, 501)[1:]
    pace = b / (V * ENERGY)  # time of one u0
    first = probe(law(viscosity=b), opening(*slow), step=pace * 8 / 2000)
    then = probe(
        law(viscosity=b), opening(*fast), step=pace * 42 / 500, state=first.state, start=first.jump[-1]
    )
    assert then.dissipated[-1] / ENERGY == pytest.approx(1.07241, rel=5e-3)
    assert then.dissipated[-1] + then.stored[-1] == pytest.approx(
        first.work()[-1] + then_work(first, then), rel=5e-3
    )


def then_work(first, then):
    jump = np.concatenate([first.jump[-1:], then.jump])[:, 0]
    stress = np.concatenate([first.stress[-1:], then.stress])[:, 0]
    return np.trapezoid(stress, jump)


def held(k, steps, end=1.0):
    """β after holding u = k u0 for ``end`` τ, τ = b/w."""
    b = 10.0
    history = probe(law(viscosity=b), opening(*[k] * steps), step=end * b / ENERGY / steps,
                    start=[k * U0, 0.0])  # fmt: skip
    return history.adhesion[-1]


@pytest.mark.slow
def test_viscous_held_opening():
    """A7.4, and first order in the step."""
    k = 1.5
    for end, value in ((0.1, 0.888065), (0.5, 0.624807), (1.0, 0.503000)):
        exact = 1 / k**2 + (1 - 1 / k**2) * np.exp(-(k**2) * end)
        assert exact == pytest.approx(value, abs=1e-6)
        assert held(k, 400, end) == pytest.approx(value, rel=5e-3)
        errors = np.array([abs(held(k, n, end) - exact) for n in (100, 200, 400)])
        assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("exponent", [0.5, 2.0])
def test_exponent_of_viscosity(exponent):
    """b β̇ = −(β Y − w)^(1/p) held at k: separable, β Y − w =: z, b ż = −Y z^(1/p)."""
    k, b, end = 1.5, 10.0, 0.02
    Y, q = ENERGY * k**2, 1 / exponent
    z = (Y - ENERGY) ** (1 - q) - (1 - q) * Y * end / b if q != 1 else 0.0
    exact = (max(z, 0.0) ** (1 / (1 - q)) + ENERGY) / Y
    got = []
    for n in (200, 400):
        history = probe(law(viscosity=b, exponent=exponent), opening(*[k] * n), step=end / n,
                        start=[k * U0, 0.0])  # fmt: skip
        got.append(history.adhesion[-1])
    assert exact < 0.999
    errors = np.abs(np.array(got) - exact)
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)


def test_no_viscosity_is_the_limit():
    quick = probe(law(), opening(0.5, 1.5, 2.0, 1.0))
    for exponent in (1.0, 2.0):
        slow = probe(law(viscosity=1e-9, exponent=exponent), opening(0.5, 1.5, 2.0, 1.0))
        assert slow.adhesion == pytest.approx(quick.adhesion, rel=1e-6)


@pytest.mark.parametrize(
    ("mode", "table"),
    [
        ("damage", {0.5: 0.353553, 1: 0.707107, 1.5: 0.376180, 2: 0.313388, 3: 0.292856, 5: 0.293657}),
        ("constant", {0.5: 0.653553, 1: 1.007107, 1.5: 0.509513, 2: 0.388388, 3: 0.326189, 5: 0.305657}),
    ],
)
@pytest.mark.parametrize("dimension", [2, 3])
def test_shear_under_pressure(mode, table, dimension):
    """A7.5: p = 0.5 MPa."""
    direction = np.array([0.0, 1.0]) if dimension == 2 else np.array([0.0, 0.6, 0.8])
    path = np.outer(np.array(list(table)) * U0, direction)
    history = probe(law(friction_mode=mode), path, pressure=0.5e6)
    shear = history.stress @ direction / 1e6
    assert shear == pytest.approx(list(table.values()), abs=6e-7)
    x = np.array(list(table))
    beta = np.minimum(1, x**-2)
    friction = 0.6 * (1 - beta) if mode == "damage" else 0.6
    assert shear * 1e6 == pytest.approx(beta**2 * C * x * U0 + friction * 0.5e6, rel=1e-12)
    assert history.stress[:, 0] == pytest.approx(-0.5e6)


def test_square_adhesion_is_brittle():
    """A7.6, h(β) = β²: peak √(2wc) at √(2w/c), dissipates w."""
    brittle = law(degree=2)
    critical = np.sqrt(2 * ENERGY / C)
    history = probe(brittle, [[0.999999999 * critical, 0], [1.000000001 * critical, 0], [0.5 * critical, 0]])
    assert critical == pytest.approx(1e-4)
    assert history.stress[0, 0] == pytest.approx(1e6, rel=1e-8)
    assert history.stress[1:, 0].tolist() == [0.0, 0.0]
    assert history.dissipated[-1] == pytest.approx(ENERGY, rel=1e-12)


def test_bar_in_series():
    """A7.7: a bar E = 10 GPa, L = 0.1 m pulls at the joint."""
    peak = U0 * (1 + C * 0.1 / 10e9)
    table = {0.5: (0.5, 0.5 * S0 / 1e6), 1: (1, S0 / 1e6), 1.1: (1.143040, 0.473479),
             1.5: (1.626772, 0.164250), 2: (2.190486, 0.067277), 4: (4.398825, 0.008308)}  # fmt: skip
    ends = [[x * peak, 0.0] for x in table]
    history = pull(law(), ends, stiffness=10e9 / 0.1)
    assert history.settled.all()
    assert history.jump[:, 0] / U0 == pytest.approx([u for u, _ in table.values()], rel=1e-6)
    assert history.stress[:, 0] / 1e6 == pytest.approx([r for _, r in table.values()], abs=6e-7)


@pytest.mark.parametrize(
    ("change", "match"),
    [({"energy": 0.0}, "energy is 0"), ({"degree": 3}, "degree is 3"),
     ({"friction": -0.1}, "friction is -0.1"), ({"friction_mode": "none"}, "friction_mode"),
     ({"energy": np.array([1.0, np.nan])}, "energy is nan")],
)  # fmt: skip
def test_impossible_parameters(change, match):
    with pytest.raises(LawError, match=match):
        law(**change)


def test_energy_of_the_delay_is_told_apart():
    """Held opening k u0: of ½ Y (1 − β²), Y = k² w, the surface takes w (1 − β) and the delay the rest."""
    k, b, missing = 1.5, 2.0, []
    for steps in (200, 400):
        history = probe(law(viscosity=b), opening(*[k] * steps), step=b / ENERGY / steps)
        beta, state = history.adhesion[-1], history.state
        surface = ENERGY * (1 - beta)
        assert state.dissipated[0] - state.delayed[0] == pytest.approx(surface, rel=1e-9)
        exact = 0.5 * k**2 * ENERGY * (1 - beta**2) - surface
        missing.append(state.delayed[0] / exact - 1)
    assert abs(missing[1]) < 0.01
    assert missing[0] / missing[1] == pytest.approx(2, rel=0.05)
    assert not probe(law(), opening(0.5, 1.5, 3.0)).state.delayed.any()

"""A chain of links that slip round a drum, against Eytelwein's closed form for a polygon.

A link bears the pulls T₁ < T₂ of the ties beside it, each at α/2 to its face. It slips where
T₂ = q T₁, q = (1 + μ tan α/2)/(1 − μ tan α/2), which is e^{μ α} for many small links.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import loads

RADIUS, THICK, YOUNG, SECTION, PULL = 1.0, 0.02, 2e11, 1e-4, 1e3
EMBRACE = np.radians(120.0)
HEAD = """
dimension = 2
materials.stone = { density = 2000.0, young = 1e10, poisson = 0.2 }
materials.iron = { density = 7800.0, young = 1e10, poisson = 0.2 }
contact.update = "fixed"
solver.tolerance = 1e-9
output = { pictures = false }
"""


def chain(links: int, friction: float, forces: dict[int, tuple[float, str]], *keys: str, tie: str = ""):
    """Links beside each other round a drum, of which number 0 is fixed unless a force acts there.

    Forces are along the chain, from it, by link, with what else their record says.
    """
    count = links + 1
    turn = EMBRACE / count
    places = -0.5 * EMBRACE + (np.arange(-1, count + 1) + 0.5) * turn
    chords = np.diff(np.stack([np.sin(places), np.cos(places)], axis=1), axis=0)
    chords /= np.linalg.norm(chords, axis=1)[:, None]
    names = [f"chain.v{k + 1:0{max(2, len(str(count)))}d}" for k in range(count)]
    ring = f"kind='arch', voussoirs={count}, straight=true, embrace=120, springings=false"
    drum = f"{{{ring}, name='drum', material='stone', radius={RADIUS - 0.1 - THICK / 2}, thickness=0.2}}"
    shoes = f"{{{ring}, name='chain', material='iron', radius={RADIUS}, thickness={THICK}, fidelity='rigid'}}"
    acting = []
    for link, (size, more) in forces.items():
        x, y = (size * (chords[-1] if link else -chords[0])).tolist()
        acting.append(f"{{block='{names[link]}', vector=[{x!r}, {y!r}]{more}}}")
    points = ", ".join(f"{{block='{name}'}}" for name in names)
    held = "" if 0 in forces else f", {{on='{names[0]}'}}"
    return loads(
        HEAD,
        [
            "fidelity=rigid",
            f"structures=[{drum}, {shoes}]",
            f"supports=[{{on='drum.*'}}{held}]",
            f"joints=[{{friction={friction}}}, {{between=['chain.*', 'chain.*'], contact='none'}}]",
            f"ties=[{{name='t', points=[{points}], section={SECTION}, young={YOUNG}{tie}}}]",
            f"loads.points=[{', '.join(acting)}]",
            *keys,
        ],
    )


def ratio(links: int, friction: float) -> float:
    slope = friction * np.tan(0.5 * EMBRACE / (links + 1))
    return (1 + slope) / (1 - slope)


def forces_of(result) -> np.ndarray:
    assert result.outcome == "equilibrium"
    return np.array([one.force for one in result.summary.ties.values()])


STATICS = "analysis={kind='statics', load_steps=4}"


@pytest.mark.parametrize("links", [6, 20])
def test_a_chain_that_is_pulled_slips_all_along(links):
    """T_k = F/q^(n − k); its end goes as far as all ties stretch."""
    found = forces_of(made := solve_scene(chain(links, 0.3, {links: (PULL, "")}, STATICS)))
    expected = PULL / ratio(links, 0.3) ** np.arange(links, 0, -1)
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    length = RADIUS * np.sin(EMBRACE / (links + 1))  # the links' corners lie on the circle
    stretch = [one.elongation for one in made.summary.ties.values()]
    assert sum(stretch) == pytest.approx(expected.sum() * length / (YOUNG * SECTION), rel=1e-3)


def test_many_small_links_are_a_rope():
    """T₂/T₁ = e^{μ β} over the angle β between both ends, but for β (μ + μ³) α²/12 of the logarithm."""
    friction = 0.3
    for links in (9, 19):
        turn = EMBRACE / (links + 1)
        first = forces_of(solve_scene(chain(links, friction, {links: (PULL, "")}, STATICS)))[0]
        more = np.log(PULL / first) - friction * links * turn
        assert more == pytest.approx((friction + friction**3) * links * turn**3 / 12, rel=0.02)


def test_a_chain_that_is_let_go_slips_back_from_its_end():
    """Slipping back T_k = F q^(n − k), until that is more than what was there: links farther on stick."""
    time = ", time={kind='table', points=[[0.0, 0.0], [0.5, 1.0], [1.0, 0.7]]}"
    found = forces_of(
        solve_scene(chain(6, 0.3, {6: (PULL, time)}, "analysis={kind='statics', load_steps=10}"))
    )
    powers = ratio(6, 0.3) ** np.arange(6, 0, -1)
    back = np.minimum(0.7 * PULL * powers, PULL / powers)
    assert (back == PULL / powers).sum() in range(1, 6)
    np.testing.assert_allclose(found, back, rtol=1e-6)


@pytest.mark.parametrize(("share", "outcome"), [(0.99, "equilibrium"), (1.01, "no_equilibrium")])
def test_pulled_at_both_ends_it_slips_off(share, outcome):
    """T₂/T₁ = q^n with n links on the drum."""
    links = 6
    ends = {0: (PULL, ""), links: (share * ratio(links, 0.3) ** (links + 1) * PULL, "")}
    assert solve_scene(chain(links, 0.3, ends, STATICS)).outcome == outcome


def test_a_chain_that_is_pulled_off_speeds_up_as_one():
    """In dynamics: T_{k+1} (c − μ s) − T_k (c + μ s) = m a for each link, once the ties swing no more."""
    links, friction, step, count = 6, 0.3, 1e-3, 160
    turn, q = EMBRACE / (links + 1), ratio(links, friction)
    pull = 2 * q ** (links + 1) * PULL
    length = 2 * RADIUS * np.sin(0.5 * turn)  # of a link, on the middle of its thickness
    mass = 7800.0 * length * np.cos(0.5 * turn) * THICK
    grip = np.cos(0.5 * turn) - friction * np.sin(0.5 * turn)
    speed_up = (pull - q ** (links + 1) * PULL) * grip / mass / (q ** np.arange(links + 1)).sum()
    expected = [PULL]
    for _ in range(links):
        expected.append(q * expected[-1] + mass * speed_up / grip)
    keys = [f"analysis={{kind='dynamics', step={step}, duration={count * step}, theta=1}}"]
    made = solve_scene(chain(links, friction, {0: (PULL, ""), links: (pull, "")}, *keys))
    assert made.outcome == "finished"
    np.testing.assert_allclose([one.force for one in made.summary.ties.values()], expected[1:], rtol=1e-6)
    assert made.march.report.speed == pytest.approx(speed_up * count * step, rel=1e-2)


def test_limit_analysis_knows_the_friction_of_a_chain():
    links, q = 6, ratio(6, 0.3)
    fixed = analyse(chain(links, 0.3, {links: (1.0, "")}, tie=", yield_stress=1e6"))
    assert fixed.multiplier == pytest.approx(1e6 * SECTION * q, rel=1e-8)  # the last tie yields first
    ends = {0: (PULL, ""), links: (1.0, "")}
    found = analyse(chain(links, 0.3, ends), dead=("points.0",))
    assert found.multiplier == pytest.approx(PULL * q ** (links + 1), rel=1e-8)


def test_a_chain_slips_round_elastic_stones():
    """Their forces on it are the same."""
    links = 6
    keys = ["overrides=[{blocks='drum.*', fidelity='elastic', mesh={divisions=[3, 3]}}]", STATICS]
    keys.append("supports=[{on='drum.*/intrados'}, {on='chain.v01'}]")
    found = forces_of(solve_scene(chain(links, 0.3, {links: (PULL, "")}, *keys)))
    np.testing.assert_allclose(found, PULL / ratio(links, 0.3) ** np.arange(links, 0, -1), rtol=1e-6)

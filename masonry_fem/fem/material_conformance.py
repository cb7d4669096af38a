"""Conformance: what every material law owes, asked of one law in steps between random strains.

For laws of one's own; the laws of this package are asked more in their tests.

    for sentence in violations(Compaction(crushing_pressure=5e6)):
        print(sentence)
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_fem.bodies.rotation import exponential
from masonry_fem.fem.material_law import SHEARS, FloatArray, Isotropic, MaterialLaw, Response
from masonry_fem.fem.materials.parts.principal import components, full

POINTS = 200
SLIGHT = 1e-4  # of the strains asked for: so little that nothing yields
DIFFERENCE = 1e-5  # of the strains: half the width of the difference that a tangent is compared with
EXACT, NEAR = 1e-9, 1e-5  # of stresses and energies; of tangents, by differences


def violations(
    law: MaterialLaw,
    strain: float = 1e-3,
    young: float = 1e10,
    poisson: float = 0.2,
    size: float = 0.05,
    seed: int = 0,
) -> list[str]:
    """Check a material law at random strains; one sentence for each rule that it violates.

    Parameters
    ----------
    law : The law, with its parameters.
    strain : Size of the strains; choose it such that the material yields at some of the points, but not at
        all of them.
    young : Young's modulus of the stone [Pa].
    poisson : Poisson's ratio of the stone.
    size : Size of its elements [m].
    seed : Seed of the random strains.

    Raises
    ------
    LawError : The law cannot be used with these moduli or elements.
    """
    elastic, width = Isotropic.of(young, poisson), np.full(POINTS, size)
    law.refuse(elastic, width)
    random = np.random.default_rng(seed)
    first, second = strain * random.normal(size=(2, POINTS, 6)) * random.uniform(0.1, 1.0, (1, POINTS, 1))
    found = [
        *_elastic(law, elastic, SLIGHT * first, width),
        *_steps(law, elastic, (np.zeros_like(first), first), law.initial(POINTS), width, strain),
    ]
    committed = law.update(elastic, np.zeros_like(first), first, law.initial(POINTS), width).internal
    found += [
        *_steps(law, elastic, (first, second), committed, width, strain),
        *_turned(law, elastic, (first, second), width),
    ]
    return list(dict.fromkeys(found))


def _elastic(law: MaterialLaw, elastic: Isotropic, strain: FloatArray, size: FloatArray) -> Iterator[str]:
    made = law.update(elastic, np.zeros_like(strain), strain, law.initial(len(strain)), size)
    if _apart(made.stress, strain @ elastic.matrix) > EXACT:
        yield "small strains of the fresh material are not elastic: stress is not that of Hooke's law"


def _steps(
    law: MaterialLaw,
    elastic: Isotropic,
    strains: tuple[FloatArray, FloatArray],
    committed: FloatArray,
    size: FloatArray,
    scale: float,
) -> Iterator[str]:
    """What one step does wrong; ``strains`` are those of its start and its end."""
    start, end = strains
    kept = committed.copy()
    made = law.update(elastic, start, end, committed, size)
    if not np.array_equal(kept, committed):
        yield "committed internal variables are changed: return others in their place"
    if not made.changed.any():
        yield f"nothing yields at strains of {scale:g}: ask with larger ones"
    before = law.update(elastic, start, start, committed, size)
    given = made.stored - before.stored + made.dissipation + made.excess
    work = (made.stress * (end - start)).sum(axis=1)
    energy = float(np.abs(elastic.matrix).max() * scale**2)
    if np.abs(work - given).max() > EXACT * energy:
        yield "energy is missing: stress times strain is not the change of stored + dissipation + excess"
    if made.dissipation.min() < -EXACT * energy:
        yield "dissipation is negative: the material gives energy"
    yield from _tangents(law, elastic, made, (start, end, committed, size), scale)
    again = law.update(elastic, end, end, made.internal, size)
    if _apart(again.stress, made.stress) > EXACT:
        yield "a step that goes nowhere changes the stress: the end of a step is not where the next begins"
    for name, values in law.measures(made.internal).items():
        if np.shape(values) != (len(end),):
            yield f"measures()['{name}'] has shape {np.shape(values)}, expected one number a point"


def _tangents(
    law: MaterialLaw,
    elastic: Isotropic,
    made: Response,
    step: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    scale: float,
) -> Iterator[str]:
    """Whether tangents are derivatives; a few points may have a kink between the ends of a difference."""
    start, end, committed, size = step
    h = DIFFERENCE * scale
    columns = [
        law.update(elastic, start, end + h * unit, committed, size).stress
        - law.update(elastic, start, end - h * unit, committed, size).stress
        for unit in np.eye(6)
    ]
    wrong = np.abs(np.stack(columns, axis=2) / (2 * h) - made.tangent).max(axis=(1, 2))
    if (wrong > NEAR * elastic.matrix.max()).mean() > 0.05:
        yield (
            f"the tangent is not the derivative of the stress, off by {np.quantile(wrong, 0.9):.3g} Pa: "
            "Newton's method will be slow or fail"
        )
    plain = ~made.changed
    if (
        plain.any()
        and _apart(made.tangent[plain], np.broadcast_to(elastic.matrix, made.tangent[plain].shape)) > 0
    ):
        yield "points that are not `changed` have another tangent than the elastic one"


def _turned(
    law: MaterialLaw, elastic: Isotropic, strains: tuple[FloatArray, FloatArray], size: FloatArray
) -> Iterator[str]:
    """Whether stresses of turned strains are the turned stresses."""
    turn = exponential(np.array([0.7, -1.1, 0.4]))

    def end(first: FloatArray, second: FloatArray) -> FloatArray:
        zero = np.zeros_like(first)
        committed = law.update(elastic, zero, first, law.initial(len(first)), size).internal
        return law.update(elastic, first, second, committed, size).stress

    def rotated(tensors: FloatArray) -> FloatArray:
        return components(turn @ full(tensors) @ turn.T)

    first, second = (SHEARS * rotated(strain / SHEARS) for strain in strains)
    if _apart(end(first, second), rotated(end(*strains))) > EXACT:
        yield "stresses depend on the axes: turned strains have other stresses than the turned ones"


def _apart(one: FloatArray, other: FloatArray) -> float:
    """Greatest difference, relative to the greatest value."""
    scale = float(np.abs(other).max())
    return float(np.abs(one - other).max()) / (scale if scale > 0 else 1.0)

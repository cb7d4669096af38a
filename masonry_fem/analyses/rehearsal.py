"""Rehearsal: small scenes that have all code compiled, so that a user's first scene need not wait for it.

    for name in rehearse():
        print(name)
    for name in rehearse(aided=True):  # in two processes
        print(name)

Contact loops are compiled by Numba and element kernels by FFCx, each once for a processor, and both are kept
on disk. What a scene compiles depends on what it has, not on its size: these have a little of everything.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import product
from multiprocessing import get_context

__all__ = ["SCENES", "rehearse", "silence"]

PLANE, SPACE = "[0.0, -9.81]", "[0.0, 0.0, -9.81]"
SCENE = """
dimension = {dimension}
fidelity = "{fidelity}"
materials.stone = {{ density = 2200, young = 1e10, poisson = 0.2 }}
loads.gravity = {gravity}
{structure}
{more}
"""
WALL = """
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = {brick}
columns = 2
courses = 3
"""
PLANE_WALL, SPACE_WALL = WALL.format(brick=[0.5, 0.25]), WALL.format(brick=[0.5, 0.25, 0.25])
DOME = """
[[structures]]
kind = "dome"
name = "dome"
material = "stone"
radius = 4.0
thickness = 0.4
rings = 2
slices = 6
"""
RUBBLE = """
[[structures]]
kind = "rubble"
name = "rubble"
material = "stone"
size = [1.0, 0.4, 0.6]
stones = 12
seed = 1
"""
DRY = "[[joints]]\nfriction = 0.3\n"
COHESION = "[[joints]]\nlaw = { kind = 'mohr_coulomb', cohesion = 1e3, tensile_strength = 1e3 }\n"
PUSH = "[[loads.accelerations]]\nvector = {push}\n"
MOTION = "[analysis]\nkind = 'dynamics'\nstep = 0.01\nduration = 0.03\n"
ITERATED = "[solver]\nlinear = 'krylov'\n"
MIXED = """
[mesh]
element = "P1"
divisions = [1, 1, 1]
[[overrides]]
blocks = "wall.c2.*"
mesh = { element = "Q1", divisions = [1, 1, 1] }
"""
FINE = "[mesh]\ndivisions = [5, 5, 5]\n"
SWEEPS = "[solver]\nmethod = 'nsgs'\ntolerance = 1e-2\n"


def _scenes() -> Iterator[tuple[str, str]]:
    """Names and texts of scenes."""
    ways = {
        "at rest": DRY,
        "with cohesion": COHESION,
        "sliding": DRY + PUSH + MOTION,
        "sliding, by sweeps": DRY + PUSH + MOTION + SWEEPS,
        "with cohesion, by sweeps": COHESION + MOTION + SWEEPS,
    }
    for dimension, fidelity, (way, more) in product((2, 3), ("rigid", "elastic"), ways.items()):
        push = [9.0, 0.0, 0.0][:dimension]
        yield (
            f"{fidelity} blocks {way}, {dimension}D",
            _scene(dimension, fidelity, more.replace("{push}", str(push))),
        )
    for way, more in {"few": ITERATED, "many": ITERATED + FINE}.items():
        yield f"elastic blocks with {way} contacts, by iterations", _scene(3, "elastic", DRY + more)
    for dimension, element in product((2, 3), ("P1", "Q2", "P2")):
        mesh = f"[mesh]\nelement = '{element}'\ndivisions = {[1] * dimension}\n"
        yield f"elements {element}, {dimension}D", _scene(dimension, "elastic", mesh)
    yield "elements of two kinds", _scene(3, "elastic", MIXED)
    for name, structure in (("dome", DOME), ("rubble", RUBBLE)):
        yield name, _scene(3, "rigid", DRY, structure)


def _scene(dimension: int, fidelity: str, more: str, structure: str = "") -> str:
    wall, gravity = (PLANE_WALL, PLANE) if dimension == 2 else (SPACE_WALL, SPACE)
    return SCENE.format(
        dimension=dimension, fidelity=fidelity, gravity=gravity, structure=structure or wall, more=more
    )


SCENES = dict(_scenes())


def rehearse(*, aided: bool = False) -> Iterator[str]:
    """Solve the scenes; the name of each once it is solved.

    Parameters
    ----------
    aided : Whether a second process takes the scenes in space, once the first scene has compiled what most
        of them need. Where it dies, this one solves them too.
    """
    first, *others = SCENES
    _solve(first)
    yield first
    if not aided:
        for name in others:
            _solve(name)
            yield name
        return
    helper = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=silence)
    try:
        there = {name: helper.submit(_solve, name) for name in others if not name.endswith("2D")}
        for name in others:
            if name not in there:
                _solve(name)
                yield name
        for name, solution in reversed(there.items()):
            try:
                if solution.cancel():
                    _solve(name)
                else:
                    solution.result()
            except BrokenProcessPool:
                _solve(name)
            yield name
    finally:
        helper.shutdown(cancel_futures=True)


def _solve(name: str) -> None:
    from masonry_fem.analyses.run import solve_scene  # noqa: PLC0415 - loads what is to be compiled
    from masonry_fem.scene import loads  # noqa: PLC0415

    solve_scene(loads(SCENES[name]))


def silence() -> None:
    """What these scenes warn of concerns nobody."""
    for name in ("masonry_fem", "masonry_fem.host.compiled"):
        logging.getLogger(name).setLevel(logging.ERROR)

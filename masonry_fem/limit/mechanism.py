"""Mechanism of a limit analysis: the dual velocities of a program as the motion of the blocks.

mechanism_of(problem, velocity).sentence()    # "7 blocks move in 3 parts; 4 hinges: ..."
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.rotation import spin_count
from masonry_fem.march.mechanism import Mechanism
from masonry_fem.march.motion import BlockMotion, PointMotion
from masonry_fem.march.recognition import recognise

if TYPE_CHECKING:
    from masonry_fem.limit.problem import LimitProblem

FloatArray = NDArray[np.float64]

AT_REST = 1e-6  # of the speed of the fastest corner: slower blocks are at rest


def mechanism_of(problem: LimitProblem, velocity: FloatArray) -> Mechanism:
    """The mechanism that the dual velocities of a program describe.

    Parameters
    ----------
    problem : Blocks and contact points.
    velocity : Velocities and spins block by block, in the problem's units; what follows them is ignored.
    """
    d, assembly = problem.dimension, problem.model.assembly
    free = velocity[: len(problem.blocks) * (3 if d == 2 else 6)].reshape(len(problem.blocks), -1)
    count = len(assembly.blocks)
    motion = BlockMotion(
        centre=np.stack([assembly.solid(block).vertices.mean(axis=0) for block in range(count)]),
        velocity=np.zeros((count, d)),
        spin=np.zeros((count, spin_count(d))),
        held=~np.isin(np.arange(count), problem.blocks),
        corners=tuple(assembly.solid(block).vertices for block in range(count)),
    )
    motion.centre[problem.blocks] = problem.centre
    motion.velocity[problem.blocks] = free[:, :d]
    motion.spin[problem.blocks] = free[:, d:] / problem.length
    faces = problem.active & ~problem.model.contacts.tied
    points = PointMotion(problem.points, problem.frame, faces)
    return recognise(problem.model, motion, points, rest=AT_REST, friction=problem.strength.friction)

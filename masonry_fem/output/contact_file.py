"""Contact file: what a step computed, stored beside its contact problem in ``contact_STEP.npz``.

    save_problem(made.problem, path, found_arrays(made, model))

The arrays are of the active contacts, in the order of the problem.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.model import Model
from masonry_fem.march.step import Increment


def found_arrays(made: Increment, model: Model) -> dict[str, NDArray[Any]]:
    """Impulses, velocities and geometry of k contacts and b bodies, by the names that docs/results.md lists.

    Parameters
    ----------
    made : The step.
    model : Its model.
    """
    active, here = made.contacts, made.here
    names = model.assembly.blocks.names
    solved = [block for group in model.groups if not group.prescribed for block in group.blocks.tolist()]
    return {
        "impulse": made.impulse[active],
        "velocity": made.solution.velocity,
        "U": made.solution.rigid_velocity,
        "contact": active,
        "blocks": model.contacts.blocks[active],
        "frame": here.frame[active],
        "points": here.points[active],
        "gap": here.gap[active],
        "area": model.contacts.area[active],
        "body_names": np.array([names[block] for block in solved], dtype=str),
        "block_names": np.array(names, dtype=str),
        "h": np.array(made.scheme.step),
        "theta": np.array(made.scheme.theta),
        "inertia": np.array(made.scheme.inertia),
        "time": np.array(made.after.time),
    }

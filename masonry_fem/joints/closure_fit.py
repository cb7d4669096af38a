"""ClosureFit: k_0 and w_max of joints that close, from moduli of walls measured at several pressures.

normal_stiffness, greatest = fit_closure([0.5e6, 0.875e6, 1.25e6], [3.3e9, 4.1e9, 4.7e9], 20.2e9, 0.15)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from masonry_fem.errors import LawError


def fit_closure(pressures: ArrayLike, moduli: ArrayLike, stone: float, spacing: float) -> tuple[float, float]:
    """What ``[joints.closure]`` needs so that a wall has measured tangent moduli.

    Stones and joints are in series, 1/E = 1/E_stone + 1/(k spacing), with k = k_0 (1 + σ/(k_0 w_max))², so
    that √k is linear in σ: a straight line of least squares through the measured ones.

    Parameters
    ----------
    pressures : At which the wall was measured, two at least, shape (n,) [Pa].
    moduli : Tangent modulus E of the wall at each pressure, shape (n,) [Pa].
    stone : E of the stone alone [Pa].
    spacing : Distance between joints [m].

    Returns
    -------
    k_0 [N/m³] and w_max [m].

    Raises
    ------
    LawError
        Fewer than two pressures, a wall as stiff as its stone, or one that does not stiffen as it is pressed.

    References
    ----------
    Bandis, Lumsden, Barton, Fundamentals of rock joint deformation, Int. J. Rock Mech. Min. Sci. 20 (1983).
    """
    at, measured = np.asarray(pressures, dtype=float), np.asarray(moduli, dtype=float)
    if at.ndim != 1 or at.shape != measured.shape or len(np.unique(at)) < 2:
        raise LawError(
            f"closure: {at.size} pressures and {measured.size} moduli, expected one modulus for each of two "
            "or more different pressures; measure at another one, or set [joints.closure] yourself"
        )
    if not ((measured > 0) & (measured < stone)).all():
        raise LawError(
            f"closure: a wall's modulus is {measured.max():g} Pa, expected more than 0 and less than the "
            f"{stone:g} Pa of its stone, as joints only add to what gives way; check the units of both"
        )
    stiffness = 1.0 / (spacing * (1.0 / measured - 1.0 / stone))
    slope, root = np.polyfit(at, np.sqrt(stiffness), 1)
    if slope <= 0 or root <= 0:
        raise LawError(
            f"closure: √k of the joints is {root:.4g} + {slope:.4g} σ, expected both > 0, as of joints "
            "that are soft at first and stiffen when pressed; take [joints.mortar], which does not stiffen"
        )
    return float(root**2), float(1.0 / (slope * root))

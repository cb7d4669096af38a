"""Ways to come to rest, one file a strategy."""

from __future__ import annotations

from masonry_fem.march.equilibrium.base import Strategy, at_rest
from masonry_fem.march.equilibrium.damped import Damped, linear_damping, numerical_viscosity
from masonry_fem.march.equilibrium.onward import Onward
from masonry_fem.march.equilibrium.statics import Statics
from masonry_fem.march.equilibrium.transient import Transient

__all__ = [
    "Damped",
    "Onward",
    "Statics",
    "Strategy",
    "Transient",
    "at_rest",
    "linear_damping",
    "numerical_viscosity",
]

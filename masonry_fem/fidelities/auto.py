"""Auto: elastic stones that become inelastic once their stress comes near to their strength."""

from __future__ import annotations

from masonry_fem.fidelities.inelastic import Inelastic


class Auto(Inelastic):
    """One group for each distinct shape, material and clamping; stones without a law stay elastic."""

    name = "auto"
    rank = 4
    yields = False
    promotes = True

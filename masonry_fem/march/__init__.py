"""The step, the march and the ways to an equilibrium."""

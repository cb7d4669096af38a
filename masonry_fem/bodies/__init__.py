"""Blocks as the solver sees them: supports and rigid bodies. NumPy only."""

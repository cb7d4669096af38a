"""Geometry of blocks as arrays: pose, polytope, mesh, assembly. NumPy only."""

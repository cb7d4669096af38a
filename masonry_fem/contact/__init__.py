"""Where blocks touch and in which frame. NumPy and Numba only."""

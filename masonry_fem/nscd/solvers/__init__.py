"""Global contact solvers, one file a method."""

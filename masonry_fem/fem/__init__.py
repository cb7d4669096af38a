"""Elastic blocks. DOLFINx, UFL, PETSc and MPI are imported here only."""

"""Endings: the files that can be read, told by the ends of their names."""

from __future__ import annotations

PROGRAMS = (".geo", ".geo_unrolled")  # a language with loops, files and system calls
MESHES, DRAWINGS = (".msh", ".unv", ".med"), (".step", ".stp")
VOLUMES, SURFACES, COMPAS = (".vtu", ".vtk"), (".stl", ".obj", ".ply"), (".json",)
INPUTS = (".inp",)
SURVEYS = (".csv", ".obj", ".dxf")

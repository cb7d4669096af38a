"""Structures, files and meshes. gmsh is imported here only."""

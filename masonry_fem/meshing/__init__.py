"""Elements in blocks. gmsh is loaded only for blocks that no structured mesh fits."""

"""Files from elsewhere: read, repaired, named. gmsh and meshio are loaded only where a file asks for them.

Below stands which files can be read, told by the ends of their names.
"""

PROGRAMS = (".geo", ".geo_unrolled")  # a language with loops, files and system calls
MESHES, DRAWINGS = (".msh", ".unv", ".med"), (".step", ".stp")
VOLUMES, SURFACES, COMPAS = (".vtu", ".vtk"), (".stl", ".obj", ".ply"), (".json",)
INPUTS = (".inp",)
SURVEYS = (".csv", ".obj", ".dxf")

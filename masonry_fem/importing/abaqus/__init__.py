"""Abaqus: elements of blocks from the ``.inp`` files of Abaqus, CalculiX and PrePoMax.

    found = read_abaqus(Path("arch.inp"), 3, "structures.arch.path 'arch.inp'")

Blocks are the ``*ELSET`` of solids where these are at least two, have no element in common and leave none
out; otherwise the sets that ``*ELEMENT, ELSET=`` names. Faces of ``*SURFACE, TYPE=ELEMENT`` have its name.
Parts are placed as their ``*INSTANCE`` says. ``*INCLUDE`` brings the lines of files in the same folder or
below. Materials, steps and boundary conditions are not read.
Serendipity elements (C3D20, CPS8) get the nodes in the middle of faces and of the body that they lack,
where their functions put them. Wedges (C3D6) are divided into three tetrahedra.

``card`` takes the file and those it includes apart, ``part`` keeps nodes, elements and sets, ``placing`` puts
parts where their instances are, ``elements`` makes elements whole and divides wedges, ``reading`` does all of
it.
"""

from masonry_fem.importing.abaqus.card import included
from masonry_fem.importing.abaqus.reading import read_abaqus

__all__ = ["included", "read_abaqus"]

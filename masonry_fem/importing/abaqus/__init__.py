"""Abaqus: elements of blocks from the ``.inp`` files of Abaqus, CalculiX and PrePoMax.

    found = read_abaqus(Path("arch.inp"), 3, "structures.arch.path 'arch.inp'")

Blocks are the ``*ELSET`` of solids where these are at least two, have no element in common and leave none
out; otherwise the sets that ``*ELEMENT, ELSET=`` names. Faces of ``*SURFACE, TYPE=ELEMENT`` have its name.
Parts are placed as their ``*INSTANCE`` says. Materials, steps and boundary conditions are not read.
Serendipity elements (C3D20, CPS8) get the nodes in the middle of faces and of the body that they lack,
where their functions put them.

``card`` takes the file apart, ``part`` keeps nodes, elements and sets, ``placing`` puts parts where their
instances are, ``serendipity`` makes elements whole, ``reading`` does all of it.
"""

from masonry_fem.importing.abaqus.reading import read_abaqus

__all__ = ["read_abaqus"]

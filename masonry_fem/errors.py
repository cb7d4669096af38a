"""What can go wrong in a way that a user can mend.

Every error names the thing, its value, what was expected and the next action; a message is
complete in itself, so the command line prints it without a traceback.
"""

from __future__ import annotations


class MasonryError(Exception):
    """Any failure that a user can cause and mend."""


class SceneError(MasonryError):
    """A scene that cannot be read, or that describes something impossible."""


class GeometryError(MasonryError):
    """A solid, a mesh or a pair of blocks that cannot be used as it is."""


class ProblemError(MasonryError):
    """A contact problem whose arrays do not fit together."""


class LawError(MasonryError):
    """A joint law whose parameters contradict mechanics or each other."""


class InstallationError(MasonryError):
    """A library, compiler or driver that this machine lacks."""


class ExtensionError(MasonryError):
    """A file that was added to the program and lacks what its folder asks for."""


class OutputError(MasonryError):
    """A file or a folder that cannot be written."""

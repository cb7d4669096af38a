"""Opening: a door or a window, a rectangle of a wall's plane without stones."""

from __future__ import annotations

from masonry_fem.records.record import Count, Distance, Length, Spec


class Opening(Spec, frozen=True, kw_only=True):
    """Door or window, with a lintel above it unless it goes up to the wall's top.

    Attributes
    ----------
    position : lower left corner, along the wall and upwards, from the wall's lower left end [m]
    size : width and height, up to a bed joint
    lintel : a stone lies above it, unless it goes up to the wall's top
    lintel_courses : height of the lintel in courses
    bearing : length of the lintel on each jamb; half a brick by default
    """

    position: tuple[Distance, Distance]
    size: tuple[Length, Length]
    lintel: bool = True
    lintel_courses: Count = 1
    bearing: Length | None = None

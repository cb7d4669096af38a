"""Reading: what foreign files may take to be read."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from masonry_fem.records.record import Memory, Spec


class Reading(Spec, frozen=True, kw_only=True):
    """What the files of all structures may take to be read, and meshed where they are geometries.

    They are read in a process of its own, which is ended where it takes more.
    """

    time: Annotated[float, Meta(gt=0, le=1e6, extra={"unit": "s"})] = 120.0  # longer waits overflow
    memory: Memory = 4e9

"""Reading: how much time and memory the reading of files may take."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from masonry_fem.records.record import Memory, Spec


class Reading(Spec, frozen=True, kw_only=True):
    """Limits on time and memory for reading the files of all structures, and for meshing geometry files.

    Files are read in a process of its own, which is ended when it exceeds a limit.

    Attributes
    ----------
    time : wall-clock time for all files together
    memory : memory beyond what an idle process needs
    """

    time: Annotated[float, Meta(gt=0, le=1e6, extra={"unit": "s"})] = 120.0  # longer waits overflow
    memory: Memory = 4e9

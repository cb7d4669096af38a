"""Dealing: what stones give way by, made by all ranks, for some stones at a time.

    dealing = Dealing(attachments, scheme)
    for number, attachment in enumerate(attachments):
        dealing.reach(number)                     # what it needs is there, where ranks could make it
        attachment.kinds(scheme, ...)

Where there is one process nothing is dealt: each attachment makes what it needs when it is asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from masonry_fem.bodies.base import Attachment, Makes, Making, Scheme
from masonry_fem.host.ranks import Leader, Member, dealt, team

ROOM = 2**26  # numbers that are made at a time: half a gigabyte


class _Wanted(NamedTuple):
    """What an attachment needs, and which one that is."""

    number: int
    attachment: Makes
    making: Making


class Dealing:
    """What attachments need for a scheme, dealt to ranks; nothing where there is one process.

    Parameters
    ----------
    attachments : In the order in which they are reached. scheme : Coefficients of the step.
    """

    def __init__(self, attachments: Sequence[Attachment], scheme: Scheme) -> None:
        self._scheme, self._batches = scheme, list[list[_Wanted]]()
        leader = team()
        if not isinstance(leader, Leader) or leader.busy:
            return
        self._leader, room = leader, 0
        for number, attachment in enumerate(attachments):
            making = attachment.making(scheme) if isinstance(attachment, Makes) else None
            if making is None:
                continue
            room -= making.numbers
            if room < 0:
                self._batches.append([])
                room = ROOM - making.numbers
            self._batches[-1].append(_Wanted(number, cast("Makes", attachment), making))
        self._batches.reverse()

    def reach(self, number: int) -> None:
        """See to it that what an attachment needs is made, with what is needed next.

        Parameters
        ----------
        number : Of the attachment, as they were given.
        """
        if not self._batches or self._batches[-1][0].number != number:
            return
        batch = self._batches.pop()
        if len(batch) < self._leader.size:
            return
        its = dealt([wanted.making.cost for wanted in batch], self._leader.size)
        shares = [[batch[one].making for one in own] for own in its]
        try:
            results = self._leader.call(_made, shares)
        except (np.linalg.LinAlgError, MemoryError):  # what makes it here tells of which stone it is
            return
        for own, found in zip(its, results, strict=True):
            for one, made in zip(own, found, strict=True):
                batch[one].attachment.take(self._scheme, made)


def _made(member: Member, share: list[Making]) -> list[Any]:
    """What a rank has made."""
    with member.on("stones"):
        here = member.rank == 0
        found: list[Any] = member.together(lambda: [making.made(here=here) for making in share])
    return found

"""Arguments: what scripts pass to functions, where Python would take something else for what was meant."""

from __future__ import annotations

from collections.abc import Iterable

from masonry_fem.errors import MasonryError


def texts(given: str | Iterable[str]) -> tuple[str, ...]:
    """Several texts; a single one is not taken apart into its letters."""
    return (given,) if isinstance(given, str) else tuple(given)


def check_share(name: str, value: float | str) -> None:
    """Refuse what is no number between 0 and 1.

    Parameters
    ----------
    name : What it is, for the message. value : What was given.

    Raises
    ------
    MasonryError : It is a text, or out of this range.
    """
    if isinstance(value, str) or not 0 < value < 1:
        raise MasonryError(f"{name} is {value!r}, expected a number between 0 and 1, as 0.05 for 5 %")

"""Naming: names for blocks and faces that selectors can use, made from those in files.

    names = Names(UNSPACED)
    names.of("Mesh 0"), names.of("Mesh/0"), names.of("Mesh 0")     # "Mesh_0", "Mesh_0_2", "Mesh_0"
    tell_renamed("structures.d.path 'dome.obj'", names.changed)

Names that differ in the file stay different; changes are reported.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from masonry_fem.records.remark import remark

UNSPACED = r"[^\w.-]+"  # all but letters, digits, "_", "-" and "."
UNSELECTABLE = r"[/*?\[\]]"  # what means something in a selector
SHOWN = 5  # names that a message shows


class Names:
    """Names by what a file calls them, all different."""

    def __init__(self, forbidden: str) -> None:
        self._forbidden = forbidden
        self._known: dict[str, str] = {"": ""}

    def of(self, text: str, prefix: str = "") -> str:
        """The name for what the file calls ``text``; "" if no allowed character is left."""
        if text not in self._known:
            tidy = tidy_name(text, self._forbidden)
            self._known[text] = _unlike(prefix + tidy, set(self._known.values())) if tidy else ""
        return self._known[text]

    @property
    def changed(self) -> dict[str, str]:
        """Names that differ from those in the file, by the latter."""
        return {text: name for text, name in self._known.items() if name and name != text}


def tidy_name(text: str, forbidden: str = UNSPACED) -> str:
    """The text with ``_`` in place of forbidden characters; "" if nothing else is left.

    Parameters
    ----------
    text : A name in a file.
    forbidden : Regular expression of what a name may not contain.
    """
    return re.sub(forbidden, "_", text.strip()).strip("_.")


def unlike(names: list[str]) -> list[str]:
    """The names, with ``_2``, ``_3`` ... behind those that came before."""
    seen: set[str] = set()
    made = []
    for name in names:
        made.append(_unlike(name, seen))
        seen.add(made[-1])
    return made


def tell_renamed(title: str, changed: Mapping[str, str]) -> None:
    """Remark names that differ from those in the file.

    Parameters
    ----------
    title : Name of the file in messages.
    changed : New names by the names in the file.
    """
    if changed:
        some = ", ".join(f"'{text}' is '{name}'" for text, name in list(changed.items())[:SHOWN])
        more = ", ..." if len(changed) > SHOWN else ""
        remark(
            "renamed",
            f"{title}: {len(changed)} names were changed for selectors, or to tell them apart: {some}{more}",
        )


def _unlike(name: str, seen: set[str]) -> str:
    new, count = name, 1
    while new in seen:
        count += 1
        new = f"{name}_{count}"
    return new

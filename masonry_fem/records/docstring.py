"""Docstring: what a record says of itself, for the reference of scene files and for tests.

    meanings(StackStructure)["gap"]     # 'between the boxes, and to the ground'
    example(StackStructure)             # lines such as 'count = 5'

Its text comes first; under ``Attributes`` each key has its meaning, ``key : meaning``, and what a record
inherits need not be repeated; under ``Examples`` stand the lines of a table in a scene file.
"""

from __future__ import annotations

import inspect
import re

HEADING = re.compile(r"^(Attributes|Examples)\n-+\n", re.MULTILINE)
ENTRY = re.compile(r"^(\w+) : (.*(?:\n +.*)*)", re.MULTILINE)


def text(record: type) -> str:
    """What the record is, without its sections."""
    return _parts(record)[""]


def meanings(record: type) -> dict[str, str]:
    """Meaning of each key that the record or what it derives from explains."""
    found: dict[str, str] = {}
    for one in reversed(record.__mro__):
        entries = ENTRY.findall(_parts(one).get("Attributes", ""))
        found |= {key: " ".join(words.split()) for key, words in entries}
    return found


def example(record: type) -> str:
    """A table as a scene file has it; nothing where the record gives none."""
    return _parts(record).get("Examples", "")


def whole(record: type) -> str:
    """All of it, with what the record inherits."""
    entries = "\n".join(f"{key} : {words}" for key, words in meanings(record).items())
    return f"{text(record)}\n\nAttributes\n----------\n{entries}\n\nExamples\n--------\n{example(record)}"


def _parts(record: type) -> dict[str, str]:
    """Sections of a docstring by heading; the first part has the heading ""."""
    first, *rest = HEADING.split(inspect.cleandoc(record.__doc__ or ""))
    named = zip(rest[::2], rest[1::2], strict=True)
    return {"": first.strip()} | {heading: body.strip() for heading, body in named}

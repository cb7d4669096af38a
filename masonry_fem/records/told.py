"""Told: a record of what came out, which is dumped as it stands: attributes are the keys of its JSON.

    class Wrench(Told, frozen=True, kw_only=True):
        force: FloatArray
        moment: FloatArray

    plain(wrench)                # {"force": [1.0, 2.0], "moment": [0.5]}
    write(path, summary)

What is None by default and stays so is left out. Arrays are lists in JSON, infinite values and NaN null.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from masonry_fem.host.atomic import write_atomic

VERSIONS = {"run": 2}  # of summaries by command, where it is not the first


def versioned(command: str) -> str:
    """Kind and version of what a command leaves as JSON: the value of its key ``schema``."""
    return f"{command}/{VERSIONS.get(command, 1)}"


class Told(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Base of all records of results."""


class Ending(Told, frozen=True, kw_only=True):
    """What a summary says of a command that is not done, or did not come to its end.

    Attributes
    ----------
    schema : Kind and version of the whole summary. title : Of the scene.
    outcome, message : What became of it, and the same as a sentence.
    pid : Number of the process that is at it.
    """

    schema: str
    title: str
    outcome: str
    message: str
    pid: int | None = None


def plain(value: Any) -> Any:
    """A record, or what holds some, with JSON's types only."""
    return msgspec.json.decode(_encoded(value))


def text(value: Any) -> str:
    """The same as JSON, key by key."""
    return msgspec.json.format(_encoded(value), indent=2).decode()


def write(path: Path, value: Any) -> Path:
    """Write a record as JSON; the file is replaced whole.

    Parameters
    ----------
    path : Of the file. value : A record, or what holds some.
    """
    write_atomic(path, f"{text(value)}\n".encode())
    return path


def known[T](path: Path, kind: type[T]) -> T | None:
    """What a file that was written so holds; None where it is not there or holds something else.

    Parameters
    ----------
    path : Of the file. kind : Of the record.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except (OSError, ValueError):
        return None


def schema(*records: type[Told]) -> dict[str, Any]:
    """JSON schema of what is one of some records."""
    found, parts = msgspec.json.schema_components(records, schema_hook=lambda _: {"type": "array"})
    text = msgspec.json.encode({"anyOf": list(found), "$defs": parts})
    # what is infinite or no number is null in JSON
    nullable = text.replace(b'"type":"number"', b'"type":["number","null"]')
    told: dict[str, Any] = msgspec.json.decode(nullable.replace(b"#/components/schemas/", b"#/$defs/"))
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | told


def _encoded(value: Any) -> bytes:
    return msgspec.json.encode(value, enc_hook=_plain)


def _plain(value: Any) -> Any:
    """Arrays and their numbers as Python's, all else that JSON does not know as text."""
    return value.tolist() if hasattr(value, "tolist") else str(value)

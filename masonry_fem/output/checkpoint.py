"""Checkpoint: a run between two steps as a file, from which it goes on bit for bit.

    write_checkpoint(out / CHECKPOINT, Checkpoint(...))
    checkpoint = read_checkpoint(out)

It is a NumPy archive: the arrays ``0``, ``1``, ... and ``tree``, JSON as bytes of UTF-8, which points to them
(``records.tree``). Reading it runs no code of it.
"""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem import __version__
from masonry_fem.errors import MasonryError
from masonry_fem.host.atomic import write_atomic
from masonry_fem.march.standing import Standing
from masonry_fem.records.remark import Remark
from masonry_fem.records.tree import TreeError, packed, unpacked

CHECKPOINT = "checkpoint.npz"
FORMAT = 2


class CheckpointError(MasonryError):
    """A checkpoint that is missing, damaged, or does not fit."""


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A run between two steps.

    Attributes
    ----------
    scene : What is run, as TOML; paths in it are relative to the results folder.
    outcome : How it ended; "" while it is under way.
    standing : What its march knows; None before the first step.
    outputs : What the recorders remember. remarks : Made so far.
    """

    scene: str
    outcome: str
    standing: Standing | None
    outputs: dict[str, Any]
    remarks: tuple[Remark, ...]


def write_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Replace a checkpoint; after a kill, and after a power cut, the old or the new one is there.

    Parameters
    ----------
    path : The file. checkpoint : What is saved.

    Raises
    ------
    OutputError : The disk is full, or the place may not be written to.
    """
    node, arrays = packed(checkpoint)
    told = {"format": FORMAT, "version": __version__, "tree": node}
    named: dict[str, Any] = {str(number): array for number, array in enumerate(arrays)}
    file = io.BytesIO()
    np.savez(file, tree=np.frombuffer(json.dumps(told).encode(), np.uint8), **named)
    write_atomic(path, file.getvalue(), durable=True)


def read_checkpoint(folder: Path) -> Checkpoint:
    """The checkpoint of a results folder.

    Raises
    ------
    CheckpointError : There is none, it is damaged, or of another format.
    """
    path = folder / CHECKPOINT
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            told = json.loads(file["tree"].tobytes())
            found, written = told["format"], told["version"]
            if found != FORMAT:
                raise CheckpointError(
                    f"{path} has format {found!r} (masonry_fem {written}), expected {FORMAT}: read it with "
                    "that version, or run the scene again"
                )
            checkpoint = unpacked(told["tree"], [file[str(number)] for number in range(len(file.files) - 1)])
    except (FileNotFoundError, NotADirectoryError) as error:
        raise CheckpointError(
            f"{folder} has no {CHECKPOINT}, expected the results folder of a run with "
            "output.checkpoint_steps or output.checkpoint_time; one that was ended before its first "
            "checkpoint is to be run again"
        ) from error
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, TreeError) as error:
        raise CheckpointError(f"{path} is damaged ({error}); run the scene again") from error
    if not isinstance(checkpoint, Checkpoint):
        raise CheckpointError(f"{path} holds a {type(checkpoint).__name__}, expected a checkpoint")
    return checkpoint

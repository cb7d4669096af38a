"""Acting table: what acts on each block besides contacts, one CSV file per recorded step.

    fields/acting_000012.csv

Together with ``contacts_000012.vtu`` of the same step it is all that one needs to check the balance of every
block (docs/certificate.md).
"""

from __future__ import annotations

import csv
import io

import numpy as np

from masonry_fem.march.acting import Acting
from masonry_fem.march.model import Model
from masonry_fem.output.history import AXES, WRENCH


def acting_table(model: Model, acting: Acting) -> bytes:
    """The table of one step as CSV: forces [N], moments about the world origin [N m], lengths [m].

    Parameters
    ----------
    model : The model.
    acting : Loads, clamp forces and inertia of each block.
    """
    d = model.assembly.dimension
    axes, wrench = AXES[d], WRENCH[3 if d == 2 else 6]
    kind = {block: group.kind for group in model.groups for block in group.blocks.tolist()}
    head = ["block", "name", "kind", "size", "held", *(f"centre_{axis}" for axis in axes)]
    head += [f"{name}_{part}" for name in ("load", "clamp", "inertia") for part in wrench]
    head += [f"displaced_{part}" for part in wrench[d:]]
    numbers = np.column_stack(
        [acting.size, acting.held, acting.centre, acting.load, acting.clamp, acting.inertia, acting.displaced]
    )
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(head)
    names = [block.name for block in model.assembly.blocks]
    rows = zip(names, numbers.tolist(), strict=True)
    table.writerows([number, name, kind[number], *row] for number, (name, row) in enumerate(rows))
    return text.getvalue().encode()

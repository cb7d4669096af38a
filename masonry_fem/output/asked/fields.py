"""ParaView files.

One ``.vtu`` a recorded step for the blocks and one for the contact points, and for each kind a
``.pvd`` series that is rewritten after every step, so that an interrupted run can be read:

    out/blocks.pvd   out/contacts.pvd   out/fields/blocks_000012.vtu   ...

What acts on the blocks beside contacts stands in ``out/fields/acting_000012.csv``: together with the contact
points of the same step it is all that one needs to check the balance of every block (docs/certificate.md).
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.host.atomic import write_atomic
from masonry_fem.march.acting import Acting
from masonry_fem.march.model import Model
from masonry_fem.march.state import STATUS_NAMES, SystemState
from masonry_fem.output.fields import (
    DISPLACEMENT,
    MATERIAL,
    SLIP,
    VELOCITY,
    cell_arrays,
    contact_arrays,
    point_arrays,
    utilisation_arrays,
)
from masonry_fem.output.grid import Grid, fidelity_names, grid_of, three
from masonry_fem.output.history import AXES, WRENCH
from masonry_fem.output.recorder import Request, StepReport
from masonry_fem.output.strength import Strengths
from masonry_fem.output.vtu import (
    Series,
    field_data,
    named,
    remove_others,
    settle_files,
    tie_names,
    write_points,
    write_vtu,
)


def recorder(request: Request) -> FieldFiles:
    """Files of every recorded step."""
    return FieldFiles(
        request.folder,
        materials=request.materials,
        statics=request.statics,
        strengths=request.strengths,
    )


class FieldFiles:
    """Recorder of block and contact fields under ``directory``."""

    dense = False
    amendable = True  # a second record of a step replaces the first

    def __init__(
        self, directory: Path, *, materials: Sequence[str] = (), statics: bool = False,
        strengths: Strengths | None = None,
    ) -> None:  # fmt: skip
        """Prepare files; ``materials`` by block. In ``statics`` velocities are none, and left out."""
        self._directory = Path(directory)
        self._strengths = strengths
        self._materials, self._statics = materials, statics
        self._blocks = Series(self._directory, "blocks")
        self._contacts = Series(self._directory, "contacts")
        self._acting: list[str] = []
        self._settled: set[str] = set()
        self._grid: Grid | None = None

    def start(self, model: Model) -> None:
        """Fix the grid, which serves all steps."""
        self._grid = grid_of(model, shells=True)

    def saved(self) -> dict[str, Any]:
        """The files of both series, and of what acts."""
        settle_files(self._directory, self._acting, self._settled)
        return {
            "blocks": self._blocks.saved(),
            "contacts": self._contacts.saved(),
            "acting": list(self._acting),
        }

    def go_on(self, model: Model, saved: dict[str, Any]) -> None:
        """Go on with both series."""
        self.start(model)
        self._blocks.go_on(saved["blocks"])
        self._contacts.go_on(saved["contacts"])
        # a checkpoint of an earlier version names none, and keeps all
        self._acting = [str(name) for name in saved.get("acting", ())]
        if "acting" in saved:
            remove_others(self._directory, "acting_*.csv", self._acting)
        self._settled = set(self._acting)

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Write one step and bring the two series up to date."""
        grid = self._grid or grid_of(model, shells=True)
        points, cells, meta = point_arrays(grid, model, state), cell_arrays(grid, model, state), {}
        points |= utilisation_arrays(points, grid.point_block, self._strengths)
        cells |= utilisation_arrays(cells, grid.cell_block, self._strengths)
        if self._materials:
            names, number = np.unique(self._materials, return_inverse=True)
            cells[MATERIAL], meta["material_names"] = number[grid.cell_block], named(names)
        meta |= field_data(model, state) | {"fidelity_names": named(fidelity_names())}
        if self._statics:
            points.pop(VELOCITY)
        path = self._blocks.next_path(state.index)
        write_vtu(path, grid, points, cells, meta)
        self._blocks.add(path, report.time)
        if model.contacts.count:
            path = self._contacts.next_path(state.index)
            reference = three(model.contacts.points[:, 0])
            arrays = {DISPLACEMENT: three(state.points) - reference} | contact_arrays(model, state)
            if self._statics:
                arrays.pop(SLIP)
            meta = field_data(model, state) | {"status_names": named(STATUS_NAMES)} | tie_names(model)
            write_points(path, reference, arrays, meta)
            self._contacts.add(path, report.time)
        if state.acting is not None:
            name = f"fields/acting_{state.index:06d}.csv"
            write_atomic(self._directory / name, _acting_table(model, state.acting))
            self._settled.discard(name)
            if name not in self._acting:
                self._acting.append(name)

    def close(self, summary: Any) -> list[Path]:
        """Name the two series."""
        return [series.path for series in (self._blocks, self._contacts) if series.path.exists()]


def _acting_table(model: Model, acting: Acting) -> bytes:
    """What acts on each block besides contacts in a step, as CSV in SI units; moments are about the origin.

    Parameters
    ----------
    model : The model.
    acting : Loads, clamp forces and inertia of each block.
    """
    d = model.assembly.dimension
    axes, wrench = AXES[d], WRENCH[3 if d == 2 else 6]
    kinds = np.empty(len(model.assembly.blocks), dtype=object)
    for group in model.groups:
        kinds[group.blocks] = group.kind
    head = ["block", "name", "kind", "size", "held", *(f"centre_{axis}" for axis in axes)]
    head += [f"{name}_{part}" for name in ("load", "clamp", "inertia") for part in wrench]
    head += [f"displaced_{part}" for part in wrench[d:]]
    numbers = np.column_stack(
        [acting.size, acting.held, acting.centre, acting.load, acting.clamp, acting.inertia, acting.displaced]
    )
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(head)
    told = np.empty((len(numbers), 3), dtype=object)
    told[:, 0], told[:, 1], told[:, 2] = np.arange(len(numbers)), model.assembly.blocks.names, kinds
    table.writerows(np.hstack([told, numbers.astype(object)]).tolist())
    return text.getvalue().encode()

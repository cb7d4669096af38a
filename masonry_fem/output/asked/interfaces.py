"""What joints carry: ``interfaces.csv``, one line a joint between two blocks at the end of a run.

With field files ``interfaces.pvd`` has the same for each recorded step, for ParaView. The header
states units; of plane scenes forces are for a metre of depth. A cell is empty where a joint has no
such value: an open one has no centre of pressure.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.host.atomic import write_table
from masonry_fem.march.determinacy import COMPONENTS, ForceDeterminacy
from masonry_fem.march.march import March
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import without_ties
from masonry_fem.output.interface_fields import InterfaceFields, labels_of
from masonry_fem.output.interfaces import STATUS_WORDS, InterfaceForces, interface_forces
from masonry_fem.output.joint_faces import JointFaces
from masonry_fem.output.recorder import Request, StepReport
from masonry_fem.output.vtu import Series, field_data, named, write_faces

Columns = dict[str, list[Any]]


def recorder(request: Request) -> InterfaceTable:
    """The table, and with field files the series."""
    return InterfaceTable(request.folder, fields=request.asked.fields)


class InterfaceTable:
    """Recorder of ``directory/interfaces.csv`` and, with ``fields``, of ``interfaces.pvd``."""

    dense = False
    amendable = True

    def __init__(self, directory: Path, *, fields: bool = False) -> None:
        self.path, self._fields = Path(directory) / "interfaces.csv", fields
        self._series = Series(Path(directory), "interfaces")
        self._faces: tuple[Model, JointFaces] | None = None
        self._last: tuple[Model, SystemState] | None = None
        self._determined: ForceDeterminacy | None = None

    def start(self, model: Model) -> None:
        """Nothing is written before the first step."""

    def saved(self) -> dict[str, Any]:
        """The files of the series."""
        return {"interfaces": self._series.saved()}

    def go_on(self, model: Model, saved: dict[str, Any]) -> None:
        """Go on with the series."""
        self._series.go_on(saved["interfaces"])

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Keep the state for the table and write the step of the series."""
        self._last = model, state = without_ties(model, state)
        if self._fields and model.interfaces:
            told = interface_forces(model, state, self._faces_of(model))
            path = self._series.next_path(state.index)
            meta = {"status_names": named(STATUS_WORDS), "label_names": named(np.unique(labels_of(model)))}
            write_faces(path, InterfaceFields.of(model, told), field_data(model, state) | meta)
            self._series.add(path, report.time)

    def end(self, made: March, determinacy: ForceDeterminacy | None) -> None:
        """Keep which forces of the last state are facts, for columns of their own."""
        self._determined = determinacy
        if determinacy is not None and made.model.contacts.ties is not None:
            faces = ~made.model.interfaces.tie
            self._determined = replace(
                determinacy,
                resultant=determinacy.resultant[faces],
                determined=determinacy.determined[faces],
            )

    def close(self, summary: Any) -> list[Path]:
        """Write the table."""
        last, self._last = self._last, None
        paths = [self._series.path] if self._series.path.exists() and self._fields else []
        if last is None:
            return paths
        model, state = last
        told = interface_forces(model, state, self._faces_of(model))
        return [write_interfaces(self.path, model, state, told, self._determined), *paths]

    def _faces_of(self, model: Model) -> JointFaces:
        """The faces, which last as long as the model."""
        if self._faces is None or self._faces[0] is not model:
            self._faces = model, JointFaces.of(model)
        return self._faces[1]


def write_interfaces(
    path: Path, model: Model, state: SystemState, told: InterfaceForces,
    determined: ForceDeterminacy | None = None,
) -> Path:  # fmt: skip
    """Write the table of one state."""
    columns = interface_columns(model, state, told)
    if determined is not None:
        columns |= _determined(model, determined, told.faces)
    return write_table(path, columns, zip(*columns.values(), strict=True))


def interface_columns(model: Model, state: SystemState, told: InterfaceForces) -> Columns:
    """The columns of the table by their headings, each with a value a joint."""
    flat = model.assembly.dimension == 2
    newton, square = ("N/m", "m") if flat else ("N", "m2")
    world, axes = ("xy", ("",)) if flat else ("xyz", ("_1", "_2"))
    faces, count = told.faces, len(told.normal)
    joints = model.interfaces.only(faces.first)
    names = np.array(model.assembly.blocks.names, dtype=object)[joints.blocks]
    ratio = told.eccentricity / np.where(faces.size > 0, faces.size, np.inf)
    columns: Columns = {
        "time [s]": [state.time] * count,
        "interface": faces.first.tolist(),
        "candidate": names[:, 0].tolist(),
        "antagonist": names[:, 1].tolist(),
        "label": joints.label_of_each,
        f"area [{square}]": faces.area.tolist(),
        "status": told.status_words,
        "edge": list(told.edge),
        "slides": told.slides.astype(int).tolist(),
        f"normal_force [{newton}]": told.normal.tolist(),
        f"shear_force [{newton}]": told.tangential.tolist(),
        **_spread(f"shear{{}} [{newton}]", axes, told.shear),
        **_spread(f"force_{{}} [{newton}]", world, told.force),
        **_spread(f"moment_{{}} [{newton} m]".replace("N/m m", "N"), "z" if flat else world, told.moment),
        **_spread("centre_{} [m]", world, told.centre),
        **_spread("eccentricity{} [m]", axes, told.eccentricity),
        **_spread("eccentricity_ratio{} [-]", axes, ratio),
        "kern [-]": told.kern.tolist(),
        "edge_share [-]": told.edge_share.tolist(),
        "friction [-]": told.friction.tolist(),
        "friction_used [-]": told.friction_used.tolist(),
        "sliding_margin [-]": told.sliding_margin.tolist(),
        "opening [m]": told.opening.tolist(),
        "sliding [m]": told.sliding[:, 0].tolist(),
        "greatest_sliding [m]": told.sliding[:, 1].tolist(),
        "linear_pressure [Pa]": told.linear.pressure.tolist(),
        f"linear_area [{square}]": told.linear.area.tolist(),
        "plastic_pressure [Pa]": told.plastic.pressure.tolist(),
        f"plastic_area [{square}]": told.plastic.area.tolist(),
        **_spread("middle_{} [m]", world, faces.centroid),
        **_spread("normal_{} [-]", world, faces.normal),
    }
    for number, axis in enumerate(axes):
        columns |= _axis(faces, number, axis, world)
    return columns


def _axis(faces: JointFaces, number: int, ending: str, world: str) -> Columns:
    """Direction, size and sides of the faces along one of their axes."""
    low, high = faces.sides[:, number].T.tolist()
    return _spread(f"axis{ending}_{{}} [-]", world, faces.axes[:, number]) | {
        f"size{ending} [m]": faces.size[:, number].tolist(),
        f"low_side{ending}": low,
        f"high_side{ending}": high,
    }


def _spread(heading: str, names: str | tuple[str, ...], values: np.ndarray) -> Columns:
    """One column a component."""
    return {heading.format(name): values[:, i].tolist() for i, name in enumerate(names)}


def _determined(model: Model, told: ForceDeterminacy, faces: JointFaces) -> Columns:
    """1 where every solution has the same normal force, shear force and centre of pressure of all facets."""
    names = COMPONENTS[model.assembly.dimension]
    whole = np.ones((len(faces.first), len(names)), dtype=bool)
    np.logical_and.at(whole, faces.facets.joint, told.determined)
    rows = {name: whole[:, i] for i, name in enumerate(names)}
    bending = [rows[name] for name in names if name in ("moment", "moment_tangent_1", "moment_tangent_2")]
    shear = [rows[name] for name in names if name.startswith("tangent")]
    centre = np.logical_and.reduce([rows["normal"], *bending])
    return {
        "normal_force_determined": rows["normal"].astype(int).tolist(),
        "shear_force_determined": np.logical_and.reduce(shear).astype(int).tolist(),
        "centre_determined": centre.astype(int).tolist(),
    }

"""Material law: by what the stone of a scene's material yields, a law of the program's or of a user's file.

law = material_law(scene.materials["tuff"], base)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import override

import numpy as np

from masonry_fem.errors import LawError, MasonryError, SceneError
from masonry_fem.fem.material_kinds import law_of
from masonry_fem.fem.material_law import BoolArray, FloatArray, Isotropic, MaterialLaw, Response
from masonry_fem.scene import specs
from masonry_fem.scene.laws import program_faults
from masonry_fem.scene.own_class import Kind, OwnClass, made

PATH = "masonry_fem.fem.material_law.MaterialLaw"
OWN_LAW = Kind(MaterialLaw, "material law", PATH, LawError)  # type: ignore[type-abstract]
KEY = "materials.*.inelastic"
PARTS = {
    "stress": (6,), "tangent": (6, 6), "stored": (), "dissipation": (), "excess": (), "changed": (),
}  # fmt: skip
"""Shape of what a response has at each point; ``internal`` has the law's ``variables``."""


def material_law(stone: specs.Material, base: Path) -> MaterialLaw:
    """The law that a material's ``inelastic`` table describes.

    Parameters
    ----------
    stone : The material, with such a table. base : Folder of the scene file.

    Raises
    ------
    SceneError : Its parameters contradict mechanics or each other; or its file is not trusted, cannot be run,
        or has no such law.
    """
    spec = stone.inelastic
    assert spec is not None  # checked when the stones were laid
    if isinstance(spec, specs.PythonMaterial):
        for fault, expected in program_faults(spec):  # none, if the scene has been checked
            raise SceneError(f"{KEY}.{fault} is {getattr(spec, fault)!r}, expected {expected}")
        own = OwnClass(spec.file, spec.name, "name")
        return _OwnMaterial(made(OWN_LAW, own, base, KEY, lambda _: spec.parameters or {}))
    try:
        return law_of(spec)
    except LawError as error:
        raise SceneError(f"{KEY}: {error}") from error


@dataclass(frozen=True, slots=True)
class _OwnMaterial(MaterialLaw):
    """A law that may raise anything and give back anything.

    Attributes
    ----------
    law : Of the user's file.
    """

    law: MaterialLaw

    def __post_init__(self) -> None:
        """The law has checked its own parameters."""

    @property
    def name(self) -> str:  # type: ignore[override]  # of the law
        """That of the law."""
        return self.law.name

    @property
    def variables(self) -> int:  # type: ignore[override]  # of the law
        """Those of the law."""
        return self.law.variables

    @property
    @override
    def softens(self) -> bool:
        with self._blamed("softens"):
            return bool(self.law.softens)

    @override
    def initial(self, count: int) -> FloatArray:
        with self._blamed("initial"):
            fresh = self.law.initial(count)
            self._check("initial", fresh, (count, self.variables))
            return fresh

    @override
    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:
        with self._blamed("refuse"):
            self.law.refuse(elastic, size)

    @override
    def update(
        self,
        elastic: Isotropic,
        start: FloatArray,
        strain: FloatArray,
        committed: FloatArray,
        size: FloatArray,
    ) -> Response:
        with self._blamed("update"):
            made = self.law.update(elastic, start, strain, committed, size)
            for part, shape in (PARTS | {"internal": (self.variables,)}).items():
                self._check(f"update: {part}", getattr(made, part), (len(strain), *shape))
            return made

    @override
    def yields(self, elastic: Isotropic, strain: FloatArray, size: FloatArray) -> BoolArray:
        with self._blamed("yields"):
            beyond = self.law.yields(elastic, strain, size)
            self._check("yields", beyond, (len(strain),))
            return beyond

    @override
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        with self._blamed("measures"):
            made = dict(self.law.measures(internal))
            for measure, values in made.items():
                self._check(f"measures: {measure}", values, (len(internal),))
            return made

    def _check(self, what: str, values: object, shape: tuple[int, ...]) -> None:
        found, fault = np.asarray(values), ""
        if found.shape != shape:
            fault = f"has the shape {found.shape}, expected {shape}"
        elif not np.isfinite(found).all():
            fault = "is not finite, expected numbers"
        if fault:
            raise LawError(f"material law '{type(self.law).__name__}': {what} {fault}; correct the law")

    @contextmanager
    def _blamed(self, method: str) -> Iterator[None]:
        try:
            yield
        except MasonryError:
            raise
        except Exception as error:  # the user's code may raise anything
            raise LawError(
                f"material law '{type(self.law).__name__}': {method} failed with {type(error).__name__}: "
                f"{error}; correct it (masonry_fem.fem.material_conformance asks a law alone, --debug shows "
                "where)"
            ) from error

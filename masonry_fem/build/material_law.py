"""Material law: by what the stone of a scene's material yields, a law of the program's or of a user's file.

law = material_law(scene.materials["tuff"], base)
"""

from __future__ import annotations

from pathlib import Path

from masonry_fem.build.own_material import OwnMaterial
from masonry_fem.errors import LawError, SceneError
from masonry_fem.fem.material_kinds import law_of
from masonry_fem.fem.material_law import MaterialLaw
from masonry_fem.scene import specs
from masonry_fem.scene.own_class import Kind, OwnClass, made

PATH = "masonry_fem.fem.material_law.MaterialLaw"
OWN_LAW = Kind(MaterialLaw, "material law", PATH, LawError)  # type: ignore[type-abstract]
KEY = "materials.*.inelastic"


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
        for fault, expected in spec.faults():  # none, if the scene has been checked
            raise SceneError(f"{KEY}.{fault} is {getattr(spec, fault)!r}, expected {expected}")
        own = OwnClass(spec.file, spec.name, "name")
        return OwnMaterial(made(OWN_LAW, own, base, KEY, lambda _: spec.parameters or {}))
    try:
        return law_of(spec)
    except LawError as error:
        raise SceneError(f"{KEY}: {error}") from error

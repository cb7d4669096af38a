"""Law file: a joint law that a user wrote beside his scene, as a class of a Python file.

spec = PythonLaw(file="cork.py", law="Cork", trusted=True, parameters={"stiffness": 1e9})
law = law_of_file(spec, 0.6, base, key)
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from masonry_fem.errors import LawError, SceneError
from masonry_fem.joints.law import Law
from masonry_fem.joints.parameters import Parameter
from masonry_fem.scene import specs
from masonry_fem.scene.own_class import Kind, OwnClass, made

JOINT_LAW = Kind(Law, "joint law", "masonry_fem.joints.Law", LawError)  # type: ignore[type-abstract]


def law_of_file(
    spec: specs.PythonLaw, friction: Parameter, base: Path, key: str, arrays: Mapping[str, Any] | None = None
) -> Law:
    """The law that a class in a file makes of the scene's parameters.

    Parameters
    ----------
    spec : File, class and parameters. friction : The joint's, for classes that take one.
    base : Folder of the scene file. key : Where the law stands in the scene, for messages.
    arrays : Parameters in the place of the scene's own, such as those that scatter.

    Raises
    ------
    SceneError : Where the file is not trusted, cannot be run, has no such law, or the law refuses its
        parameters.
    """
    for fault, expected in spec.faults():  # none, if the scene has been checked
        raise SceneError(f"{key}.{fault} is {getattr(spec, fault)!r}, expected {expected}")

    def parameters(accepted: Collection[str]) -> dict[str, Any]:
        given: dict[str, Any] = {**(spec.parameters or {}), **(arrays or {})}
        if "friction" in accepted:
            given.setdefault("friction", friction)
        return given

    return made(JOINT_LAW, OwnClass(spec.file, spec.law, "law"), base, key, parameters)

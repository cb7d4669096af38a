"""Structures: families of blocks, each made by one generator or read from one file; one record each.

A new kind is a record here, listed in ``AnyStructure``, and its builder in ``geometry``.
"""

from __future__ import annotations

from masonry_fem.scene.structures.arch import ArchStructure
from masonry_fem.scene.structures.barrel_vault import BarrelVaultStructure
from masonry_fem.scene.structures.base import MeshSettings, Structure
from masonry_fem.scene.structures.boxes import BlockStructure, StackStructure
from masonry_fem.scene.structures.buttress import ButtressStructure
from masonry_fem.scene.structures.catenary_arch import CatenaryArchStructure
from masonry_fem.scene.structures.column import ColumnStructure
from masonry_fem.scene.structures.corbel import CorbelStructure
from masonry_fem.scene.structures.dome import DomeStructure
from masonry_fem.scene.structures.elliptical_arch import EllipticalArchStructure
from masonry_fem.scene.structures.file import FileStructure
from masonry_fem.scene.structures.flat_arch import FlatArchStructure
from masonry_fem.scene.structures.flying_buttress import FlyingButtressStructure
from masonry_fem.scene.structures.opening import Opening
from masonry_fem.scene.structures.pointed_arch import PointedArchStructure
from masonry_fem.scene.structures.portal import PortalStructure
from masonry_fem.scene.structures.rubble import RubbleStructure
from masonry_fem.scene.structures.staircase import StaircaseStructure
from masonry_fem.scene.structures.survey import SurveyStructure
from masonry_fem.scene.structures.voussoirs import VoussoirStructure
from masonry_fem.scene.structures.wall import WallStructure

__all__ = [
    "AnyStructure",
    "ArchStructure",
    "BarrelVaultStructure",
    "BlockStructure",
    "ButtressStructure",
    "CatenaryArchStructure",
    "ColumnStructure",
    "CorbelStructure",
    "DomeStructure",
    "EllipticalArchStructure",
    "FileStructure",
    "FlatArchStructure",
    "FlyingButtressStructure",
    "MeshSettings",
    "Opening",
    "PointedArchStructure",
    "PortalStructure",
    "RubbleStructure",
    "StackStructure",
    "StaircaseStructure",
    "Structure",
    "SurveyStructure",
    "VoussoirStructure",
    "WallStructure",
]

AnyStructure = (
    BlockStructure
    | StackStructure
    | WallStructure
    | ArchStructure
    | PointedArchStructure
    | FlatArchStructure
    | EllipticalArchStructure
    | CatenaryArchStructure
    | BarrelVaultStructure
    | PortalStructure
    | FlyingButtressStructure
    | DomeStructure
    | CorbelStructure
    | ButtressStructure
    | ColumnStructure
    | StaircaseStructure
    | RubbleStructure
    | FileStructure
    | SurveyStructure
)

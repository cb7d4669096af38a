"""Material: what stones are made of, a table in ``materials``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Union

from msgspec import Meta

from masonry_fem.fem.material_kinds import MaterialRecord, material_kinds
from masonry_fem.records.record import Density, Expansion, Pressure, Spec
from masonry_fem.scene.laws import PythonMaterial

if TYPE_CHECKING:
    AnyMaterialLaw = MaterialRecord
else:  # what ``inelastic`` may be, told from the files there
    AnyMaterialLaw = Union[(*(kind.record for kind in material_kinds().values()), PythonMaterial)]


class Damping(Spec, frozen=True, kw_only=True):
    """Rayleigh damping: the damping matrix is C = α M + β K; of rigid blocks C = α M.

    Attributes
    ----------
    mass : α, the factor of the mass matrix M
    stiffness : β, the factor of the stiffness matrix K
    """

    mass: Annotated[float, Meta(ge=0, extra={"unit": "1/s"})] = 0.0
    stiffness: Annotated[float, Meta(ge=0, extra={"unit": "s"})] = 0.0


class Material(Spec, frozen=True, kw_only=True):
    """Isotropic stone: linear-elastic, and with a law of its own where blocks are inelastic.

    Attributes
    ----------
    density : mass density
    young : Young's modulus; needed by elastic and inelastic blocks
    poisson : Poisson's ratio
    thermal_expansion : strain by each kelvin, the same in all directions; needed where temperatures change
    damping : Rayleigh damping
    inelastic : how the stone yields, chosen by ``law``; needed by inelastic blocks, those of fidelity
        ``auto`` without it stay elastic, rigid and elastic ones ignore it
    promote_at : share of the stress of first yield at which blocks of fidelity ``auto`` become inelastic
    """

    density: Density
    young: Pressure | None = None
    poisson: Annotated[float, Meta(gt=-1, lt=0.5)] = 0.2
    thermal_expansion: Expansion | None = None
    damping: Damping = Damping()
    inelastic: AnyMaterialLaw | None = None
    promote_at: Annotated[float, Meta(gt=0, le=1)] = 0.9

"""Material: what stones are made of, a table in ``materials``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.records.record import Axis, Degrees, Density, Expansion, Pressure, Spec
from masonry_fem.scene.laws import AnyMaterialLaw


class Damping(Spec, frozen=True, kw_only=True):
    """Rayleigh damping: the damping matrix is C = α M + β K; of rigid blocks C = α M.

    With β alone stone is the solid of Kelvin and Voigt, whose stress is C : (ε + β ε̇): it creeps to its
    elastic strain in some 3 β. In statics, which has no rates, there is no damping. Stresses in results are
    those without it.

    Attributes
    ----------
    mass : α, the factor of the mass matrix M
    stiffness : β, the factor of the stiffness matrix K; viscosity over modulus
    """

    mass: Annotated[float, Meta(ge=0, extra={"unit": "1/s"})] = 0.0
    stiffness: Annotated[float, Meta(ge=0, extra={"unit": "s"})] = 0.0


class Orthotropy(Spec, frozen=True, kw_only=True):
    """Linear elasticity of bedded stone, brickwork or timber, with three axes of its own.

    Axes 1, 2, 3 are x, y, z, turned by `angle` about `axis`. Poisson's ratio ν_ij is how much j is narrowed
    by a unit stretch along i, ν_ij/E_i = ν_ji/E_j.

    Attributes
    ----------
    young : E_1, E_2, E_3
    poisson : ν_12, ν_23, ν_13
    shear : shear moduli G_12, G_23, G_13
    angle : angle by which the axes are turned about `axis`
    axis : axis of that turn; z by default
    frame : whether x, y, z are those of each stone as its structure makes it, or of the world at the start
    """

    young: tuple[Pressure, Pressure, Pressure]
    poisson: tuple[float, float, float]
    shear: tuple[Pressure, Pressure, Pressure]
    angle: Degrees = 0.0
    axis: Axis | None = None
    frame: Literal["stone", "world"] = "stone"

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """What contradicts mechanics or the scene's dimension: the key and what is expected of it."""
        from masonry_fem.fem.orthotropic import unstable  # noqa: PLC0415  it needs NumPy

        if dimension == 2 and self.axis is not None:
            yield "axis", "no axis in a 2D scene (the angle is about z)"
        if self.axis is not None and not any(self.axis):
            yield "axis", "an axis that is not zero"
        if fault := unstable(self.young, self.poisson):
            yield "poisson", f"ratios of a material that keeps its energy: {fault}"


class Material(Spec, frozen=True, kw_only=True):
    """Stone: linear-elastic and mostly isotropic, with a law of its own where blocks are inelastic.

    Attributes
    ----------
    density : mass density
    young : Young's modulus; needed by elastic and inelastic blocks
    poisson : Poisson's ratio
    orthotropic : elasticity with axes of its own, in place of `young` and `poisson`
    thermal_expansion : strain by each kelvin, the same in all directions; needed where temperatures change
    damping : Rayleigh damping
    compressive_strength : compressive strength f_c, with which stresses are [compared](strength.md); that of
        the law ``inelastic``, if this has one of that name
    tensile_strength : tensile strength f_t, in the same way
    inelastic : how the stone yields or cracks, chosen by ``law``; needed by inelastic blocks. Without it
        blocks of fidelity ``auto`` stay elastic; those of other fidelities ignore it
    promote_at : share of the stress of first yield at which blocks of fidelity ``auto`` become inelastic
    degree : degree of the polynomials by which blocks of fidelity ``reduced`` deform: 1, 2, 3 and 4 give a
        block at most 6, 24, 54 and 99 modes, in 2D 3, 9, 17 and 27
    """

    density: Density
    young: Pressure | None = None
    poisson: Annotated[float, Meta(gt=-1, lt=0.5)] = 0.2
    thermal_expansion: Expansion | None = None
    damping: Damping = Damping()
    orthotropic: Orthotropy | None = None
    compressive_strength: Pressure | None = None
    tensile_strength: Pressure | None = None
    inelastic: AnyMaterialLaw | None = None
    promote_at: Annotated[float, Meta(gt=0, le=1)] = 0.9
    degree: Annotated[int, Meta(ge=1, le=4)] = 1

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Strengths or elasticity that are given twice."""
        for key in ("compressive_strength", "tensile_strength"):
            own, law = getattr(self, key), getattr(self.inelastic, key, None)
            if own is not None and law is not None:
                yield key, f"none beside inelastic.{key} = {law:g}, which is the stone's"
        if self.orthotropic is not None:
            for key in ("young", "inelastic"):
                if getattr(self, key) is not None:
                    yield key, "none beside 'orthotropic', which is elastic and has its own"

    @property
    def stiff(self) -> bool:
        """Whether it has a stiffness, as blocks that deform need it."""
        return self.young is not None or self.orthotropic is not None

    def strength(self, name: str) -> float | None:
        """A strength of the stone, its own or that of its law; None where neither has it [Pa].

        Parameters
        ----------
        name : ``compressive_strength`` or ``tensile_strength``.
        """
        own: float | None = getattr(self, name)
        return getattr(self.inelastic, name, None) if own is None else own

    @property
    def modulus(self) -> float:
        """Young's modulus, of stone with axes of its own the mean [Pa]."""
        if self.orthotropic is not None:
            return sum(self.orthotropic.young) / len(self.orthotropic.young)
        assert self.young is not None  # of blocks that deform: checked when they are laid
        return self.young

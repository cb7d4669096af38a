"""Laws: what holds the faces of a joint together besides pressure and friction, as a scene describes it.

    [joints.law]
    kind = "mohr_coulomb"
    cohesion = "0.35 MPa"

    [joints.mortar]
    thickness = "10 mm"
    young = "1.2 GPa"

    [joints.dilatancy]
    tangent = 0.1
    bound = "1 mm"

Friction is the joint's own ``friction``. The mechanics is in ``masonry_fem.joints``, under the same names.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.records.record import Distance, FilePath, Length, Name, NonNegative, Pressure, Spec

Stiffness = Annotated[float, Meta(gt=0, extra={"unit": "N/m^3"})]
SurfaceEnergy = Annotated[float, Meta(gt=0, extra={"unit": "J/m^2"})]
Viscosity = Annotated[float, Meta(ge=0, extra={"unit": "J s/m^2"})]
ParameterName = Annotated[
    str,
    Meta(
        pattern=r"^[a-z]\w*(\.\w+)?$",
        extra={"expected": "the name of a parameter such as 'cohesion', 'friction' or 'mortar.young'"},
    ),
]
Cohesion = Annotated[float, Meta(ge=0, extra={"unit": "Pa"})]


class ConstantThreshold(Spec, frozen=True, kw_only=True, tag_field="kind", tag="constant_threshold"):
    """Adhesion of constant strength until it breaks, then none."""

    strength: Pressure
    critical_slip: Distance = 0.0
    critical_opening: Distance = 0.0


class MohrCoulomb(Spec, frozen=True, kw_only=True, tag_field="kind", tag="mohr_coulomb"):
    """Cohesion and friction with a tension cut-off; breaks for good by slide or by opening."""

    cohesion: Cohesion
    tension_strength: Pressure | None = None
    residual_friction: NonNegative | None = None
    critical_slip: Distance = 0.0
    critical_opening: Distance = 0.0


class ElasticJoint(Spec, frozen=True, kw_only=True, tag_field="kind", tag="elastic"):
    """Springs in tension and in shear, contact in compression."""

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness


class ElasticBrittle(Spec, frozen=True, kw_only=True, tag_field="kind", tag="elastic_brittle"):
    """Springs up to their strength, then nothing."""

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    normal_strength: Pressure
    tangential_strength: Pressure


class FremondCangemi(Spec, frozen=True, kw_only=True, tag_field="kind", tag="fremond_cangemi"):
    """Adhesion β that decays with the energy of the springs, with friction (Raous, Cangémi, Cocu)."""

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    energy: SurfaceEnergy
    viscosity: Viscosity = 0.0
    exponent: Annotated[float, Meta(gt=0)] = 1.0
    degree: Literal[1, 2] = 1
    friction_mode: Literal["constant", "damage"] = "constant"
    gradient: Annotated[float, Meta(ge=0, extra={"unit": "J"})] = 0.0


class Softening(Spec, frozen=True, kw_only=True):
    """Springs up to separate strengths, then a softening with separate fracture energies."""

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    normal_strength: Pressure
    tangential_strength: Pressure
    normal_energy: SurfaceEnergy
    tangential_energy: SurfaceEnergy
    friction_mode: Literal["constant", "damage"] = "constant"
    mixing: Annotated[float, Meta(ge=1)] = 1.0
    residual: Annotated[float, Meta(ge=0, lt=1)] = 0.0


class MonerieAcary(Softening, frozen=True, kw_only=True, tag_field="kind", tag="monerie_acary"):
    """Springs up to separate strengths, then a parabolic loss of stress (Monerie and Acary)."""


class Bilinear(Softening, frozen=True, kw_only=True, tag_field="kind", tag="bilinear"):
    """Springs up to separate strengths, then a linear loss of stress."""


class Exponential(Softening, frozen=True, kw_only=True, tag_field="kind", tag="exponential"):
    """Springs up to separate strengths, then an exponential loss of stress."""


class Trapezoidal(Softening, frozen=True, kw_only=True, tag_field="kind", tag="trapezoidal"):
    """Springs up to separate strengths, a plateau, then a linear loss (Tvergaard and Hutchinson)."""

    plateau: Annotated[float, Meta(ge=0, lt=1)] = 0.5


class PythonLaw(Spec, frozen=True, kw_only=True, tag_field="kind", tag="python"):
    """A law of the user's own: a class of a Python file beside the scene.

    The class derives from `masonry_fem.joints.Law`; it gets the `parameters` as keywords, in SI
    units, and the joint's `friction` where it takes one. The file is a program that may do anything on the
    machine: it is run where it is `trusted`, `masonry-fem check` included.
    """

    file: FilePath
    law: Name
    trusted: bool = False
    parameters: dict[Name, float | bool | str] | None = None

    def faults(self) -> Iterator[tuple[str, str]]:
        """A program without trust: the key and what is expected of it."""
        if not self.trusted:
            yield (
                "trusted",
                f"true: '{self.file}' is a program, which may do anything on this machine; read it, then set "
                "trusted = true beside its name or write --trust",
            )


class Mortar(Spec, frozen=True, kw_only=True):
    """Layer of elastic mortar in series with the joint's law, or with dry contact.

    It is given by its stiffnesses, or by its thickness and moduli: then k_N = E'/t, k_T = G/t, where E' is
    that of a layer whose stretch in its plane is hindered.
    """

    normal_stiffness: Stiffness | None = None
    tangential_stiffness: Stiffness | None = None
    thickness: Length | None = None
    young: Pressure | None = None
    poisson: Annotated[float, Meta(gt=-1, lt=0.5)] | None = None
    crushing: Pressure | None = None
    hardening: Stiffness | None = None
    shear_weight: NonNegative = 0.0


class Dilatancy(Spec, frozen=True, kw_only=True):
    """Sliding that opens the joint, by bound (1 − exp(−tangent · slide/bound)); sliding back closes it."""

    tangent: Annotated[float, Meta(gt=0)]
    bound: Length


class Scatter(Spec, frozen=True, kw_only=True):
    """Properties that differ from joint to joint: a random field with one value an interface.

    `variation` has the coefficient of variation (standard deviation over mean) of parameters of the law, of
    `friction`, and of the mortar as `"mortar.young"`; the values in the scene are the means. One field drives
    all parameters of a joint record: a joint that is weak in one is weak in all. The same seed gives the same
    field again. `truncated_normal` is cut off at nothing and at twice the mean.
    """

    seed: Annotated[int, Meta(ge=0)]
    variation: dict[ParameterName, Annotated[float, Meta(gt=0, lt=2)]]
    distribution: Literal["lognormal", "truncated_normal", "weibull"] = "lognormal"
    correlation_length: Length | None = None


AnyLaw = (
    ConstantThreshold
    | MohrCoulomb
    | ElasticJoint
    | ElasticBrittle
    | FremondCangemi
    | MonerieAcary
    | Bilinear
    | Exponential
    | Trapezoidal
    | PythonLaw
)

"""Laws: what holds the faces of a joint together besides pressure and friction, as a scene describes it.

    [joints.law]
    kind = "mohr_coulomb"
    cohesion = "0.35 MPa"

    [joints.mortar]
    thickness = "10 mm"
    young = "1.2 GPa"

    [joints.closure]
    normal_stiffness = "18 GPa/m"
    greatest = "0.1 mm"

    [joints.dilatancy]
    tangent = 0.1
    bound = "1 mm"

Friction is the joint's own ``friction``. Laws stand in their files in ``masonry_fem.joints.laws``; in Python
the record of one is ``law_record("mohr_coulomb", cohesion=0.35e6)``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from msgspec import Meta

from masonry_fem.records.law import LawRecord, MaterialRecord
from masonry_fem.records.record import FilePath, Length, Name, NonNegative, Pressure, Spec

Stiffness = Annotated[float, Meta(gt=0, extra={"unit": "N/m^3"})]
ParameterName = Annotated[
    str,
    Meta(
        pattern=r"^[a-z]\w*(\.\w+)?$",
        extra={"expected": "the name of a parameter such as 'cohesion', 'friction' or 'mortar.young'"},
    ),
]


def law_record(kind: str, **keys: Any) -> LawRecord:
    """The record of a law: ``law_record("mohr_coulomb", cohesion=0.35e6)``."""
    from masonry_fem.joints.kinds import record  # noqa: PLC0415  few scenes have laws

    return record(kind)(**keys)


def material_record(law: str, **keys: Any) -> MaterialRecord:
    """The record of a law: ``material_record("drucker_prager", cohesion=2e6, friction_angle=35.0)``."""
    from masonry_fem.fem.material_kinds import record  # noqa: PLC0415  few scenes have inelastic stones

    return record(law)(**keys)


class PythonLaw(LawRecord, frozen=True, kw_only=True, tag="python"):
    """A law of the user's own: a class of a Python file beside the scene.

    The class derives from `masonry_fem.joints.Law`; it gets the `parameters` as keywords, in SI
    units, and the joint's `friction` where it takes one. The file is a program that may do anything on the
    machine: it is run where it is `trusted`, `masonry-fem check` included.

    Attributes
    ----------
    file : a `.py` file, relative to the scene file
    law : name of the class in it
    trusted : run the file: you have read it
    parameters : its keywords: numbers in SI units, texts, true or false
    """

    file: FilePath
    law: Name
    trusted: bool = False
    parameters: dict[Name, float | bool | str] | None = None

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """No program, or one without trust."""
        return program_faults(self)


class PythonMaterial(MaterialRecord, frozen=True, kw_only=True, tag="python"):
    """A law of the user's own by which stone yields or breaks: a class of a Python file beside the scene.

    The class derives from `masonry_fem.fem.material_law.MaterialLaw`; it gets the `parameters` as keywords,
    in SI units. The file is a program that may do anything on the machine: it is run where it is `trusted`,
    `masonry-fem check` included.

    Attributes
    ----------
    file : a `.py` file, relative to the scene file
    name : of the class in it
    trusted : run the file: you have read it
    parameters : its keywords: numbers in SI units, texts, true or false
    """

    file: FilePath
    name: Name
    trusted: bool = False
    parameters: dict[Name, float | bool | str] | None = None

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """No program, or one without trust."""
        return program_faults(self)


def program_faults(program: PythonLaw | PythonMaterial) -> Iterator[tuple[str, str]]:
    """A file that is no program, or is not trusted: the key and what is expected of it."""
    if not program.file.lower().endswith(".py"):
        yield "file", "a Python file that ends in '.py'"
    if not program.trusted:
        yield (
            "trusted",
            f"true: '{program.file}' is a program, which may do anything on this machine; read it, then set "
            "trusted = true beside its name or write --trust",
        )


class Mortar(Spec, frozen=True, kw_only=True):
    """Layer of elastic mortar in series with the joint's law, or with dry contact.

    It is given by its stiffnesses, or by its thickness and moduli: then k_N = E'/t, k_T = G/t, where E' is
    that of a layer whose stretch in its plane is hindered.

    Attributes
    ----------
    normal_stiffness : k_N: pressure over closing
    tangential_stiffness : k_T: shear stress over slide
    thickness : thickness t of the layer
    young : Young's modulus E of the mortar
    poisson : ν of the mortar; 0.2 if left out
    crushing : compressive strength f_c; if left out the mortar never crushes
    hardening : slope of the pressure over the crushing; k_N/1000 if left out
    shear_weight : C of the cap σ² + C τ² = f_c²; Lourenço and Rots (1997) take 9
    """

    normal_stiffness: Stiffness | None = None
    tangential_stiffness: Stiffness | None = None
    thickness: Length | None = None
    young: Pressure | None = None
    poisson: Annotated[float, Meta(gt=-1, lt=0.5)] | None = None
    crushing: Pressure | None = None
    hardening: Stiffness | None = None
    shear_weight: NonNegative = 0.0


class Closure(Spec, frozen=True, kw_only=True):
    """Asperities of a dry joint that close under pressure: soft at first, stiffer the more they are pressed.

    Under a pressure σ that the joint has not borne before, it closes by σ w_max/(k_0 w_max + σ), a hyperbola
    (Goodman; Bandis et al. 1983). Unloaded and loaded again it is as stiff as it was at the greatest pressure
    so far, and what remains of the closing stays. Walls of dry stones have a third or a quarter of the
    stiffness of their stone.

    Attributes
    ----------
    normal_stiffness : k_0, of the joint that was never pressed: pressure over closing
    greatest : w_max, the closing that no pressure reaches
    shear_ratio : stiffness in shear over that under pressure, until the joint slides
    """

    normal_stiffness: Stiffness
    greatest: Length
    shear_ratio: Annotated[float, Meta(gt=0)] = 0.4


class Dilatancy(Spec, frozen=True, kw_only=True):
    """Sliding that opens the joint, by bound (1 − exp(−tangent · slide/bound)); sliding back closes it.

    Attributes
    ----------
    tangent : tan ψ at the start, at most the friction
    bound : opening after a long slide
    """

    tangent: Annotated[float, Meta(gt=0)]
    bound: Length


class Scatter(Spec, frozen=True, kw_only=True):
    """Properties that differ from joint to joint: a random field with one value an interface.

    `variation` has the coefficient of variation (standard deviation over mean) of parameters of the law, of
    `friction`, and of the mortar as `"mortar.young"`; the values in the scene are the means. One field drives
    all parameters of a joint record: a joint that is weak in one is weak in all. The same seed gives the same
    field again. `truncated_normal` is cut off at nothing and at twice the mean.

    Attributes
    ----------
    seed : of the random field
    variation : coefficients of variation by parameter
    distribution : of the properties, about the values in the scene
    correlation_length : ℓ of the correlation exp(−r²/ℓ²); joints are independent where not given
    """

    seed: Annotated[int, Meta(ge=0)]
    variation: dict[ParameterName, Annotated[float, Meta(gt=0, lt=2)]]
    distribution: Literal["lognormal", "truncated_normal", "weibull"] = "lognormal"
    correlation_length: Length | None = None


# what ``law`` of a joint may be, and ``inelastic`` of a material
AnyLaw = Annotated[LawRecord, Meta(extra={"kinds in": "masonry_fem.joints.kinds"})] | PythonLaw
AnyMaterialLaw = (
    Annotated[MaterialRecord, Meta(extra={"kinds in": "masonry_fem.fem.material_kinds"})] | PythonMaterial
)

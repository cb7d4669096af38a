"""JointChecks: what in a joint record contradicts itself, without building any geometry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import msgspec

from masonry_fem.scene.lines import KeyPath
from masonry_fem.scene.misfit import MisfitError, listed, nearest, wrong
from masonry_fem.scene.specs import Joint, Mortar, PythonLaw, Scatter, Scene

if TYPE_CHECKING:
    from masonry_fem.joints import Law

WIDEST_NORMAL = 0.5  # between nothing and twice the mean there is no room for more
STIFFNESSES = ("normal_stiffness", "tangential_stiffness")
MODULI = ("thickness", "young")


def check_joints(scene: Scene) -> None:
    """Refuse the first joint that contradicts itself.

    Raises
    ------
    MisfitError : There is one.
    """
    for index, joint in enumerate(scene.joints):
        path: KeyPath = ("joints", index)
        low, high = joint.inclination
        if low > high:
            raise wrong((*path, "inclination"), joint.inclination, "the smaller angle first")
        if joint.friction == "no slip":
            _no_slip(joint, path)
        if joint.mortar is not None:
            _mortar(joint.mortar, (*path, "mortar"))
        if joint.scatter is not None:
            _scatter(joint, joint.scatter, (*path, "scatter", "variation"))


def joint_doubts(joint: Joint, place: str) -> Iterator[str]:
    """What is possible in a joint record but hardly meant, as sentences.

    Parameters
    ----------
    joint : The record.
    place : Its key in the scene.
    """
    given = [
        key for key in ("law", "mortar", "closure", "dilatancy", "scatter") if getattr(joint, key) is not None
    ]
    if joint.contact == "none" and given:
        yield f"{place}.{given[0]} has no effect where contact = 'none'; drop one of the two"
    residual = getattr(joint.law, "residual_friction", None)
    if residual is not None and residual > joint.coefficient:
        yield (
            f"{place}.law.residual_friction {residual:g} exceeds the friction {joint.coefficient:g} of "
            "the sound joint"
        )
    if joint.dynamic_friction is not None and joint.dynamic_friction > joint.coefficient:
        yield (
            f"{place}.dynamic_friction {joint.dynamic_friction:g} exceeds the static {joint.coefficient:g}"
        )
    if joint.form == "gap" and (joint.restitution or joint.tangential_restitution):
        yield f"{place}.restitution acts in the velocity form only; expected form = 'velocity'"
    yield from _placement_doubts(joint, place)


def _placement_doubts(joint: Joint, place: str) -> Iterator[str]:
    """Keys that another placement has."""
    if joint.inset != 1 and joint.placement not in (None, "corners", "navier"):
        yield f"{place}.inset belongs to placements 'corners' and 'navier', not '{joint.placement}'"
    if joint.density != 1 and joint.placement != "gauss":
        yield f"{place}.density belongs to placement 'gauss', not '{joint.placement}'"


def _no_slip(joint: Joint, path: KeyPath) -> None:
    """What makes no sense where nothing slides."""
    scatter = joint.scatter is not None and "friction" in joint.scatter.variation
    law = law_class(joint)
    if joint.law is not None and law is not None and law.cone:
        expected = f"a number beside {joint.law.kind}, whose cone it shapes"
        raise wrong((*path, "friction"), joint.friction, expected)
    for name, there in (
        ("dynamic_friction", joint.dynamic_friction is not None),
        ("dilatancy", joint.dilatancy is not None),
        ("scatter.variation.friction", scatter),
    ):
        if there:
            place = ".".join(map(str, path))
            raise wrong(
                (*path, "friction"), joint.friction, f"a number beside {place}.{name}; drop one of them"
            )


def _mortar(mortar: Mortar, path: KeyPath) -> None:
    """Stiffnesses, or thickness and moduli."""
    expected = "normal_stiffness and tangential_stiffness, or thickness and young (and poisson)"
    stiffnesses, moduli = _given(mortar, STIFFNESSES), _given(mortar, MODULI)
    if stiffnesses and (moduli or mortar.poisson is not None):
        raise MisfitError(path, f"{{path}} has both stiffnesses and moduli, expected {expected}; drop one")
    given = stiffnesses or moduli
    lacking = [name for name in (MODULI if moduli else STIFFNESSES) if name not in given]
    if lacking:
        lacks = listed(lacking if given else lacking[:1])
        raise MisfitError(path, f"{{path}} lacks {lacks}, expected {expected}; give it")
    if mortar.hardening is not None and mortar.crushing is None:
        raise wrong((*path, "hardening"), mortar.hardening, "a crushing strength beside it; give 'crushing'")


def _given(mortar: Mortar, names: tuple[str, ...]) -> list[str]:
    return [name for name in names if getattr(mortar, name) is not None]


def _scatter(joint: Joint, scatter: Scatter, path: KeyPath) -> None:
    """Parameters that are there to scatter, and widths that the distribution has."""
    known = list(scattering_names(joint))
    for name, width in scatter.variation.items():
        if name not in known:
            near = nearest(name, known)
            raise MisfitError(
                path,
                f"{{path}} names '{name}', expected numbers that the joint is given: {listed(known)}{near}",
                line_path=(*path, name),
            )
        if scatter.distribution == "truncated_normal" and width > WIDEST_NORMAL:
            expected = f"at most {WIDEST_NORMAL} with distribution 'truncated_normal'; take 'lognormal'"
            raise wrong((*path, name), width, expected)


def law_class(joint: Joint) -> type[Law] | None:
    """The class of a joint's law; None where there is no law, or one of the user's own."""
    if joint.law is None or isinstance(joint.law, PythonLaw):
        return None
    from masonry_fem.joints.kinds import kind  # noqa: PLC0415  it needs NumPy, and few scenes have laws

    return kind(joint.law.kind).law


def scattering_names(joint: Joint) -> Iterator[str]:
    """Names of a joint's numbers that may differ from place to place."""
    yield "friction"
    if isinstance(joint.law, PythonLaw):
        yield from _numbers(joint.law.parameters or {})
    elif joint.law is not None and (law := law_class(joint)) is not None:
        from masonry_fem.joints.parameters import spreads  # noqa: PLC0415  as above

        # the residual friction scatters with the friction; exponents and shares shape a law and do not
        numbers = _numbers(msgspec.structs.asdict(joint.law))
        yield from (name for name in numbers if name != "residual_friction" and spreads(law, name))
    for layer in ("mortar", "closure"):
        if (record := getattr(joint, layer)) is not None:
            numbers = _numbers(msgspec.structs.asdict(record))
            yield from (f"{layer}.{name}" for name in numbers if name not in {"poisson", "shear_ratio"})


def _numbers(values: Mapping[str, Any]) -> list[str]:
    return [name for name, value in values.items() if isinstance(value, float)]

"""JointChecks: what in a joint record contradicts itself, without building any geometry."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from masonry_fem.scene.lines import KeyPath
from masonry_fem.scene.misfit import MisfitError, listed, nearest, wrong
from masonry_fem.scene.specs import Joint, MohrCoulomb, Mortar, PythonLaw, Scatter, Scene

# exponents, shares and switches: they shape a law and have no scatter of their own
SHAPES = ("mixing", "residual", "exponent", "degree", "plateau", "gradient", "poisson")
WIDEST_NORMAL = 0.5  # between nothing and twice the mean there is no room for more


def check_joints(scene: Scene) -> None:
    """Raise a MisfitError for the first joint that contradicts itself."""
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


def _no_slip(joint: Joint, path: KeyPath) -> None:
    """What makes no sense where nothing slides."""
    scatter = joint.scatter is not None and "friction" in joint.scatter.variation
    if isinstance(joint.law, MohrCoulomb):
        raise wrong((*path, "friction"), joint.friction, "a number beside mohr_coulomb, whose cone it shapes")
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
    forms = (("normal_stiffness", "tangential_stiffness"), ("thickness", "young"))
    given = [[name for name in form if getattr(mortar, name) is not None] for form in forms]
    expected = "normal_stiffness and tangential_stiffness, or thickness and young (and poisson)"
    if all(given) or (given[0] and mortar.poisson is not None):
        raise MisfitError(path, f"{{path}} has both stiffnesses and moduli, expected {expected}; drop one")
    whole = given[0] or given[1]
    form = forms[0] if given[0] else forms[1]
    if len(whole) < len(form):
        lacking = [name for name in form if name not in whole] if whole else ["normal_stiffness"]
        raise MisfitError(path, f"{{path}} lacks {listed(lacking)}, expected {expected}; give it")
    if mortar.hardening is not None and mortar.crushing is None:
        raise wrong((*path, "hardening"), mortar.hardening, "a crushing strength beside it; give 'crushing'")


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


def scattering_names(joint: Joint) -> Iterator[str]:
    """Names of a joint's numbers that may differ from place to place."""
    yield "friction"
    for prefix, record in (("", joint.law), ("mortar.", joint.mortar)):
        given = {} if record is None else msgspec.structs.asdict(record)
        if isinstance(record, PythonLaw):
            given = record.parameters or {}
        for name, value in given.items():
            # the residual friction scatters with the friction
            if isinstance(value, float) and name not in {*SHAPES, "residual_friction"}:
                yield f"{prefix}{name}"

"""Material doubt: a number that no stone has, or that the elements or the solver do badly with."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.fidelities import deforms
from masonry_fem.scene.specs import Scene

DENSITIES = (200.0, 12e3)  # aerated concrete to lead [kg/m^3]
STIFFNESSES = (1e6, 1e12)  # rubber to beyond any stone [Pa]
STRENGTHS = {"compressive_strength": (1e4, 1e9), "tensile_strength": (1e2, 1e8)}  # earth to basalt [Pa]
LOCKING = 0.4  # ν from which linear elements are too stiff in bending by a tenth and more
# Relative stress error in the stiffer of two blocks with non-matching meshes, divided by the ratio of their
# moduli and by the solver's tolerance (from patch tests; the tolerance is relative to the softer block)
MAGNIFIED = 50.0
TOLERATED = 1e-3  # relative stress error that needs no warning
FINEST = 1e-14  # smallest tolerance that makes sense


def material_doubts(scene: Scene) -> Iterator[str]:
    """Numbers that no stone has, mostly MPa taken for Pa and g/cm³ for kg/m³, and what is hard to compute."""
    for name, material in scene.materials.items():
        if not DENSITIES[0] <= material.density <= DENSITIES[1]:
            yield (
                f"materials.{name}.density is {material.density:g} kg/m^3, "
                f"masonry has {DENSITIES[0]:g} to {DENSITIES[1]:g}"
            )
        young = material.young
        if young is not None and not STIFFNESSES[0] <= young <= STIFFNESSES[1]:
            yield (
                f"materials.{name}.young is {young:g} Pa, "
                f"masonry has {STIFFNESSES[0]:g} to {STIFFNESSES[1]:g} (is it in MPa?)"
            )
        for key, (least, most) in STRENGTHS.items():
            strength = getattr(material, key)
            if strength is not None and not least <= strength <= most:
                yield (
                    f"materials.{name}.{key} is {strength:g} Pa, "
                    f"stone has {least:g} to {most:g} (is it in MPa?)"
                )
    known = any(stone.strength(key) for stone in scene.materials.values() for key in STRENGTHS)
    if scene.design.material_factor != 1.0 and not known:
        yield (
            f"design.material_factor is {scene.design.material_factor:g}, but no material has a strength to "
            "be divided by it; expected materials.NAME.compressive_strength or tensile_strength"
        )
    users = _elastic(scene)
    yield from _locking(scene, users)
    yield from _contrast(scene, users)


def _elastic(scene: Scene) -> dict[str, set[str]]:
    """Elements of the blocks that deform, by material; overrides may have any of them."""
    users: dict[str, set[str]] = {}
    elements = {(structure.mesh or scene.mesh).elements for structure in scene.structures}
    for structure in scene.structures:
        if deforms(structure.fidelity or scene.fidelity) and not getattr(structure, "support", False):
            users.setdefault(structure.material, set()).add((structure.mesh or scene.mesh).elements)
    for override in scene.overrides:
        if override.material is not None and deforms(override.fidelity or scene.fidelity):
            users.setdefault(override.material, set()).update(elements)
    return users


def _locking(scene: Scene, users: dict[str, set[str]]) -> Iterator[str]:
    for name, elements in users.items():
        linear = sorted(elements & {"P1", "Q1"})
        poisson = scene.materials[name].poisson
        if linear and poisson > LOCKING and (scene.dimension == 3 or scene.plane == "strain"):
            yield (
                f"materials.{name}.poisson is {poisson:g}: {' and '.join(linear)} elements lock: they are "
                "much too stiff where blocks bend; expected mesh.element = 'Q2' or 'P2'"
            )


def _contrast(scene: Scene, users: dict[str, set[str]]) -> Iterator[str]:
    known = [(young, name) for name in users if (young := scene.materials[name].young) is not None]
    if len(known) < 2:
        return
    (soft, softer), (stiff, stiffer) = min(known), max(known)
    tolerance = TOLERATED * soft / stiff / MAGNIFIED
    if scene.solver.aim > tolerance:
        cure = f"make '{stiffer}' rigid"
        if tolerance >= FINEST:
            cure += f", or solver.tolerance at most {tolerance:.0e}"
        yield (
            f"materials.{stiffer}.young is {stiff / soft:.0e} times that of '{softer}': where their blocks "
            f"meet, the solver's tolerance does not bound the stress of the stiffer; {cure}"
        )

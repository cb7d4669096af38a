"""Every material law with the parameters of its own example, and with some more."""

import tomllib

import msgspec

from masonry_fem.fem.material_kinds import law_of, material_kinds
from masonry_fem.records import docstring
from masonry_fem.scene.fitting import fitted
from masonry_fem.scene.laws import material_record


def of_example(name):
    """The law as the example of its docstring has it."""
    record = material_kinds()[name].record
    table = tomllib.loads(docstring.example(record))
    info = msgspec.inspect.type_info(record)
    return law_of(fitted(table, info, ("inelastic",), 3))


LAWS = {
    **{name: of_example(name) for name in material_kinds()},
    "associated": law_of(material_record("drucker_prager", cohesion=1e6, friction_angle=30.0)),
    "hardening": law_of(
        material_record(
            "drucker_prager", cohesion=1e6, friction_angle=40.0, dilatancy_angle=0.0, hardening=2e9
        )
    ),
    "cap": law_of(
        material_record(
            "drucker_prager",
            cohesion=2e6,
            friction_angle=35.0,
            dilatancy_angle=10.0,
            tension_cutoff=6e5,
            crushing_pressure=5e6,
        )
    ),
    "cap that hardens": law_of(
        material_record(
            "drucker_prager",
            cohesion=1e6,
            friction_angle=30.0,
            dilatancy_angle=0.0,
            hardening=1e9,
            crushing_pressure=3e6,
            crushing_hardening=4e9,
        )
    ),
    "pyramid": law_of(material_record("mohr_coulomb", cohesion=1e6, friction_angle=30.0)),
    "pyramid without dilatancy": law_of(
        material_record("mohr_coulomb", cohesion=1e6, friction_angle=40.0, dilatancy_angle=0.0)
    ),
    "Tresca": law_of(material_record("mohr_coulomb", cohesion=1e6, friction_angle=0.0)),
    "Tresca cut off": law_of(
        material_record("mohr_coulomb", cohesion=1e6, friction_angle=0.0, tensile_strength=1e5)
    ),
    "pyramid that hardens": law_of(
        material_record("mohr_coulomb", cohesion=1e6, friction_angle=30.0, dilatancy_angle=5.0, hardening=2e9)
    ),
    "pyramid that softens": law_of(
        material_record(
            "mohr_coulomb",
            cohesion=2e6,
            friction_angle=35.0,
            dilatancy_angle=10.0,
            tensile_strength=5e5,
            fracture_energy=40.0,
            shear_fracture_energy=3000.0,
            residual=0.1,
        )
    ),
    "pyramid that cracks": law_of(
        material_record("mohr_coulomb", cohesion=1e6, friction_angle=40.0, fracture_energy=60.0)
    ),
    "cracks and crushing that are associated": law_of(
        material_record(
            "damage_plasticity",
            tensile_strength=5e5,
            fracture_energy=20.0,
            compressive_strength=3e6,
            friction_angle=30.0,
        )
    ),
    "von Mises": law_of(material_record("drucker_prager", cohesion=1e6, friction_angle=0.0)),
}

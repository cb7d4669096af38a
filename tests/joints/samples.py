"""One or more joints of every law in the folder, for tests over all of them."""

import tomllib

import numpy as np
from msgspec.inspect import type_info
from msgspec.structs import asdict
from scipy import sparse

from masonry_fem.joints import Bed, Bilinear, Dry, FremondCangemi, Kinetic, MohrCoulomb, Rough, kinds
from masonry_fem.records.docstring import example
from masonry_fem.scene.fitting import fitted

STIFFNESS = {"normal_stiffness": 2e10, "tangential_stiffness": 1e10}
STRENGTH = {"normal_strength": 0.25e6, "tangential_strength": 0.35e6}
ENERGY = {"normal_energy": 18.0, "tangential_energy": 60.0}
FRACTURE = STIFFNESS | STRENGTH | ENERGY

# besides the example in each law's docstring
VARIANTS = {
    "constant_threshold": [{"critical_opening": 2e-5}],
    "mohr_coulomb": [{"tensile_strength": 0.1e6, "critical_slip": 1e-5}],
    "fremond_cangemi": [
        {"viscosity": 5.0, "friction_mode": "damage"},
        {"viscosity": 5.0, "exponent": 2.0},
        {"degree": 2},
    ],
    "monerie_acary": [{"residual": 0.3}],
    "bilinear": [{"friction_mode": "damage"}, {"residual": 0.3}],
    "trapezoidal": [{"mixing": 2.0}],
}


def sampled(name, kind):
    """A law with the keys of its example, and its variants."""
    keys = tomllib.loads(example(kind.law))
    assert keys.get("kind") == name, f"{kind.file}: give a table of a scene file under Examples"
    keys = asdict(fitted(keys, type_info(kind.record), (), None))
    return [kind.law(**{"friction": 0.7} | keys | variant) for variant in ({}, *VARIANTS.get(name, []))]


SAMPLES = [law for name, kind in kinds().items() for law in sampled(name, kind)]


def path_laplacian(spacing, count):
    """−Δ of a row of points with free ends [1/m²], shape (count, count)."""
    ends = np.full(count, 2.0)
    ends[[0, -1]] = 1.0
    beside = sparse.diags_array(np.full(count - 1, -1.0), offsets=1)
    return sparse.csr_array(sparse.diags_array(ends) + beside + beside.T) / spacing**2


POINTS = 10  # of a path, and of the joint along which damage spreads
SPREADING = STIFFNESS | {"energy": 20.0, "gradient": 1e-4, "laplacian": path_laplacian(2e-3, POINTS)}

# what joint records make of these laws, and damage that spreads among all points of a path
COMPOSED = [
    Dry(0.6),
    Bed(MohrCoulomb(cohesion=0.2e6, friction=0.7), 2e10, 1e10),
    Bed(FremondCangemi(**STIFFNESS, energy=20.0), 2e10, 1e10),
    Bed(Dry(0.6), 2e10, 1e10, crushing=0.1e6),
    Rough(Dry(0.6), dilatancy=0.2, bound=5e-5),
    Rough(MohrCoulomb(cohesion=0.2e6, friction=0.7), dilatancy=0.2, bound=5e-5),
    FremondCangemi(**SPREADING),
    FremondCangemi(**SPREADING, viscosity=5.0),
    FremondCangemi(**STIFFNESS, energy=20.0, degree=2, viscosity=5.0),
    Kinetic(Dry(0.6), 0.4),
    Kinetic(MohrCoulomb(cohesion=0.2e6, friction=0.7, residual_friction=0.6), 0.4),
    Kinetic(Bilinear(**FRACTURE, friction_mode="damage"), 0.4),
    Rough(FremondCangemi(**STIFFNESS, energy=20.0), dilatancy=0.2, bound=5e-5),
    Bed(FremondCangemi(**STIFFNESS, energy=20.0, degree=2), 4e10, 2e10),
    Bed(Rough(Kinetic(MohrCoulomb(cohesion=0.2e6, friction=0.7), 0.4), 0.2, 5e-5), 2e10, 1e10),
    Bed(Kinetic(Bilinear(**FRACTURE), 0.4), 4e10, 2e10, crushing=0.15e6, shear_weight=9.0),
    Bed(MohrCoulomb(cohesion=0.2e6, friction=0.7), 4e10, 2e10, crushing=0.15e6, shear_weight=9.0),
]
ALL = SAMPLES + COMPOSED


def label(law):
    """Name of a sample in a test's title."""
    return f"{law.name}-{ALL.index(law)}" if law in ALL else law.name


def wander(seed, dimension, steps=12, size=4e-5, points=POINTS):
    """Paths of jumps that open, slide, close and turn, shape (steps, points, dimension)."""
    rng = np.random.default_rng(seed)
    scale = size * rng.uniform(0.1, 1.0, (1, points, 1))
    path = np.cumsum(rng.normal(size=(steps, points, dimension)), axis=0) * scale
    path[:, :, 0] = np.maximum(path[:, :, 0], 0.0)
    return path


def finer(path, parts):
    """The same paths in smaller steps, from zero."""
    knots = np.concatenate([np.zeros_like(path[:1]), path])
    share = (np.arange(1, parts + 1) / parts)[None, :, None, None]
    steps = knots[:-1, None] + share * np.diff(knots, axis=0)[:, None]
    return steps.reshape(-1, *path.shape[1:])

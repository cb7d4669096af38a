"""Joint laws: how the faces of a joint hold together, one file a law.

To add a law write its file in ``laws``; see ``law.py`` for what it owes and docs/add_a_law.md for how, step
by step.

    law = MohrCoulomb(cohesion=0.35e6, friction=0.75)
    history = probe(law, jumps, pressure=0.1e6)
"""

from masonry_fem.joints.assignment import Assignment
from masonry_fem.joints.conformance import violations
from masonry_fem.joints.kinds import kinds
from masonry_fem.joints.law import Law, rub, spread
from masonry_fem.joints.laws.bilinear import Bilinear
from masonry_fem.joints.laws.constant_threshold import ConstantThreshold
from masonry_fem.joints.laws.elastic import Elastic
from masonry_fem.joints.laws.elastic_brittle import ElasticBrittle
from masonry_fem.joints.laws.exponential import Exponential
from masonry_fem.joints.laws.fremond_cangemi import FremondCangemi
from masonry_fem.joints.laws.mohr_coulomb import MohrCoulomb
from masonry_fem.joints.laws.monerie_acary import MonerieAcary
from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution
from masonry_fem.joints.laws.parts.bed import Bed
from masonry_fem.joints.laws.parts.closure import Closure, fit_closure
from masonry_fem.joints.laws.parts.dry import Dry
from masonry_fem.joints.laws.parts.kinetic import Kinetic
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle
from masonry_fem.joints.laws.parts.rough import Rough
from masonry_fem.joints.laws.parts.softening import Softening
from masonry_fem.joints.laws.trapezoidal import Trapezoidal
from masonry_fem.joints.probe import History, probe, pull
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState
from masonry_fem.joints.tangent import linearise

__all__ = [
    "Adhesive",
    "Assignment",
    "Bed",
    "Bilinear",
    "Closure",
    "ConstantThreshold",
    "Dry",
    "Elastic",
    "ElasticBrittle",
    "Evolution",
    "Exponential",
    "FremondCangemi",
    "History",
    "JointState",
    "Kinetic",
    "Law",
    "MohrCoulomb",
    "MonerieAcary",
    "Reduction",
    "RigidBrittle",
    "Rough",
    "Softening",
    "Trapezoidal",
    "fit_closure",
    "kinds",
    "linearise",
    "probe",
    "pull",
    "rub",
    "spread",
    "violations",
]

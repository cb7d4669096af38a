"""The command line on ranks of which one fails in its work, as its first argument says."""

import os
import sys

import numpy as np

from masonry_fem.cli import main
from masonry_fem.errors import GeometryError
from masonry_fem.nscd.solvers.elastic_ranks import portion

whole, how, last = portion.Portion, sys.argv[1], os.environ["PMI_RANK"] == "1"


class Failing(whole):
    singular = how == "singular"  # once

    def _begun(self, problem):
        if last and how == "agreed":
            raise GeometryError("block 'wall.c1.b1' is not there")
        return super()._begun(problem)

    def solve(self, *given):
        if last and how == "alone":
            raise ZeroDivisionError("of one rank")
        if not last and how == "interrupted":
            raise KeyboardInterrupt
        return super().solve(*given)

    def _prepared(self, values):
        if last and Failing.singular:
            Failing.singular = False
            raise np.linalg.LinAlgError("Singular matrix")
        return super()._prepared(values)


portion.Portion = Failing
sys.exit(main(sys.argv[2:]))

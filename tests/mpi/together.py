"""The command line on ranks that factorise the bodies' matrix together, however few bodies there are."""

import sys

from masonry_fem.cli import main
from masonry_fem.nscd.solvers.elastic_ranks import division

division.TOGETHER = 0
sys.exit(main(sys.argv[1:]))

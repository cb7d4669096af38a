"""The command line on ranks, for which a wall and its parts are large from 1500 contacts on.

All ranks then solve for such parts together, and for parts of these, which otherwise takes 100×100 bricks.
"""

import sys

from masonry_fem.cli import main
from masonry_fem.host.ranks import team
from masonry_fem.nscd.methods import newton
from masonry_fem.nscd.solvers import settling

FEW = 1500
for module in (newton, settling):
    module.FACTORED = module.CONTACTS = FEW
rested, depth, deepest = settling._rested, 0, 0


def counted(groups, *given):
    """The states of parts, and how many parts are within each other."""
    global depth, deepest  # noqa: PLW0603
    depth += 1
    deepest = max(deepest, depth)
    try:
        return rested(groups, *given)
    finally:
        depth -= 1


settling._rested = counted
code = main(sys.argv[1:])
if deepest:
    print(f"parts within parts: {deepest}, ranks {team().size}", file=sys.stderr)
sys.exit(code)

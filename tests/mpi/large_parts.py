"""The command line on ranks, for which a wall and its parts are large from 1500 contacts on, and all slow.

All ranks then solve for such parts together, and for parts of these, which otherwise takes 100×100 bricks.
"""

import sys

from masonry_fem.cli import main
from masonry_fem.host.ranks import team
from masonry_fem.nscd.methods import newton
from masonry_fem.nscd.solvers import settling

newton.FACTORED = settling.FACTORED = settling.MANY = 1500
newton._SLOW = 0.0
rested, within, depths = settling._rested, [], [0]


def counted(groups, *given):
    """The states of parts; how many parts they are within is put down."""
    within.append(groups)
    depths.append(len(within))
    try:
        return rested(groups, *given)
    finally:
        within.pop()


settling._rested = counted
code = main(sys.argv[1:])
if len(depths) > 1:
    print(f"parts within parts: {max(depths)}, ranks {team().size}", file=sys.stderr)
sys.exit(code)

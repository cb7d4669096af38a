"""``python -m masonry_fem.cli``."""

import sys

from masonry_fem.cli import main

sys.exit(main())

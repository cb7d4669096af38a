"""``python -m masonry_fem``."""

import sys

from masonry_fem.cli import main

sys.exit(main())

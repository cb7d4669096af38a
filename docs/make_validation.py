"""Write docs/validation.md from the cases in tests/validation/known.py, computed anew.

python docs/make_validation.py            # computes them and writes the page
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "validation.md"


def main() -> int:
    """Write the page."""
    sys.path.insert(0, str(ROOT))
    from tests.validation.known import CASES, page  # noqa: PLC0415 - found by the line above

    PAGE.write_text(page({case: case.compute() for case in CASES}), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""What a sentence names of many things."""

import pytest

from masonry_fem.records.remark import first_few


@pytest.mark.parametrize(
    ("texts", "how", "said"),
    [
        ("", {}, ""),
        ("a", {}, "a"),
        ("ab", {}, "a, b"),
        ("abc", {}, "a, b and 1 more"),
        ("abcd", {"separator": "; ", "noun": "pairs"}, "a; b and 2 more pairs"),
    ],
)
def test_first_few(texts: str, how: dict[str, str], said: str) -> None:
    assert first_few(iter(texts), 2, **how) == said

"""PNG files as other programs read them."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from masonry_fem.output.png import png


@pytest.mark.parametrize("size", [(1, 1), (7, 3), (40, 61)])
def test_a_reader_finds_the_same_pixels_and_resolution(size: tuple[int, int]) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (*size, 3), dtype=np.uint8)
    content = png(pixels)
    with Image.open(io.BytesIO(content)) as found:
        found.load()
        assert (found.format, found.mode) == ("PNG", "RGB")
        np.testing.assert_array_equal(np.asarray(found), pixels)
        assert found.info["dpi"] == pytest.approx((100, 100), rel=1e-4)
    with Image.open(io.BytesIO(content)) as found:
        found.verify()  # sums of all chunks


def test_a_page_of_few_colours_is_small() -> None:
    page = np.full((1200, 1600, 3), 255, dtype=np.uint8)
    page[300:900, 400:1200] = (200, 30, 60)
    assert len(png(page)) < 0.01 * page.size

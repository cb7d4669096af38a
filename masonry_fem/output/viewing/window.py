"""Window: sliders for steps, amplification and a section, keys for fields and axes, clicks on blocks."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_fem.output.sheet import INK
from masonry_fem.output.viewing.look import Section
from masonry_fem.output.viewing.showing import Showing

APART = 0.3  # by which the key 'a' pulls stones apart, of their distances from the middle
WORDS = (
    "click: a block   f: next field   x, y, z: section across that axis   n: no section   arrows: step\n"
    "a: stones apart   drag: turn   wheel: zoom   shift and drag: move   q: end"
)


class Controls:
    """What the user does with a window.

    Parameters
    ----------
    showing : What the window shows.
    """

    def __init__(self, showing: Showing) -> None:
        self._showing = showing
        self._axis: int | None = None if showing.look.section is None else showing.look.section.axis
        self._most = 4.0 * max(showing.look.factor, 1.0)

    def fit(self) -> None:
        """Put sliders, keys and clicks into the plotter."""
        showing, plotter = self._showing, self._showing.plotter
        count = len(showing.recorded.files)
        if count > 1:
            plotter.add_slider_widget(
                lambda value: showing.step(round(value) - 1), rng=(1, count), value=showing.place + 1,
                title="step", pointa=(0.03, 0.1), pointb=(0.28, 0.1), **_LOOK, fmt="%.0f",
            )  # fmt: skip
        plotter.add_slider_widget(
            showing.factor, rng=(0.0, self._most), value=showing.look.factor, title="amplification",
            pointa=(0.34, 0.1), pointb=(0.59, 0.1), **_LOOK, fmt="%.0f",
        )  # fmt: skip
        plotter.add_slider_widget(
            self._cut, rng=(0.0, 1.0), value=0.5, title="section", pointa=(0.65, 0.1),
            pointb=(0.87, 0.1), **_LOOK, fmt="%.2f",
        )  # fmt: skip
        plotter.add_text(WORDS, position="upper_right", color=INK, font_size=7)
        for key, act in self.keys().items():
            plotter.add_key_event(key, act)
        plotter.track_click_position(self._click, side="left", viewport=False)

    def keys(self) -> dict[str, Any]:
        """What each key does."""
        return {
            "f": self.next_field, "a": self.pull, "n": lambda: self.across(None),
            "Right": lambda: self._go(1), "Left": lambda: self._go(-1),
            **{"xyz"[i]: lambda i=i: self.across(i) for i in range(3)},
        }  # fmt: skip

    def next_field(self) -> None:
        """Colour the next field."""
        names = self._showing.fields
        at = names.index(self._showing.look.field) if self._showing.look.field in names else -1
        self._showing.field(names[(at + 1) % len(names)])
        self._showing.plotter.render()

    def pull(self) -> None:
        """Pull the stones apart, or put them together again."""
        self._showing.apart(0.0 if self._showing.look.apart else APART)
        self._showing.plotter.render()

    def across(self, axis: int | None) -> None:
        """Cut across an axis, in the middle at first; None: nowhere."""
        self._axis = axis
        if axis is None:
            self._showing.section(None)
        else:
            self._cut(0.5)
        self._showing.plotter.render()

    def _cut(self, share: float) -> None:
        """Move the section plane, from one end (0) to the other (1)."""
        if self._axis is not None:
            self._showing.section(plane_at(self._showing, self._axis, share))

    def _go(self, by: int) -> None:
        self._showing.step(self._showing.place + by)
        self._showing.plotter.render()

    def _click(self, *_: Any) -> None:
        x, y = self._showing.plotter.iren.get_event_position()
        self._showing.pick(x, y)
        self._showing.plotter.render()


_LOOK: dict[str, Any] = {"color": INK, "style": "modern", "title_height": 0.018, "tube_width": 0.002}


def plane_at(showing: Showing, axis: int, share: float) -> Section:
    """The plane across an axis at a share of the structure's extent, kept off both ends.

    Parameters
    ----------
    showing : What is shown. axis : 0, 1 or 2. share : 0 to 1.
    """
    points = np.asarray(showing.recorded.blocks(showing.place).points)[:, axis]
    low, high = float(points.min()), float(points.max())
    return Section(axis, low + (0.001 + 0.998 * min(max(share, 0.0), 1.0)) * (high - low))


def open_window(showing: Showing) -> None:
    """Show until the user closes the window."""
    Controls(showing).fit()
    showing.plotter.show()

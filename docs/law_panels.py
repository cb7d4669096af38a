"""Panels of the pictures in docs/images/laws: a test of a couplet each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from law_couplet import MACHINE, MEGA, MICRO, FloatArray, Specimen, growing, loaded, shear, tension, turning
from matplotlib.axes import Axes

from masonry_fem.joints import Bilinear, Exponential, Law, MonerieAcary, Trapezoidal, probe, pull
from masonry_fem.joints.laws.parts.softening import Softening

COLOURS = ("#1f5fa8", "#e07b1a", "#1b7f5c", "#8a4fa3", "#22262b")


def draw(axes: Axes, x: FloatArray, y: FloatArray, colour: int, label: str = "", **style: Any) -> None:
    """A curve from the origin on."""
    axes.plot(
        np.concatenate([[0.0], x]), np.concatenate([[0.0], y]), color=COLOURS[colour], label=label, **style
    )


def label(axes: Axes, title: str, x: str, y: str, headroom: float = 0.0) -> None:
    """Title and axes of a panel; ``headroom`` is what the legend needs of its height."""
    low, high = axes.get_ylim()
    axes.set_ylim(top=high + headroom * (high - low))
    axes.set_title(title, loc="left", fontsize=10)
    axes.set(xlabel=x, ylabel=y)
    axes.axhline(0.0, color="#c8ccd2", lw=0.8, zorder=0)
    axes.spines[["top", "right"]].set_visible(False)
    if axes.get_legend_handles_labels()[1]:
        place = {"loc": "upper right", "ncols": 2, "columnspacing": 1.2} if headroom else {}
        axes.legend(frameon=False, fontsize=8.5, **place)


def tension_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Tension, monotonic, and unloaded and loaded again."""
    u = tests.opening
    once = loaded(partial(tension, law, tests), u, 0)
    again = tension(law, tests, turning(0.12 * u, 0.0, 0.4 * u, 0.0, u))
    draw(axes, once.jump[:, 0] / MICRO, once.stress[:, 0] / MEGA, 0, "pulled on", lw=2.4)
    draw(axes, again.jump[:, 0] / MICRO, again.stress[:, 0] / MEGA, 1, "unloaded twice", lw=1.2, ls="--")
    label(axes, "Tension", "opening [µm]", "tensile stress [MPa]")


def shear_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Shear under several pressures, one of them unloaded and turned."""
    s = tests.slide
    for colour, pressure in enumerate(tests.pressures):
        once = loaded(partial(shear, law, tests, pressure=pressure), s, 1)
        draw(
            axes,
            once.jump[:, 1] / MICRO,
            once.stress[:, 1] / MEGA,
            colour,
            f"under {pressure / MEGA:g} MPa",
            lw=2,
        )
    turned = shear(law, tests, turning(0.6 * s, 0.0, s), tests.pressures[-1])
    draw(axes, turned.jump[:, 1] / MICRO, turned.stress[:, 1] / MEGA, 4, "slid back and on", lw=1.0, ls="--")
    label(axes, "Shear", "slide [µm]", "shear stress [MPa]", headroom=0.25)


def damage_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """β in tension and in shear."""
    for colour, (name, x) in enumerate((("opening", 0), ("slide", 1))):
        test = partial(shear, law, tests, pressure=tests.pressures[0]) if x else partial(tension, law, tests)
        once = loaded(test, (tests.opening, tests.slide)[x], x)
        jump = np.concatenate([[0.0], np.abs(once.jump[:, x])])
        axes.plot(
            jump / MICRO, np.concatenate([[1.0], once.adhesion]), color=COLOURS[colour], label=name, lw=2
        )
    axes.set_ylim(-0.03, 1.05)
    label(axes, "Adhesion β", "opening or slide [µm]", "β")


def signorini_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Pressed, then opened."""
    path = np.linspace(-0.5e6 / MACHINE, 50e-6, 2000)
    pulled = pull(law, np.stack([path, 0 * path], axis=1), MACHINE)
    axes.plot(pulled.jump[:, 0] / MICRO, -pulled.stress[:, 0] / MEGA, color=COLOURS[0], lw=2.4)
    axes.set_xlim(-5, 50)
    label(axes, "Signorini: no tension, no overlap", "gap [µm]", "pressure [MPa]")


def envelope_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Greatest shear stress over the pressure, and what is left of it."""
    pressures = np.linspace(-0.3e6, 0.5e6, 81)
    slides = np.concatenate([np.linspace(0, 1e6 / MACHINE, 800), [tests.slide]])
    ends = np.stack(np.broadcast_arrays(-pressures / MACHINE, slides[:, None]), axis=2)
    stress = pull(law, ends, MACHINE).stress[:, :, 1]
    axes.plot(pressures / MEGA, stress.max(axis=0) / MEGA, color=COLOURS[0], lw=2.4, label="intact")
    axes.plot(pressures / MEGA, stress[-1] / MEGA, color=COLOURS[1], lw=1.6, ls="--", label="broken")
    axes.axvline(0.0, color="#c8ccd2", lw=0.8, zorder=0)
    label(axes, "Strength", "pressure [MPa], tension negative", "shear stress [MPa]")


def loops_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Shear to and fro."""
    s = tests.slide
    for colour, pressure in enumerate(tests.pressures):
        loop = shear(law, tests, turning(s, -s, s), pressure)
        draw(
            axes,
            loop.jump[:, 1] / MICRO,
            loop.stress[:, 1] / MEGA,
            colour,
            f"under {pressure / MEGA:g} MPa",
            lw=2,
        )
    label(axes, "To and fro", "slide [µm]", "shear stress [MPa]", headroom=0.25)


def mixed_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Length of the stress along proportional openings."""
    for colour, degrees in enumerate((0, 30, 60, 90)):
        angle = np.radians(degrees)
        path = growing(tests.slide)[:, None] * [np.cos(angle), np.sin(angle)]
        once = probe(law, path)
        size, stress = np.linalg.norm(once.jump, axis=1), np.linalg.norm(once.stress, axis=1)
        draw(axes, size / MICRO, stress / MEGA, colour, f"{degrees}° to the normal", lw=2)
    axes.set_xlim(0, 350)
    label(axes, "Opened and slid together", "length of the jump [µm]", "length of the stress [MPa]")


def variants_panel(key: str, values: tuple[float, ...], title: str, symbol: str) -> Callable[..., None]:
    """Tension with other values of one parameter, unloaded once."""

    def panel(axes: Axes, law: Any, tests: Specimen) -> None:
        for colour, value in enumerate(values):
            path = turning(0.35 * tests.opening, 0.0, tests.opening)
            once = tension(replace(law, **{key: value}), tests, path)
            draw(
                axes,
                once.jump[:, 0] / MICRO,
                once.stress[:, 0] / MEGA,
                colour,
                f"{symbol} = {value:g}",
                lw=1.8,
            )
        label(axes, title, "opening [µm]", "tensile stress [MPa]")

    return panel


def rates_panel(axes: Axes, law: Any, tests: Specimen) -> None:
    """Tension at rates against b."""
    critical = np.sqrt(law.energy / law.normal_stiffness)
    for colour, ratio in enumerate((0.0, 0.1, 0.5, 1.0)):
        path = np.linspace(0, tests.opening, 1500)[1:]
        step = (path[1] - path[0]) / (critical * law.energy)  # of a machine of rate w u0/(1 J s/m²)
        once = probe(replace(law, viscosity=ratio), np.stack([path, 0 * path], axis=1), step=step)
        draw(
            axes, once.jump[:, 0] / MICRO, once.stress[:, 0] / MEGA, colour, f"b v/(w u₀) = {ratio:g}", lw=1.8
        )
    label(axes, "Tension at a constant rate v", "opening [µm]", "tensile stress [MPa]")


def friction_mode_panel(axes: Axes, law: Any, tests: Specimen) -> None:
    """Constant friction against friction that comes with damage."""
    for colour, mode in enumerate(("constant", "damage")):
        once = shear(replace(law, friction_mode=mode), tests, growing(tests.slide), tests.pressures[-1])
        draw(
            axes, once.jump[:, 1] / MICRO, once.stress[:, 1] / MEGA, colour, f'friction_mode = "{mode}"', lw=2
        )
    label(axes, f"Shear under {tests.pressures[-1] / MEGA:g} MPa", "slide [µm]", "shear stress [MPa]")


def press_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """A layer of mortar pressed, unloaded, pressed on."""
    pressure = (
        np.concatenate([np.linspace(0, 12, 60)[1:], np.linspace(12, 0, 40), np.linspace(0, 13, 80)]) * MEGA
    )
    found = probe(law, np.zeros((len(pressure), 2)), pressure=pressure)
    draw(axes, -found.jump[:, 0] / MICRO, pressure / MEGA, 0, lw=2)
    label(axes, "Pressure", "closure of the layer [µm]", "pressure [MPa]")


def lift_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Opening that sliding forces."""
    there = shear(law, tests, turning(tests.slide), tests.pressures[0])
    back = shear(law, tests, turning(tests.slide, 0.0), tests.pressures[0])
    draw(axes, there.jump[:, 1] / MICRO, there.jump[:, 0] / MICRO, 0, "there", lw=2.4)
    n = len(there.jump)
    axes.plot(
        back.jump[n:, 1] / MICRO,
        back.jump[n:, 0] / MICRO,
        color=COLOURS[1],
        ls="--",
        lw=1.4,
        label="and back",
    )
    label(axes, "Dilatancy", "slide [µm]", "opening [µm]")


def confined_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """Shear where the surroundings hinder the opening."""
    ends = np.stack([np.zeros(250), growing(tests.slide)], axis=1)
    for colour, stiffness in enumerate((0.5e9, 1e9, 2e9)):
        ends[:, 0] = -tests.pressures[0] / stiffness
        once = pull(law, ends, (stiffness, MACHINE))
        name = f"by {stiffness / 1e9:g} MPa/mm"
        draw(axes, once.jump[:, 1] / MICRO, once.stress[:, 1] / MEGA, colour, name, lw=2)
    title = f"Opening hindered, {tests.pressures[0] / MEGA:g} MPa at first"
    label(axes, title, "slide [µm]", "shear stress [MPa]")


def shapes_panel(axes: Axes, law: Law, tests: Specimen) -> None:
    """The softening laws of one strength and energy."""
    numbers: dict[str, Any] = {
        "normal_stiffness": 82e9, "normal_strength": 0.25e6, "normal_energy": 18.0,
        "tangential_stiffness": 36e9, "tangential_strength": 0.35e6, "tangential_energy": 125.0,
    }  # fmt: skip
    kinds: tuple[type[Softening], ...] = (MonerieAcary, Bilinear, Trapezoidal, Exponential)
    for colour, kind in enumerate(kinds):
        once = probe(kind(**numbers), np.stack([growing(250e-6), np.zeros(250)], axis=1))
        draw(axes, once.jump[:, 0] / MICRO, once.stress[:, 0] / MEGA, colour, kind.name, lw=2)
    label(axes, "One stiffness, one strength, one energy: 18 J/m²", "opening [µm]", "tensile stress [MPa]")

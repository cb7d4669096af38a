"""Make docs/images/laws and the figures in docs/laws from the scene snippet on each page.

    python docs/make_law_images.py              # pictures and figures of all pages
    python docs/make_law_images.py bilinear     # of one
    python docs/make_law_images.py --check      # exit code 1 where the figures of a page are stale

The first TOML block of a page is a joint of a scene. It is read as a scene is, and the law that the
program makes of it is probed: what a page shows and states is what its snippet gives.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from law_couplet import MEGA, MICRO, Specimen, loaded, shear, tension
from law_panels import (
    confined_panel,
    damage_panel,
    envelope_panel,
    friction_mode_panel,
    lift_panel,
    loops_panel,
    mixed_panel,
    press_panel,
    rates_panel,
    shapes_panel,
    shear_panel,
    signorini_panel,
    tension_panel,
    variants_panel,
)
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from masonry_fem.build import build
from masonry_fem.joints import Dry, Law
from masonry_fem.scene import check, loads

DOCS = Path(__file__).resolve().parent
PAGES, IMAGES = DOCS / "laws", DOCS / "images" / "laws"
SCENE = """
dimension = 2
fidelity = "rigid"
materials.stone.density = 2400
structures = [{ kind = "stack", name = "couplet", material = "stone", size = [1.0, 0.1], count = 2 }]
loads.gravity = [0.0, -9.81]
"""
MARKS = ("<!-- figures: made by docs/make_law_images.py, do not edit -->\n", "<!-- end of figures -->")
BASIC = (tension_panel, shear_panel, damage_panel)
SPECIMENS: dict[str, Specimen] = {
    "dry": Specimen((signorini_panel, shear_panel, loops_panel), opening=0.0, rigid=True),
    "constant_threshold": Specimen((*BASIC, envelope_panel), opening=50e-6, slide=50e-6, rigid=True),
    "mohr_coulomb": Specimen((*BASIC, envelope_panel), opening=50e-6, slide=50e-6, rigid=True),
    "elastic": Specimen((tension_panel, shear_panel), opening=20e-6, slide=100e-6),
    "elastic_brittle": Specimen(BASIC, opening=60e-6, slide=60e-6),
    "fremond_cangemi": Specimen(
        (*BASIC, rates_panel, friction_mode_panel, loops_panel), opening=25e-6, slide=60e-6
    ),
    "monerie_acary": Specimen((*BASIC, variants_panel("residual", (0.0, 0.3, 0.6), "Residual opening", "η"))),
    "bilinear": Specimen((*BASIC, mixed_panel)),
    "trapezoidal": Specimen((*BASIC, variants_panel("plateau", (0.0, 0.3, 0.6, 0.9), "Plateau", "plateau"))),
    "exponential": Specimen(BASIC, opening=400e-6, slide=2000e-6),
    "mortar": Specimen((press_panel, *BASIC), opening=50e-6, slide=100e-6),
    "closure": Specimen((press_panel, shear_panel), opening=0.0, slide=100e-6),
    "dilatancy": Specimen((lift_panel, shear_panel, confined_panel), opening=0.0, slide=3000e-6),
}  # fmt: skip


def law_of(page: str) -> Law:
    """The law of a page's snippet, made as for a run."""
    snippet = re.search(r"```toml\n(\[\[joints\]\].*?)```", (PAGES / f"{page}.md").read_text("utf-8"), re.S)
    if snippet is None:
        raise SystemExit(f"docs/laws/{page}.md has no TOML block that begins with [[joints]]")
    return law_in(snippet[1])


def law_in(joints: str) -> Law:
    """The law of the first of some ``[[joints]]`` tables that any joint of a couplet has."""
    law = build(check(loads(SCENE + joints)), Path()).model.laws.parts[0][0]
    # all dry joints of a scene are one law, with a number for each contact point
    return Dry(friction=float(law.friction[0])) if isinstance(law, Dry) else law


def figures(law: Law, tests: Specimen) -> list[tuple[str, str]]:
    """What the couplet bears and loses, in words."""
    rows, slide = [], f"{tests.slide / MICRO:.0f} µm"
    if tests.opening:
        opened = loaded(partial(tension, law, tests), tests.opening, 0)
        rows.append(("strength in tension", mpa(opened.stress[:, 0].max())))
        rows.append(
            (f"lost to damage by {tests.opening / MICRO:.0f} µm of opening", joule(opened.dissipated[-1]))
        )
    for pressure in tests.pressures:
        slid = loaded(partial(shear, law, tests, pressure=pressure), tests.slide, 1)
        peak, end = slid.stress[:, 1].max(), slid.stress[-1, 1]
        under = f"shear under {pressure / MEGA:g} MPa"
        rows.append((f"{under}: greatest; after {slide}", f"{mpa(peak)}; {mpa(end)}"))
    rows.append((f"lost to damage by {slide} of slide", joule(slid.dissipated[-1])))
    rows.append((f"lost to friction meanwhile, under {pressure / MEGA:g} MPa", joule(slid.rubbed[-1])))
    return rows


def mpa(stress: float) -> str:
    """A stress in words."""
    return f"{stress / MEGA:.3f} MPa"


def joule(energy: float) -> str:
    """An energy of a square metre in words."""
    return f"{energy:.2f} J/m²"


def picture(name: str, law: Law, tests: Specimen) -> Path:
    """Draw the panels of a page, at most three in a row."""
    count = len(tests.panels)
    columns = count if count <= 3 else (count + 1) // 2
    rows = -(-count // columns)
    figure = Figure(figsize=(4.0 * columns, 3.3 * rows), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, panel in zip(np.ravel(figure.subplots(rows, columns)), tests.panels, strict=True):
        panel(axes, law, tests)
    path = IMAGES / f"{name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return light(path, path)


def picture_of_added_law() -> None:
    """Run what docs/add_a_law.md tells its reader to run, and keep the picture that it draws."""
    text = (DOCS / "add_a_law.md").read_text("utf-8")
    with tempfile.TemporaryDirectory() as folder:
        for name, block in re.findall(r"`(\w+\.py)`:\n\n```python\n(.*?)```", text, re.S):
            (Path(folder) / name).write_text(block, "utf-8")
        subprocess.run([sys.executable, "look.py"], cwd=folder, check=True)
        light(Path(folder) / "convex.png", IMAGES / "convex.png")


def light(source: Path, target: Path) -> Path:
    """Copy a picture with few colours."""
    Image.open(source).convert("RGB").quantize(48, dither=Image.Dither.NONE).save(target, optimize=True)
    return target


def filled(page: str, law: Law, tests: Specimen) -> str:
    """The text of a page with the figures of its snippet."""
    text = (PAGES / f"{page}.md").read_text("utf-8")
    rows = "".join(f"| {what} | {value} |\n" for what, value in figures(law, tests))
    before, rest = text.split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    return f"{before}{MARKS[0]}| what the snippet's joint does | |\n|---|---|\n{rows}{MARKS[1]}{after}"


def main(arguments: list[str]) -> int:
    """Write pictures and figures, or check the figures."""
    checking = "--check" in arguments
    stale = []
    for page in [name for name in arguments if name in SPECIMENS] or SPECIMENS:
        law, tests = law_of(page), SPECIMENS[page]
        text, path = filled(page, law, tests), PAGES / f"{page}.md"
        if checking:
            stale += [page] if path.read_text("utf-8") != text else []
            continue
        path.write_text(text, "utf-8")
        print(f"{page}.png  {picture(page, law, tests).stat().st_size / 1e3:.0f} kB")
    if not arguments:
        picture("shapes", Dry(), Specimen((shapes_panel,)))
        picture_of_added_law()
    if stale:
        print(f"stale: {', '.join(stale)}; run python docs/make_law_images.py")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

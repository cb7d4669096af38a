"""Movie: the steps of a run, a displacement that grows, or a mechanism, frame by frame to .mp4 or .gif.

    write_movie(recorded, Path("fall.gif"), "steps", Look("velocity", 1.0))

All frames have one view, one scale of colours and one amplification. GIFs are written by Pillow, MP4s by the
ffmpeg that the wheel imageio-ffmpeg brings.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.rotation import lever
from masonry_fem.errors import OutputError, SceneError
from masonry_fem.host import installation
from masonry_fem.host.atomic import PART, announce, unwritten
from masonry_fem.host.phases import counted
from masonry_fem.output import fields
from masonry_fem.output.backdrop import title_of
from masonry_fem.output.mechanism_picture import PART_COLOURS
from masonry_fem.output.render import Stage, View
from masonry_fem.output.sheet import HELD, LINE, Key, Sheet
from masonry_fem.output.stone_pictures import BEYOND
from masonry_fem.output.viewing.look import VALUES, Look, Shade, Shown
from masonry_fem.output.viewing.recorded import Recorded, told_in

FloatArray = NDArray[np.float64]

KINDS = ("steps", "growth", "mechanism")
ENDINGS = (".mp4", ".gif")
MOST = 150  # frames; of more steps some are left out
SWAY = 36  # frames of a displacement that grows and goes back
LASTS = 6.0  # seconds of a movie of many frames
RATES = (6.0, 25.0)  # least and greatest number of frames a second
SIZE = {".mp4": 1280, ".gif": 960}  # width [pixels]
COLOURS = 128  # of a GIF; more make it larger, not better
CARRIED = 0.12  # of the structure's size: how far a mechanism's fastest corner goes
PART_WORDS = "parts that move"
NONE = 1e-9  # share of a displacement that cannot be seen


def write_movie(recorded: Recorded, path: Path, kind: str | None, look: Look) -> Path:
    """Draw a movie.

    Parameters
    ----------
    recorded : The steps.
    path : Where to, ending in ``.mp4`` or ``.gif``.
    kind : Of ``KINDS``; None: the mechanism where there is no equilibrium, else the steps, or the growth of
        the displacement where one step is recorded.
    look : What is coloured, amplified and cut away.

    Raises
    ------
    SceneError : Another ending, or no mechanism where one is wanted.
    InstallationError : ffmpeg is missing, or pictures cannot be drawn.
    OutputError : The file cannot be written.
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise SceneError(f"--movie '{path}', expected a file that ends in {' or '.join(ENDINGS)}")
    if ending == ".mp4":
        installation.require_extra("movies", f"'{path}' cannot be written")
    kind = kind or suited_kind(recorded)
    made = {"steps": _steps, "growth": _growth, "mechanism": _mechanism}[kind](recorded, look)
    count, frames = made
    rate = float(np.clip(count / LASTS, *RATES))
    _written(path, lambda part: _encoded(part, counted("frames", frames, count), rate, SIZE[ending], ending))
    return path


def suited_kind(recorded: Recorded) -> str:
    """What a movie of these results shows where nobody says it."""
    if told_in(recorded.directory).get("mechanism"):
        return "mechanism"
    return "steps" if len(recorded.files) > 1 else "growth"


# --- frames ---------------------------------------------------------------------------------------


def _steps(recorded: Recorded, look: Look) -> tuple[int, Iterator[Any]]:
    """Step by step."""
    count = len(recorded.files)
    places = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(int)).tolist()
    shade = Shade.of([recorded.blocks(place) for place in places], look.field)
    flat = _dimension(recorded)
    extent = np.concatenate([_ends(look.shown(recorded.blocks(place)).surface, flat) for place in places])

    def drawn() -> Iterator[Any]:
        view = View.of(extent, flat)
        for place in places:
            words = f"Step {place + 1} of {count}, t = {recorded.times[place]:.4g}"
            yield _frame(recorded, view, look.shown(recorded.blocks(place)), shade, _caption(words, look))

    return len(places), drawn()


def _growth(recorded: Recorded, look: Look) -> tuple[int, Iterator[Any]]:
    """The displacement of the last step, growing from none and back."""
    blocks = recorded.blocks(-1)
    shade, flat = Shade.of([blocks], look.field), _dimension(recorded)
    ends = [_ends(replace(look, factor=f).shown(blocks).surface, flat) for f in (NONE, look.factor)]

    def drawn() -> Iterator[Any]:
        view = View.of(np.concatenate(ends), flat)
        for share in _sway():
            now = replace(look, factor=max(share, NONE) * look.factor)
            words = f"{100 * share:.0f} % of the displacement"
            yield _frame(recorded, view, now.shown(blocks), shade, _caption(words, look))

    return SWAY, drawn()


def _mechanism(recorded: Recorded, look: Look) -> tuple[int, Iterator[Any]]:
    """The parts of the mechanism that the summary tells, carried on along their velocities."""
    from matplotlib.colors import ListedColormap  # noqa: PLC0415

    told = told_in(recorded.directory).get("mechanism") or {}
    if not told.get("parts"):
        raise SceneError(
            f"'{recorded.directory}' has no mechanism, expected a run that ended with no_equilibrium; leave "
            "--movie-of out to see its steps"
        )
    blocks = recorded.blocks(-1).copy()
    names = bytes(np.asarray(blocks.field_data["block_names"])).decode().splitlines()
    velocity, part = _velocities(blocks, told["parts"], names)
    blocks.point_data[fields.DISPLACEMENT] = velocity
    blocks.cell_data[PART_WORDS] = part[np.asarray(blocks.cell_data[fields.BLOCK])]
    size = float(np.linalg.norm(np.ptp(np.asarray(blocks.points), axis=0)))
    flat = _dimension(recorded)
    far = CARRIED * size / (float(np.linalg.norm(velocity, axis=1).max()) or 1.0)
    own = Look(PART_WORDS, far, look.section)
    shade = Shade(PART_WORDS, ListedColormap(PART_COLOURS), (-0.5, len(PART_COLOURS) - 0.5), False)
    ends = [_ends(replace(own, factor=f).shown(blocks).surface, flat) for f in (NONE, far)]

    def drawn() -> Iterator[Any]:
        view = View.of(np.concatenate(ends), flat)
        for share in _sway():
            shown = replace(own, factor=max(share, NONE) * far).shown(blocks)
            yield _frame(recorded, view, shown, shade, str(told.get("sentence", "")), bar=False)

    return SWAY, drawn()


def _velocities(
    blocks: Any, parts: list[dict[str, Any]], names: list[str]
) -> tuple[FloatArray, NDArray[np.float64]]:
    """Velocity of each point, shape (n, 3), and the colour's number of each block, NaN where it rests."""
    points = np.asarray(blocks.points, float)
    number = {name: place for place, name in enumerate(names)}
    own = np.full(len(names), -1)
    for place, one in enumerate(parts):
        own[[number[name] for name in one["blocks"] if name in number]] = place
    of = own[np.asarray(blocks.point_data[fields.BLOCK])]
    velocity = np.zeros_like(points)
    for place, one in enumerate(parts):
        here = np.flatnonzero(of == place)
        at, speed, spin = (np.asarray(one[key], float) for key in ("at", "velocity", "spin"))
        d = len(at)
        velocity[here, :d] = speed + lever(points[here, :d] - at) @ spin
    return velocity, np.where(own < 0, np.nan, own % len(PART_COLOURS))


def _sway() -> FloatArray:
    """Shares from 0 to 1 and back, smoothly, one a frame."""
    return 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(SWAY) / SWAY)


def _frame(
    recorded: Recorded, view: View, shown: Shown, shade: Shade, caption: str, *, bar: bool = True
) -> Any:
    """One page, as a Pillow image."""
    sheet = Sheet(title_of(recorded.title, shade.words), caption)
    return draw_shown(sheet, view, shown, shade, bar=bar)


def draw_shown(sheet: Sheet, view: View, shown: Shown, shade: Shade, *, bar: bool = True) -> Any:
    """Draw a step as it is shown on a sheet.

    Parameters
    ----------
    sheet : The page. view : Whence it is seen. shown : The step. shade : Its colours.
    bar : Whether there is a scale of colours.

    Returns
    -------
    A Pillow image.
    """
    factor, _ = shade.label
    surface = shown.surface.copy(deep=False)
    data = surface.point_data if VALUES in surface.point_data else surface.cell_data
    values = np.asarray(data[VALUES], float) / factor
    data[VALUES] = values
    limits = tuple(end / factor for end in shade.limits)
    if bar:
        sheet.bar = shade.bar()
    if np.isnan(values).any():
        sheet.keys.append(Key("rests" if shade.field == PART_WORDS else "no value", HELD))
    options: dict[str, Any] = {"cmap": shade.colours, "clim": limits, "nan_color": HELD, "n_colors": 256}
    if shade.over and shade.field == "utilisation" and shade.limits[1] == 1:
        options["above_color"] = BEYOND
    stage = Stage(view, sheet.image_width)
    stage.surface(surface, scalars=VALUES, **options)
    stage.lines(shown.outline, LINE, 1.5)
    return sheet.page(stage)


def _caption(words: str, look: Look) -> str:
    return f"{words}; displacements × {look.factor:g}"


def _ends(surface: Any, dimension: int) -> FloatArray:
    """The points of a surface that are farthest out in the picture: enough to fit the view to many steps."""
    points = np.asarray(surface.points, float)
    seen = points @ View.of(points, dimension).axes.T
    ends: FloatArray = points[np.concatenate([seen.argmin(axis=0), seen.argmax(axis=0)])]
    return ends


def _dimension(recorded: Recorded) -> int:
    return int(recorded.blocks(-1).field_data["dimension"][0])


# --- files ----------------------------------------------------------------------------------------


def _encoded(part: Path, frames: Iterator[Any], rate: float, width: int, ending: str) -> None:
    small = (_resized(page, width) for page in frames)
    if ending == ".gif":
        _gif(part, small, rate)
    else:
        _mp4(part, small, rate)


def _resized(page: Any, width: int) -> Any:
    """A page of this width and an even height, as video wants."""
    from PIL import Image  # noqa: PLC0415

    tall = 2 * round(page.height * width / page.width / 2)
    return page.resize((width, tall), Image.Resampling.LANCZOS)


def _gif(part: Path, pages: Iterator[Any], rate: float) -> None:
    from PIL import Image  # noqa: PLC0415

    quantised = [page.quantize(COLOURS, dither=Image.Dither.NONE) for page in pages]
    first, *rest = quantised
    first.save(part, "gif", save_all=True, append_images=rest, duration=round(1000 / rate), loop=0)


def _mp4(part: Path, pages: Iterator[Any], rate: float) -> None:
    """By ffmpeg, in the form that browsers and offices play."""
    import imageio_ffmpeg  # noqa: PLC0415

    first = next(pages)
    options = ["-f", "mp4", "-movflags", "+faststart", "-crf", "20"]
    with closing(
        imageio_ffmpeg.write_frames(
            str(part), first.size, fps=rate, codec="libx264", quality=None, macro_block_size=2,
            output_params=options,
        )
    ) as writer:  # fmt: skip
        writer.send(None)
        writer.send(np.ascontiguousarray(first))
        for page in pages:
            writer.send(np.ascontiguousarray(page))


def _written(path: Path, write: Callable[[Path], None]) -> None:
    """Write a file under another name first, so that there is no half one."""
    part = path.with_name(path.name + PART)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        announce(path)
        try:
            write(part)
            os.replace(part, path)
        except BaseException:
            with suppress(OSError):
                part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise unwritten(path, error) from error
    except RuntimeError as error:  # of ffmpeg
        raise OutputError(f"'{path}' could not be written by ffmpeg: {error}; try a .gif") from error

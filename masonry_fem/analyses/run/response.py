"""Response: what the history of a run in dynamics tells of its probes, as tables and for the summary."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.analyses.run.result import RunResult
from masonry_fem.output.history import AXES
from masonry_fem.output.render import can_render
from masonry_fem.output.response import (
    ProbeMotion,
    SpectraTold,
    read_motions,
    response_of,
    write_response,
    write_spectra,
)
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.march.shaking import Shaking
    from masonry_fem.output.spectrum import Spectrum


def responded(
    scene: specs.Scene, out: Path, result: RunResult, *, draws: bool = True
) -> tuple[RunResult, list[Path]]:
    """A result with the response of its probes, and the files of it; statics has none.

    Parameters
    ----------
    scene : What was solved. out : Results folder, with the whole history. result : What its march tells.
    draws : Whether pictures that the scene asks for are drawn.
    """
    if not scene.analysis.inertia or not result.summary.steps:
        return result, []
    motions, spectra = _motions(scene, out, result), {}
    told = {one.name: response_of(one) for one in motions}
    files = []
    if told:
        result = result.telling(response=told)
        files.append(write_response(out / "response.csv", told))
    if (ground := result.built.model.ground) is not None:
        spectra = _spectra(scene, ground, motions)
        result = result.telling(spectra=SpectraTold.of(spectra))
        files.append(write_spectra(out / "spectra.csv", spectra))
    asked = scene.output.pictures
    wanted = asked if isinstance(asked, bool) else "response" in asked
    if told and draws and wanted and can_render():
        from masonry_fem.output.response_picture import draw_response  # noqa: PLC0415 - matplotlib

        path = out / "response.png"
        files.append(draw_response(path, scene.title, motions, list(told.values()), spectra))
    return result, files


def _motions(scene: specs.Scene, out: Path, result: RunResult) -> list[ProbeMotion]:
    """How the probes went, by the history of the run."""
    names = [probe.name for probe in scene.probes]
    if not names:
        return []
    return read_motions(out / "history.csv", names, scene.dimension, result.built.model.ground)


def _spectra(scene: specs.Scene, ground: Shaking, motions: Sequence[ProbeMotion]) -> dict[str, Spectrum]:
    """Of each accelerogram, and of how each probe went in space; steps that are too few tell nothing."""
    from masonry_fem.output import spectrum  # noqa: PLC0415 - scipy.signal, which only these need

    periods, damping, axes = spectrum.periods(), scene.output.spectrum_damping, AXES[scene.dimension]
    names = [
        f"accelerograms.{index}.{axis}"
        for index, one in enumerate(scene.loads.accelerograms)
        for axis in axes
        if getattr(one, axis) is not None
    ]
    found = {
        name: spectrum.of_accelerations(one.record.times, one.record.values, periods, damping)
        for name, one in zip(names, ground.components, strict=True)
    }
    for motion in motions:
        ways = motion.relative + motion.ground
        for number, axis in enumerate(axes):
            one = spectrum.of_displacements(motion.times, ways[:, number], periods, damping)
            if np.isfinite(one.displacements).any():
                found[f"probes.{motion.name}.{axis}"] = one
    return found

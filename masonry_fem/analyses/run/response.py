"""Response: what the history of a run in dynamics tells of its probes, as tables and for the summary."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.analyses.run.result import RunResult
from masonry_fem.output.history import AXES
from masonry_fem.output.response import (
    ProbeMotion,
    read_motions,
    response_of,
    write_response,
    write_spectra,
)
from masonry_fem.results.response import ResponseTold, SpectraTold
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.march.shaking import Shaking
    from masonry_fem.output.spectrum import Spectrum


def responded(scene: specs.Scene, out: Path, result: RunResult) -> tuple[RunResult, list[Path]]:
    """A result with the response of its probes, and the files of it; statics has none.

    Parameters
    ----------
    scene : What was solved. out : Results folder, with the whole history. result : What its march tells.
    """
    if not scene.analysis.inertia or not result.summary.steps:
        return result, []
    ground, files = result.built.model.ground, []
    names = [probe.name for probe in scene.probes]
    motions = read_motions(out / "history.csv", names, scene.dimension, ground) if names else []
    if motions:
        told = [response_of(one) for one in motions]
        result = result.telling(response={one.name: ResponseTold.of(one) for one in told})
        files.append(write_response(out / "response.csv", told))
    if ground is not None:
        spectra = _spectra(scene, ground, motions)
        result = result.telling(spectra=SpectraTold.of(spectra))
        files.append(write_spectra(out / "spectra.csv", spectra))
    return result, files


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

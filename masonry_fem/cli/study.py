"""Command ``study``: run a scene with many settings (cost and error of each) or under many earthquakes."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from masonry_fem.cli.console import EXIT_CODES, INTERRUPTED, complain, print_files
from masonry_fem.cli.grammar import Commands, Parents, overrides_of, share
from masonry_fem.host.phases import LOADING, At, phase

EXAMPLES = (
    ("which mesh is fine enough", "masonry-fem study demos/low_wall.toml --vary mesh.size=0.2,0.1,0.05"),
    (
        "geometry against friction, all combinations",
        "masonry-fem study demos/arch.toml --vary structures.arch.thickness=0.2,0.3 \\\n"
        "      --vary joints.0.friction=0.4,0.6",
    ),
    (
        "how far a column rocks, and when it falls, by how strong the ground shakes",
        "masonry-fem study demos/shaken_column.toml --records demos/shaken_column.csv \\\n"
        "      --scales 0.5:1.5:0.25",
    ),
)


def study_scene(options: argparse.Namespace) -> int:
    """Run a scene with many settings; the exit code says whether any was solved."""
    if options.records:
        return shake_scene(options)
    with phase(LOADING):
        from masonry_fem.analyses.study import study
    from masonry_fem.analyses.study.table import print_study

    with phase("cells") as at:
        made = study(
            options.scene,
            options.vary,
            reference=options.reference,
            quantities=options.quantity,
            peaks=options.peak,
            accuracy=share(options.accuracy, "--accuracy"),
            **_shared(options, "study", at),
        )
    return _concluded(options, made, "study", print_study, "no cell was solved")


def shake_scene(options: argparse.Namespace) -> int:
    """Run a scene under records; the exit code says whether any run could be decided.

    Raises
    ------
    MasonryError : An option of the other kind of study is given.
    """
    with phase(LOADING):
        from masonry_fem.analyses.incremental import incremental
    from masonry_fem.analyses.incremental.outputs import print_incremental
    from masonry_fem.errors import MasonryError

    other = [name for name in ("vary", "reference", "quantity") if getattr(options, name)]
    if other:
        raise MasonryError(f"--records and --{other[0]} are two kinds of study; leave one of them out")
    with phase("cells") as at:
        made = incremental(
            options.scene,
            options.records,
            scales=options.scales or (),
            levels=options.levels or (),
            period=options.period,
            states=options.state,
            demand=options.demand,
            **_shared(options, "incremental", at),
        )
    return _concluded(options, made, "incremental", print_incremental, "no run could be decided")


def _shared(options: argparse.Namespace, kind: str, at: At) -> dict[str, Any]:
    """What both kinds of study are told; ``at`` is told how far it is."""

    def tell(done: int, total: int, last: str) -> None:
        at(done, f"{done}/{total} {last}", total)

    options.out = options.out or Path("results") / f"{options.scene.stem}-{kind}"
    names = ("out", "workers", "time_limit", "fresh")
    return {name: getattr(options, name) for name in names} | {
        "overrides": overrides_of(options),
        "tell": tell,
    }


def _concluded(
    options: argparse.Namespace, made: Any, kind: str, show: Callable[[Any], None], lost: str
) -> int:
    """Write and say what was found; the exit code.

    Parameters
    ----------
    options : What was asked. made : What was found. kind : Name of its files.
    show : Prints it for people. lost : What to complain of where no cell came to an end.
    """
    files = made.write(pictures=not made.interrupted)
    if options.json:
        print((options.out / f"{kind}.json").read_text(encoding="utf-8"), end="")
    elif not options.quiet:
        show(made)
        print_files(files)
    if made.interrupted:
        complain(made.outlook)
        return INTERRUPTED
    if not made.decided:
        complain(f"{lost}; see the messages in {kind}.csv")
        return EXIT_CODES["no_convergence"]
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "study",
        parents=[parents.scene, parents.common],
        help="run a scene with many settings (cost, error) or under many earthquakes (fragility)",
    )
    own.add_argument(
        "--vary", action="append", default=[], metavar="KEY=VALUE,VALUE",
        help="values of a key: mesh.size=0.2,0.1 (may be repeated: all combinations run)",
    )  # fmt: skip
    own.add_argument(
        "--reference", action="append", default=[], metavar="WHAT",
        help="what to compare with: settings of a run, a results folder, a file of numbers, or numbers as "
        "probes.top.z=-1.77e-6 (default: the finest cell)",
    )  # fmt: skip
    own.add_argument(
        "--quantity", action="append", default=[], metavar="NAME",
        help="what to compare: thrust, probes.crown.z, stress.p95 ... (default: everything)",
    )  # fmt: skip
    own.add_argument(
        "--peak", action="append", default=[], metavar="NAME",
        help="record and compare the greatest size over the steps of supports.NAME.x, probes.NAME, time ...",
    )  # fmt: skip
    own.add_argument("--accuracy", default="1%", metavar="A", help="wanted relative error (default: 1%%)")
    own.add_argument(
        "--records", nargs="+", default=[], metavar="FILE",
        help="incremental dynamic analysis in place of settings: accelerograms (.AT2, .csv), or .txt files "
        "that list some",
    )  # fmt: skip
    own.add_argument(
        "--scales", metavar="S,S",
        help="with --records: what each is multiplied by, numbers and ranges first:last:step (0.2:2:0.2)",
    )  # fmt: skip
    own.add_argument(
        "--levels", metavar="A,A", help="in place of --scales: intensities that each is scaled to [m/s²]"
    )
    own.add_argument(
        "--period", type=float, metavar="T",
        help="intensity is the pseudo-acceleration of this period [s] (default: PGA)",
    )  # fmt: skip
    own.add_argument(
        "--state", action="append", default=[], metavar="DEMAND=VALUE",
        help="a limit besides falling: lean=0.1, probes.top.peak=0.05 (rad, m; may be repeated)",
    )  # fmt: skip
    own.add_argument(
        "--demand", default="lean", metavar="NAME", help="what is drawn against intensity (default: lean)"
    )
    own.add_argument(
        "--workers", type=int, metavar="N", help="runs at the same time (default: as cores and memory allow)"
    )
    own.add_argument("--time-limit", type=float, metavar="S", help="CPU seconds that a run may take")
    own.add_argument("--fresh", action="store_true", help="repeat runs whose results are stored")
    own.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE-study)")
    own.add_argument("--json", action="store_true", help="print everything as JSON")
    own.set_defaults(command=study_scene)

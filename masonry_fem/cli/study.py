"""Command ``study``: a scene with many settings, their cost and their error."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import complain, print_files
from masonry_fem.cli.exit_codes import EXIT_CODES, INTERRUPTED
from masonry_fem.cli.grammar import Commands, Parents, overrides_of, share

EXAMPLES = (
    ("which mesh is fine enough", "masonry-fem study demos/low_wall.toml --vary mesh.size=0.2,0.1,0.05"),
    (
        "geometry against friction, all combinations",
        "masonry-fem study demos/arch.toml --vary structures.arch.thickness=0.2,0.3 \\\n"
        "      --vary joints.0.friction=0.4,0.6",
    ),
)


def study_scene(options: argparse.Namespace) -> int:
    """Run a scene with many settings; the exit code says whether any was solved."""
    from masonry_fem.analyses.study import study
    from masonry_fem.analyses.study.table import print_study
    from masonry_fem.analyses.study.watch import Watch

    options.out = options.out or Path("results") / f"{options.scene.stem}-study"
    with Watch() as watch:
        made = study(
            options.scene,
            options.vary,
            out=options.out,
            overrides=overrides_of(options),
            reference=options.reference,
            quantities=options.quantity,
            accuracy=share(options.accuracy, "--accuracy"),
            workers=options.workers,
            time_limit=options.time_limit,
            fresh=options.fresh,
            tell=watch.tell,
        )
    files = made.write(pictures=not made.interrupted)
    if options.json:
        print((options.out / "study.json").read_text(encoding="utf-8"), end="")
    elif not options.quiet:
        print_study(made)
        print_files(files)
    if made.interrupted:
        complain(made.outlook)
        return INTERRUPTED
    if not any(row.solved for row in made.rows):
        complain("no cell was solved; see the messages in study.csv")
        return EXIT_CODES["no_convergence"]
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "study",
        parents=[parents.scene, parents.common],
        help="run a scene with many settings: cost and error of each",
    )
    own.add_argument(
        "--vary", action="append", default=[], metavar="KEY=VALUE,VALUE",
        help="values of a key: mesh.size=0.2,0.1 (may be repeated: all combinations run)",
    )  # fmt: skip
    own.add_argument(
        "--reference", action="append", default=[], metavar="WHAT",
        help="what to compare with: settings of a cell, a results folder, a file of numbers, or numbers as "
        "probes.top.z=-1.77e-6 (default: the finest cell)",
    )  # fmt: skip
    own.add_argument(
        "--quantity", action="append", default=[], metavar="NAME",
        help="what to compare: thrust, probes.crown.z, stress.p95 ... (default: everything)",
    )  # fmt: skip
    own.add_argument("--accuracy", default="1%", metavar="A", help="error that is asked for (1%%)")
    own.add_argument("--workers", type=int, metavar="N", help="cells at a time (as cores and memory allow)")
    own.add_argument("--time-limit", type=float, metavar="S", help="CPU seconds a cell may take")
    own.add_argument("--fresh", action="store_true", help="compute again what is known")
    own.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE-study)")
    own.add_argument("--json", action="store_true", help="print everything as JSON")
    own.set_defaults(command=study_scene)

"""Command ``info``: versions, what this machine lacks, and what scenes can choose."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from collections.abc import Iterable

from masonry_fem.cli.grammar import Commands, Parents

EXAMPLES = (
    ("what is installed, what scenes can choose", "masonry-fem info"),
    ("the JSON schema of summary.json", "masonry-fem info --schema"),
)


def print_info(options: argparse.Namespace) -> int:
    """Print versions, advice on what is missing, and what scenes can choose; or the schema of results."""
    if options.schema:
        from masonry_fem.records.told import Ending, schema, text
        from masonry_fem.results.incremental import IncrementalTold
        from masonry_fem.results.limit_analysis import LimitAnalysis
        from masonry_fem.results.search import CollapseTold, ThresholdTold
        from masonry_fem.results.study import StudyTold
        from masonry_fem.results.summary import Summary

        print(
            text(
                schema(
                    Summary, CollapseTold, ThresholdTold, LimitAnalysis, StudyTold, IncrementalTold, Ending
                )
            )
        )
        return 0
    from masonry_fem.host import installation

    for finding in installation.report():
        cure = f"  -> {finding.cure}" if finding.cure else ""
        print(f"{finding.name:<14}{finding.state}{cure}")
    for noun, names in offered().items():
        print(f"{noun:<14}{', '.join(names)}")
    return 0


def offered() -> dict[str, Iterable[str]]:
    """What scenes may ask for by name, as their folders hold it."""
    from masonry_fem import fidelities, structures
    from masonry_fem.contact import placement
    from masonry_fem.fem import material_kinds
    from masonry_fem.joints.kinds import names as laws
    from masonry_fem.march import equilibrium
    from masonry_fem.nscd import methods
    from masonry_fem.output import asked

    return {
        "structures": structures.names(),
        "fidelities": fidelities.fidelities(),
        "laws": laws(),
        "materials": material_kinds.names(),
        "placements": placement.names(),
        "analyses": equilibrium.names(),
        "solvers": methods.names(),
        "outputs": asked.names(),
    }


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "info", parents=[parents.common], help="versions, what this machine lacks, what scenes can choose"
    )
    own.add_argument("--schema", action="store_true", help="print the JSON schema of summary.json")
    own.set_defaults(command=print_info)

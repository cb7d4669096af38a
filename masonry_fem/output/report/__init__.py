"""Report: one HTML file that presents a run and can be handed on, made of its results folder alone.

    write_report(Path("results/arch"))          # results/arch/report.html

It needs no network and no other file: pictures, plots, styles and scripts are within it.
"""

from masonry_fem.output.report.page import write_report

__all__ = ["write_report"]

"""Report: one HTML file that tells of a run to somebody who was not there, made of its results folder alone.

    write_report(Path("results/arch"))          # results/arch/report.html

It needs no network and no other file: pictures, plots, styles and scripts are within it.
"""

from masonry_fem.output.report.page import write_report

__all__ = ["write_report"]

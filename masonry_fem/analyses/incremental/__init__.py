"""Incremental dynamic analysis: a scene under many records at many scales, and how fragile it is.

    from masonry_fem.analyses.incremental import incremental
    made = incremental("column.toml", ["a.AT2", "b.AT2"], scales="0.2:2:0.2", period=0.5)
    made.told.fragilities[0].median

``records`` reads what shakes, ``shakes`` says what is to be run, ``demand`` runs one of it, ``capacity``
tells from when on limits are passed, ``fragility`` fits a distribution, ``sweep`` does all of it, ``outputs``
writes it.
"""

from masonry_fem.analyses.incremental.sweep import Incremental, incremental

__all__ = ["Incremental", "incremental"]

"""Speed against accuracy, measured: sweeps over settings of a scene.

    from masonry_fem.analyses.study import study
    made = study("arch.toml", {"mesh.size": [0.2, 0.1, 0.05], "fidelity": ["rigid", "elastic"]})

``setting`` knows what keys are to accuracy, ``variation`` and ``plan`` which cells there are, ``quantity``
what is compared, ``reference`` with what, ``order`` and ``comparison`` how far off it is, ``pareto`` and
``recommendation`` what to use, ``table``, ``outputs`` and ``plot`` tell it.
"""

from masonry_fem.analyses.study.sweep import Study, study

__all__ = ["Study", "study"]

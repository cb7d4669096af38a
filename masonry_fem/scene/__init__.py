"""What a user describes: records, TOML in and out, checks.

    from masonry_fem.scene import load, loads, dumps, save, check
    scene = load("arch.toml", overrides=("joints.0.friction=0.4",))

The records themselves are in ``masonry_fem.scene.specs``.
"""

from masonry_fem.scene.reading import check, load, loads, of_records
from masonry_fem.scene.specs import Scene
from masonry_fem.scene.writing import dumps, save

__all__ = ["Scene", "check", "dumps", "load", "loads", "of_records", "save"]

"""Composition root: a Scene becomes a Model; only this folder picks concrete classes."""

from masonry_fem.build.model import Built, build

__all__ = ["Built", "build"]

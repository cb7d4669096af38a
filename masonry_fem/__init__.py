"""masonry_fem: mechanics of block masonry with finite-element stones and true frictional joints."""

__version__ = "0.1.0"

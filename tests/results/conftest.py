"""The structures without finite elements that the tests of outputs have."""

from tests.output.conftest import elastic, rigid

__all__ = ["elastic", "rigid"]

"""The structures without finite elements that the tests of outputs have."""

from tests.output.conftest import dimension, elastic, rigid, state_at

__all__ = ["dimension", "elastic", "rigid", "state_at"]

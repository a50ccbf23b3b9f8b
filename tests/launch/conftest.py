"""Jobs hold for both engines, as the tests of a tile do."""

from tests.sim.conftest import engine

__all__ = ["engine"]

"""A loop over `prange` on all tiles: its chunks, the graph that runs them, `vividc.simulate`."""

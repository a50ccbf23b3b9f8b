"""A loop over `prange` on all tiles.

In order: `chunks`, `spread` (the graph that runs them), `simulate` (`vividc.simulate`).
"""

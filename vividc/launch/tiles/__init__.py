"""A loop over `prange` on all tiles.

In order: `chunks` (iterations and slices of each tile), `spread` (the graph that runs them).
"""

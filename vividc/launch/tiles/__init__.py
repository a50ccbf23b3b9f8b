"""Loops on all tiles.

In order: `chunks` (iterations and slices of each tile) and `spread` (the graph that runs them) of a
loop over `prange`; `blocks` (iterations and windows of each tile) and `nests` (the graph that runs
them) of a sequence of nests.
"""

"""Loops on all tiles.

In order: of a loop over `prange` `shares` (of loops beside it), `chunks` (iterations and slices),
`dealt` (the tile of each) and `spread` (the graph that runs them); of a sequence of nests `blocks`
(ways to cut a nest into iterations and windows of each tile), `placed` (windows in a scratchpad),
`chosen` (which way is fastest) and `nests` (the graph that runs it).
"""

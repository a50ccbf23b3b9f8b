"""Loops on all tiles.

In order: `shares` (of loops beside it), `chunks` (iterations and slices of each tile) and `spread`
(the graph that runs them) of a loop over `prange`; `blocks` (ways to cut a nest into iterations and
windows of each tile), `placed` (windows in a scratchpad), `chosen` (which way is fastest) and
`nests` (the graph that runs it) of a sequence of nests.
"""

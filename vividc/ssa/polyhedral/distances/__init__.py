"""Over how many iterations of a loop two accesses of one array touch one byte.

In order: `linear` (subscripts that move by constants, compared by arithmetic), `maps` (accesses for
isl), `in_rows` (flat indices by row and column), `meetings` (what arithmetic does not tell is asked
of isl).
"""

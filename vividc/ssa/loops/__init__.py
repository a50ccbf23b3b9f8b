"""Transformations of loops before regions are cut.

In order: `unroll`, `partial` (several partial results of a sum), `versions` (with a test before
them), `join` (two as one nest), `left_out` (what the rest takes), `flatten/`, `threads/`. Loops of
affine nests are changed by `ssa.polyhedral`.
"""

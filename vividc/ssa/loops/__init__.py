"""Transformations of loops before regions are cut.

In order: `unroll`, `versions` (with a test before them), `flatten/`, `threads/`. Loops of
affine nests are changed by `ssa.polyhedral`.
"""

"""Transformations of loops before regions are cut.

In order: `unroll`, `flatten/`, `threads/`. Loops of affine nests are changed by `ssa.polyhedral`.
"""

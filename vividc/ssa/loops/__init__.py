"""Transformations of loops before regions are cut.

In order: `unroll`, `nest` and `jam` (unroll-and-jam), `flatten/`, `threads/`.
"""

"""Which bytes iterations of a parallel loop touch, or which elements blocks of a nest do.

In order: `footprint`, `coverage`, `boxes`.
"""

"""Array expressions and assignments to parts of arrays, as loops that one would write by hand.

In order: `numbers` and `views` (which elements of its array a view selects), `origins` (which
arrays are apart), `inplace` (`+=`), `assign` (no array between where none is needed), `loops`,
`stencils` (those of `numba.stencil`).
"""

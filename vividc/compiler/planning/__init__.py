"""Which loop transformations pay: estimates from bounds, the choice, and what was decided.

In order: `options`, `budget`, `estimate`, `candidates`, `restructure` (nests of affine loops),
`choose`, `price` (matrix products), `fallback` (from a plan to the stage that maps), `explain`.
"""

"""Which loop transformations pay: estimates from bounds, the choice, and what was decided.

In order: `options`, `estimate`, `state`, `nests/` (affine nests, and the search for other loops for
them), `candidates`, `plan`, `gains` (what a transformation has to bring), `demands` (what the user
asks for), `fit` (a version for sizes that agree; nests flattened until the contexts suffice),
`interleave` (loops whose iterations may run side by side), `choose`, `spacing` (how far apart rows
lie), `fallback` (from a plan to the stage that maps, and what mapping each may take), `explain`.
"""

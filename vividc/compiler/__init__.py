"""`vividc.compile`: every stage from a kernel to its program.

In order: `planning/` (which loop transformations pay), `regions/` (loops and straight code mapped,
in the time there is), `kept_programs` (what was compiled before), `nests` (a kernel's nests of
loops as programs of their own), `price` (what a term of a matrix product costs a tile), `products`
(which nests are matrix products), `stage` (one of a plan, mapped), `driver`, `jit` (for the types
of a call), `advice/` (what would make a program faster); `passes` (all stages by name).
"""

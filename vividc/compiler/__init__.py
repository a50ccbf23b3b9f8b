"""`vividc.compile`: every stage from a kernel to its program.

In order: `planning/` (which loop transformations pay), `map_regions` (loops, then straight code, in
the time there is), `earlier` (what is kept of graphs from stage to stage), `map_again` (loops
again, for fewer bank stalls and shorter iterations), `shared_variables` (which ones need one place
only), `homes` (where variables live), `delivery` (how they travel between regions), `kept_programs`
(what was compiled before), `nests` (a kernel's nests of loops as programs of their own), `price`
(what a term of a matrix product costs a tile), `products` (which nests are matrix products),
`driver`, `jit` (for the types of a call), `advice/` (what would make a program faster); `passes`
(all stages by name).
"""

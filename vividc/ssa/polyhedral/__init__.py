"""Nests of affine loops: which iterations meet in memory, exactly, and other orders of them.

In order: `values` (words as isl's expressions, domains of blocks, how long isl may take),
`subscripts` (of accesses, recovered from flat indices), `distances` (between iterations whose
accesses touch one byte).
To restructure: `forms` (integers as sums), `scop` (static-control parts are found), `relations`
(dependences), `trees` (of loops), `rows` (of temporaries, for iterations that run together),
`schedule` (order for isl), `orders` (that are worth trying), `loops` (what isl makes of a tree),
`guards` (branches as predicates), `places` (which accesses meet), `writing` (of words and
registers), `generate` (SSA).
"""

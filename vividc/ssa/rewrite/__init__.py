"""Passes on a function in SSA form, each of which keeps every bit.

In order: `blocks` (unreachable ones, chains, trivial phis), `dead` (code), `normalize` (the shape
that regions are cut from), `simplify`, `number_values` (common subexpressions),
`combine_additions`, `tidy` (all of these after a transformation), `contract` (products and sums);
`hoist`, `hoist_loads`, `diamonds` (if-conversion of straight code); what transformations of loops
are made of: `clone`, `repair`, `peel`, `refusal`.
"""

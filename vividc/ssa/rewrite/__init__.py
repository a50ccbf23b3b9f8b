"""Passes on a function in SSA form, each of which keeps every bit.

In order: `normalize` (the shape that regions are cut from), `simplify`, `dead`, `number_values` and
`value_numbering` (common subexpressions), `combine_additions`, `tidy` (all of these after a
transformation), `contract` (products and sums); `hoist`, `hoist_loads`, `diamonds`
(if-conversion of straight code); what transformations of loops are made of: `clone`, `repair`,
`peel`, `refusal`.
"""

"""A kernel as typed SSA in basic blocks: what the frontend hands over, loops transform, and regions
are cut from.

In order: `ir` (functions, blocks, instructions), `text` and `text_parser` (its text form), `check`
(invariants), `edit` (substitution and edits of blocks), `flow` (dominators and loops); `analysis/`
(what is known of values and loops), `rewrite/` (passes on any function), `formats/` (narrow
arithmetic and lanes), `loops/` (transformations of loops), `parallel/` (loops over `prange`,
reductions, matrix products).
"""

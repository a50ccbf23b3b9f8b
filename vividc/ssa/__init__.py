"""A kernel as typed SSA in basic blocks: what is read from LLVM, narrowed to words, transformed
and cut into regions.

In order: `results` (what a kernel returns), `ir` (functions, blocks, instructions), `text` and
`text_parser` (its text form), `check` (invariants), `interpret` and `llvm_semantics` (running it on
arrays), `edit` (substitution and edits of blocks), `flow` (dominators and loops); `analysis/` (what
is known of values and loops), `polyhedral/` (affine nests: exact dependences, other orders),
`rewrite/` (passes on any function), `formats/` (narrow arithmetic and lanes), `loops/`
(transformations of loops), `parallel/` (loops over `prange`, reductions, matrix products).
"""

"""Transformations of loops before regions are cut.

In order: `unroll`, `grouped` (iterations that do not fill a group are masked), `versions` (with a
test before them), `join` (two as one nest), `left_out` (what the rest takes), `begun_sums` (with
what they are added to), `factored_sums` (without a factor of all their products), `taken_in` (with
what is written before them as a first iteration), `forwarded` (what an iteration stores and loads),
`temporaries` (arrays that need not be), `overwritten` (what nobody reads), `fused` (loops that
follow one another), `sizes/` (what those of arrays decide), `flatten/`, `threads/`. Loops of affine
nests are changed by `ssa.polyhedral`.
"""

"""Expansions of operations that no FU implements (docs/math.md).

In order: `builder`, `magnitudes`; `integer`, `bits`, `divide`, `remainder`, `rounding`, `roots`,
`exp`, `log`, `power`, `trigonometric`, `arc`, `hyperbolic`, each with a table of its expansions;
`expand`, the pass.
"""

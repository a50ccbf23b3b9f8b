"""Operations that no FU has become those that it has (docs/math.md).

In order: `builder`, `magnitudes`; `integer`, `bits`, `divide`, `remainder`, `round`, `roots`, `exp`
and `exp_narrow`, `log`, `power`, `trigonometric`, `arc`, `hyperbolic`; `expand`, the pass.
"""

"""Which values integers can have, proved.

In order: `interval`, `trips`, `sizes`, `ranges`; `fold` (what they decide), `launch_sizes` (bounds
as formulas over a launch's inputs).
"""

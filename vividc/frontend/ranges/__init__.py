"""Which values integers can have, proved.

In order: `interval`, `trips`, `ranges`; `sizes` and `known` (what a function's parameters and
tables tell, and its ranges, found once); `fold` and `limits` (what they decide); `formulas`,
`assumed`, `exact` and `launch_sizes` (numbers and bounds as formulas over a launch's inputs).
"""

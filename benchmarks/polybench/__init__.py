"""PolyBench 4.2 in Python on one tile, and on the accelerator: how far whole kernels are from what
the array can do.

`kernels/` (as a user writes them), `inputs` (their initialisation), `suite` (sizes, and what the
study reached by hand), `trace` (operations and dataflow floor of a kernel's own text), `measure` (a
row), `table` (the page, and the progress from step to step).
"""

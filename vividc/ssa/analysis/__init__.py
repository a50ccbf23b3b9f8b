"""What is known of values and loops, without changing a function.

In order: `constants`, `alias`; values as `affine` and `polynomial` forms; loops: `counters`,
`counted`, `constant_trips`, `frequency`; `acyclic` control flow and `levels` of
it; nests and threads: `distinct`, `uniform`.
"""

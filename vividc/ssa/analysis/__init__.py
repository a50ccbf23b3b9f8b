"""What is known of values and loops, without changing a function.

In order: `constants`; loops: their `induction` variables, the `counters` that their headers test;
values as `polynomial` forms, and subscripts with unknown `strides`; the `order` of integers,
proved; trip counts: `counted` (a value of the program), `constant_trips` (a number), `frequency`
(an estimate); `reductions` (scalars that iterations only add to); `acyclic` control flow and
`levels` of it, `conjunctions` of tests under which blocks run; nests and threads: `distinct`,
`uniform`.
"""

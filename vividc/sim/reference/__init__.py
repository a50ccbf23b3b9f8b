"""The reference engine: the rules of the machine, cycle by cycle.

In order: `predecode` (words into tables), `region` (one run of a region), `engine`.
"""

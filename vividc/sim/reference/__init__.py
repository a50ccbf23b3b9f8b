"""The reference engine: the rules of the machine, cycle by cycle.

In order: `predecode` (words into tables), `tile` (what outlives a region), `region` (one run of a
region), `engine`.
"""

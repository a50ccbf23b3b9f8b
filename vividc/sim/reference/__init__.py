"""The reference engine: the rules of the machine, cycle by cycle.

In order: `predecode` (words into tables), `tile` (what outlives a region), `cycle` (what a region
does in one), `region` (one run of a region), `engine`.
"""

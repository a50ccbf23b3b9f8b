"""Other orders of a part's iterations.

In order: `in_memory` (sums wait in memory instead of in scalars), `families` (statements that may
be one), `bands` (which loop of each family is outermost), `realigned` (parts written in another
order), `search` (trees of loops worth trying).
"""

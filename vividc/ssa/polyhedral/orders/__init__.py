"""Other orders of a part's iterations.

In order: `sunk` (inner loops compute what comes before them), `in_memory` (sums wait in memory
instead of in scalars), `families` (statements that may be one), `bands` (which loop of each family
is outermost), `realigned` (parts written in another order), `search` (trees of loops worth trying),
`joined` (those in which two nests are one).
"""

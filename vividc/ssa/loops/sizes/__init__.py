"""What sizes decide: clamps of slices, checks that lengths agree, choices of broadcasting.

In order: `one_name` (of sizes that a branch has shown to be equal), `exact` (which sums of integers
are), `decide` (without what the `order` of integers decides), `by_counters` (what loops count, by
their counters), `versions` (of a kernel: one for sizes that agree, one for others).
"""

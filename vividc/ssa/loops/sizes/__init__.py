"""What sizes decide: clamps of slices, checks that lengths agree, choices of broadcasting.

In order: `decide` (without what the `order` of integers decides), `versions` (of a kernel: one for
sizes that agree, one for others).
"""

"""Exact sets of iterations: words as isl's expressions of a nest's iteration indices, and which
iterations of an access meet which of another.

In order: `values` (expressions, domains of blocks), `subscripts` (of accesses, recovered from flat
indices), `distances` (between iterations whose accesses touch one byte).
"""

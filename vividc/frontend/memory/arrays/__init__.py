"""The arrays that a kernel makes, and which array a pointer is into.

In order: `by_array`, `capacities` (how long lists get), `places` (which array a variable is),
`local_arrays`, `results` (arrays that are returned).
"""

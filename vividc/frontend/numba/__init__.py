"""A Python function through numba's typing to LLVM IR, by a target of our own.

In order: `lines`, `time`; what numba's target does otherwise: `raises`, `integer`, `division`,
`math`, `arrays`, `subscripts`, `prange`, `linalg`, `where`, `sort`; `target`; `returned`; `entry`.
"""

"""A Python function through numba's typing to LLVM IR, by a target of our own.

In order: `lines`, `time`; what numba's target does otherwise: `raises`, `integer`, `division`,
`library/` (functions written once), `arrays`, `assign` and `loops` (array expressions), `lists`,
`subscripts`, `prange`; `target`; `returned`; `entry`.
"""

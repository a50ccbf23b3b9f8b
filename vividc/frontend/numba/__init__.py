"""A Python function through numba's typing to LLVM IR, by a target of our own.

In order: `lines`, `time`; what numba's target does otherwise: `raises/`, `integer`, `division`,
`library/` (functions written once), `subscripts`, `expressions/` (on whole arrays), `arrays`,
`lists/`, `ranges`, `vectorized/` (functions that numba makes); `target`; `returned`; `entry`.
"""

"""Functions of `math` and numpy that stand in for numba's on our target, written once in Python.

In order: `math` (elementary functions), `linalg` (products), `solve` (of systems of equations),
`where`, `triangles` (`triu`, `tril`), `sums` (along an axis), `covariance` (`cov`); `less` (orders
of elements), `order` (`argsort`), `sort`.
"""

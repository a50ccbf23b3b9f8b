"""Functions that numba makes for whole arrays of a user's for numbers or parts.

In order: `written`, `elementwise` (`numba.vectorize`), `generalized` (`numba.guvectorize`),
`functions` (as kernels).
"""

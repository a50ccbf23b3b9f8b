"""What a launch must know of a loop over `prange`, and proofs that it may be spread over tiles.

In order: `independent`, `reductions`, `wide_sums`, `terms` (which bytes iterations touch),
`spread_proof`, `cut` (the loop between two inputs); `products/` (kernels of matrix products).
"""

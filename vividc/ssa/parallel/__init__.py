"""What a launch must know of a loop over `prange`, and proofs that it may be spread over tiles.

In order: `independent`, `wide_sums`, `wide_counters`, `terms` (which bytes iterations touch),
`spread_proof`, `going_on` (behind errors of the simulation), `beside` (loops before and after it
between inputs), `blocks` (loops inside between two inputs), `cut` (the loop between two inputs),
`nests` (a kernel as loops that run one after the other); `products/` (kernels of matrix products).
"""

"""The accelerator as a renderer sees it.

In order: `programs` (kernels compiled when first needed, and kept), `device`, `launches`,
`block_map`, `gather` and `lookups` (kernels over blocks, rows by index, kernels that ask for rows),
`frame` (what each stage cost).
"""

"""The accelerator as a renderer sees it.

In order: `programs` (kernels compiled when first needed, and kept), `device`, `launches`,
`block_map` and `gather` (kernels over blocks, rows by index), `frame` (what each stage cost).
"""

"""The accelerator as a renderer sees it.

In order: `programs` (kernels compiled when first needed, and kept), `device`; `launch` (what a run
takes and leaves), `places` and `launches` (a job of launches, of one or several kernels); `gather`,
`block_map` and `lookups` (rows by index, kernels over blocks, kernels that ask for rows), `frame`
(what each stage cost).
"""

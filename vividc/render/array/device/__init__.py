"""The accelerator as a renderer sees it.

In order: `kernels` and `programs` (which there are, how they are compiled, and that they are kept),
`ahead` (on all cores, before they are needed), `ship` (with a wheel); `launch`
(what a run takes and leaves), `places`, `launches` (a job of launches, of one or several kernels),
`frame` (what each stage cost) and `device`, which is given jobs; `blocks`, `gather` and `lookups`
(kernels over blocks, rows by index, kernels that ask for rows).
"""

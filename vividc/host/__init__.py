"""What the host's machine gives: files, the clock, machine code, the cache.

In order: `lazy` (packages that load what is used), `once` (what is computed once for an object;
objects that are made soon), `time_limit`, `processes/` (helpers and copies, and work that is shared
with them), `watch` (passes as lists, who looks on, and garbage), `progress` (what long work shows);
`store` and `cache` (entries in a folder of the user's own), `compiled_files`; `machine_code/`
(compiled inner loops); `files`, `inputs` and `npz` (how a user's files are read and written);
`html`, `plot/` (pictures as data).
"""

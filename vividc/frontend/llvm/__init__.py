"""What is LLVM's: its passes, its text, and names of calls that pass it.

In order: `calls` and `subscripts` (what is handed through LLVM by name), `passes`; `metadata`,
`tokens`, `layout`, `aggregates` and `reader` (text to data); `child/` (LLVM in a process of its
own).
"""

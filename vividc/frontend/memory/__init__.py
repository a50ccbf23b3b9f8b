"""Pointers become accesses of arrays.

In order: `tables` (constants), `null_choices`, `unmerge`, `pick`, `overlap` (what LLVM made of
choices and copies), `by_array`, `places` (which array a variable is), `pointer_math`, `resolve` (an
array and an index for each access), `flags`, `subword`, `local_arrays`, `traps`, `results` (arrays
that are returned), `user_raises`.
"""

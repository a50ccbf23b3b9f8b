"""Pointers become accesses of arrays.

In order: `tables` (constants), `null_choices`, `unmerge`, `pick`, `overlap` (what LLVM made of
choices and copies), `arrays` (which array a pointer is into, and those that a kernel makes),
`pointer_math`, `resolve` (an array and an index for each access), `flags`, `subword`, `traps`,
`user_raises`.
"""

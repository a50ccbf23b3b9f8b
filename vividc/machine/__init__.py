"""The alphabet that every stage speaks: operations, words, and what a launch must know.

In order: `opcodes` (operations, their types and latency classes), `words` (bits and numbers),
`lanes`, `kinds`, `compare`, `foreign_names`; what operations compute: `semantics` with
`elementary`, `elementary_float`, `lane_semantics` and `division`; what a program says to its
launch: `params`, `parallel`, `product`; `text_line` (tokens of text forms).
"""

"""What a fabric offers to operations and words, and what a graph asks of it.

In order: `arrays` (in which compiled functions read both), `dependences`, `distances`, `mrrg` (the
modulo routing resource graph), `plain_core`; `registers` (allocation), `moved_words` (where words
are moved for it), `fu_slots`; `arms` (of branches, in which accesses are), `waits` (where accesses
meet), `banks`; `taken` (what a region takes of another one's cycles): `drain` (a loop that ends),
`fill` (one that begins).
"""

"""What a fabric offers to operations and words, and what a graph asks of it.

In order: `dependences`, `distances`, `mrrg` (the modulo routing resource graph), `plain_core`;
`registers` (allocation), `fu_slots`, `banks`, `router` (straight code).
"""

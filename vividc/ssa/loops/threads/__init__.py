"""Iterations of a parallel loop side by side in one (docs/threads.md).

In order: `chain` (straight code for several threads), `paths` (when a thread runs a block), `body`,
`loop` (an inner loop of several threads), `make`.
"""

"""Integers of 64 bits in two words: `words`, `shifts`, `divide`, `float`, `phis`, `sums` (against
words), `rules`."""

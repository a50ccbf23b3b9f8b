"""Integers of 64 bits in two words: `words`, `shifts`, `divide`, `float`, `phis`, `rules`."""

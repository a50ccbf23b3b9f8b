"""Which matrix products a kernel computes, whatever the order of its loops.

In order: `effects` (what statements change), `steps` (changes as products), `rows` (flat indices as
subscripts), `checks` (what else a kernel may do), `recognise`.
"""

from vividc.ssa.parallel.products.recognise import Found, recognise

__all__ = ["Found", "recognise"]

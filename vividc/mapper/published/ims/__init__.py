"""Iterative modulo scheduling (Rau 1994) with places and routes on the MRRG: the mapper "ims".

In order: `table` (the modulo reservation table), `words` (their ways), `scheduler`.
"""

from vividc.mapper.published.ims.scheduler import ims

__all__ = ["ims"]

"""Iterative modulo scheduling (Rau 1994) with places and routes on the MRRG: the mapper "ims"."""

from vividc.mapper.published.ims.scheduler import ims

__all__ = ["ims"]

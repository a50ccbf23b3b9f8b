"""What refutes an II, in the words of results and files: those who say it and those who read it."""

from __future__ import annotations

from typing import Final

BY_BOUND: Final = "the lower bound"
BY_CONTEXTS: Final = "the configuration memory"
BY_SCHEDULE: Final = "modulo scheduling without places and routes"
BY_FOLDING: Final = "the cyclic relaxation of time, place and route"
BY_MODEL: Final = "the complete model of time, place and route"
WITHIN_ADDED: Final = " with the added constraints"
"""After `BY_MODEL`."""


def by_bound(lower: int) -> str:
    """An II below the bound."""
    return f"{BY_BOUND} {lower}"


def by_contexts(contexts: int) -> str:
    """An II of more configuration words than there is room for."""
    return f"{BY_CONTEXTS} of {contexts} contexts"

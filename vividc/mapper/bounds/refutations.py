"""What refutes an II, in the words that results and files use, shared by writers and readers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Protocol

BY_BOUND: Final = "the lower bound"
BY_CONTEXTS: Final = "the configuration memory"
BY_SCHEDULE: Final = "modulo scheduling without places and routes"
BY_FOLDING: Final = "the cyclic relaxation of time, place and route"
BY_MODEL: Final = "the complete model of time, place and route"
WITHIN_ADDED: Final = " with the added constraints"
"""After `BY_MODEL`."""

ASSUMED: Final = "assumed: "
"""In the reason of a recurrence through accesses that could not be proved apart."""

KNOWN: Final = "known: "
"""The same through accesses that meet, with the iterations after which they do: as it was proved,
or as a graph that was given says.
"""


IF_THEY_MEET: Final = " if accesses that could not be proved apart meet"
"""After a claim whose bound is such a recurrence."""


class _Bound(Protocol):
    @property
    def ii(self) -> int: ...
    @property
    def reason(self) -> str: ...


def rests_on_assumed(bounds: Iterable[_Bound], lower: int) -> bool:
    """Whether the lower bound rests on recurrences that were only assumed."""
    sharpest = [bound for bound in bounds if bound.ii >= lower > 1]
    return bool(sharpest) and all(ASSUMED in bound.reason for bound in sharpest)


def by_bound(lower: int) -> str:
    """An II below the bound."""
    return f"{BY_BOUND} {lower}"


def by_contexts(contexts: int) -> str:
    """An II of more configuration words than there is room for."""
    return f"{BY_CONTEXTS} of {contexts} contexts"

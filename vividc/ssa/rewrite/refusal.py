"""Why a transformation was not applied."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Refusal:
    """The reason, as part of a sentence: "its trip count is not constant"."""

    reason: str

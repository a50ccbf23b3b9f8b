"""How mapping time is divided among the stages of a plan."""

from __future__ import annotations

from dataclasses import dataclass

from vividc.errors import TimeLimit
from vividc.mapper.deadline import Deadline

_AS_WRITTEN = 0.4
"""The kernel as written is sure of this share, if it has to be mapped: a plan is never worse."""

_STAGE_S = 25.0
"""A stage of transformed loops is given up after so long, and an earlier one mapped instead."""


@dataclass(frozen=True, slots=True)
class Budget:
    """Effort for all stages together, and the part of it that transformed ones may use."""

    whole: Deadline
    transformed: Deadline

    @staticmethod
    def of(whole: Deadline) -> Budget:
        """The budget of mapping that starts now."""
        return Budget(whole, whole.within(whole.remaining_s * (1.0 - _AS_WRITTEN)))

    def share(self, as_written: bool) -> Deadline:
        """When mapping the next stage must end.

        Raises
        ------
        TimeLimit
            What is left is kept for the kernel as written.
        """
        if as_written:
            return self.whole
        if self.transformed.passed:
            raise TimeLimit("no time was left for it", hint="give a longer --time-limit")
        limit_s = min(self.whole.remaining_s / 2, _STAGE_S, self.transformed.remaining_s)
        return self.whole.within(limit_s)

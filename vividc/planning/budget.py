"""How the time for mapping is shared out between the stages of a plan."""

from __future__ import annotations

from dataclasses import dataclass

from vividc import time_limit
from vividc.errors import TimeLimit

_AS_WRITTEN = 0.4
"""The kernel as written is sure of this share, if it has to be mapped: a plan is never worse."""

_STAGE_S = 25.0
"""A stage of transformed loops is given up after so long, and an earlier one mapped instead."""


@dataclass(frozen=True, slots=True)
class Budget:
    """When time for all stages is up, and when that for transformed ones is, by `time_limit`."""

    whole: float
    transformed: float

    @staticmethod
    def of(time_limit_s: float) -> Budget:
        """The budget of mapping that starts now."""
        now = time_limit.now()
        return Budget(now + time_limit_s, now + time_limit_s * (1.0 - _AS_WRITTEN))

    def share_s(self, as_written: bool) -> float:
        """Seconds for mapping the next stage.

        Raises
        ------
        TimeLimit
            What is left is kept for the kernel as written.
        """
        now = time_limit.now()
        if as_written:
            return max(self.whole - now, 0.0)
        if now >= self.transformed:
            raise TimeLimit("no time was left for it", hint="give a longer --time-limit")
        return min((self.whole - now) / 2, _STAGE_S, self.transformed - now)

"""Place and route by annealing and negotiation: for graphs too large to be solved in time."""

from vividc.mapper.engines.negotiate.negotiate import Effort, negotiate, prepare

__all__ = ["Effort", "negotiate", "prepare"]

"""Place and route by annealing and negotiation, for graphs too large to be solved in time.

In order: `compiled` (where machine code is met), `arrays` (the problem), `places`, `words`,
`motion`, `anneal`; `traffic`, `ways`, `repair` (with routes); `lockstep`, `negotiate`.
"""

from vividc.mapper.engines.negotiate.negotiate import Effort, negotiate, prepare

__all__ = ["Effort", "negotiate", "prepare"]

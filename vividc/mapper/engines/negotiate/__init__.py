"""Place and route by annealing and negotiation: large graphs, and small ones at their bound.

In order: `compiled` (where machine code is met), `frame` (between which cycles), `arrays` (the
problem), `places`, `words`, `motion`, `anneal`; `traffic`, `ways`, `repair` (with routes);
`lockstep`, `tuning`, `negotiate`.
"""

from vividc.mapper.engines.negotiate.compiled import prepare
from vividc.mapper.engines.negotiate.frame import least_span, loose_frame, tight_frame
from vividc.mapper.engines.negotiate.negotiate import annealing_s, negotiate
from vividc.mapper.engines.negotiate.tuning import Effort

__all__ = [
    "Effort",
    "annealing_s",
    "least_span",
    "loose_frame",
    "negotiate",
    "prepare",
    "tight_frame",
]

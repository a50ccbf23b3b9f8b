"""Place and route by annealing and negotiation: large graphs, and small ones at their bound.

In order: `compiled` (where machine code is met), `frame` (between which cycles), `arrays` (the
problem), `places`, `words`, `motion`, `anneal`; `traffic`, `ways`, `repair` (with routes);
`lockstep`, `tuning`; `negotiation` (one attempt), `negotiate` (some side by side).
"""

from vividc.mapper.engines.negotiate.compiled import prepare
from vividc.mapper.engines.negotiate.frame import Frame, least_span, loose_frame, tight_frame
from vividc.mapper.engines.negotiate.negotiate import (
    Negotiated,
    Try,
    annealing_s,
    negotiate,
    negotiate_each,
)
from vividc.mapper.engines.negotiate.tuning import Effort

__all__ = [
    "Effort",
    "Frame",
    "Negotiated",
    "Try",
    "annealing_s",
    "least_span",
    "loose_frame",
    "negotiate",
    "negotiate_each",
    "prepare",
    "tight_frame",
]

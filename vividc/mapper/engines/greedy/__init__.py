"""One greedy pass over a straight region: nodes are placed and routed one after the other.

In order: `compiled` (where machine code is met), `task` (region and array), `board` (what is
decided, and how it is taken back), `words`, `search`, `placing` (of a node), `order` (of all),
`schedule`.
"""

from vividc.mapper.engines.greedy.compiled import prepare
from vividc.mapper.engines.greedy.schedule import Policy, Region, Schedule

__all__ = ["Policy", "Region", "Schedule", "prepare"]

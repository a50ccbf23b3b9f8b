"""When each step of a job happens: an event simulation of docs/accelerator.md.

What a job computes is known before; here only cycles are counted.

In order: `compiled` (where machine code is met), `state` and `pack` (a job as flat arrays),
`queues`, `clock`, `bursts`, `transfers`, `flow`, `simulation`; `record` (what ran when),
`schedule`.
"""

from vividc.launch.timing.schedule import Moved, TileClock, Timing, schedule

__all__ = ["Moved", "TileClock", "Timing", "schedule"]

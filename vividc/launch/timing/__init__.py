"""When each step of a job happens: an event simulation of docs/accelerator.md.

What a job computes is known before; here only cycles are counted.
"""

from vividc.launch.timing.schedule import Moved, TileClock, Timing, schedule

__all__ = ["Moved", "TileClock", "Timing", "schedule"]

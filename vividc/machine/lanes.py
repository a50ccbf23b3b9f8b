"""Which thread of a tile an operation belongs to, and which operations of other threads are its
twins.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Lane:
    """A thread's copy of an operation, after `transform.threads`.

    Copies of one operation in several threads have equal `origin` and `part`: they do the same on
    words of their own, and nothing of one depends on the others in the same iteration. What all
    threads share (an address, a load that is the same for all) has no lane.

    Attributes
    ----------
    thread
        Number of the thread in its group, from 0 on.
    origin
        Id of the instruction or phi that was copied; negative for what decides where a thread goes.
    part
        Which of the operations that stand for the origin, as of a phi or an elementary function.
    regions
        Headers of the loops whose run lies within one run of the parallel loop: there accesses of
        different threads are accesses of different iterations of it, which are independent.
    """

    thread: int
    origin: int
    part: int = 0
    regions: tuple[str, ...] = ()

    def independent_of(self, other: Lane | None, region: str) -> bool:
        """Whether accesses of the lanes in the loop `region` are of different iterations of the
        parallel loop.
        """
        if other is None or self.thread == other.thread:
            return False
        return region in self.regions and self.regions == other.regions

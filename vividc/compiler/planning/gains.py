"""What a transformation has to bring, and how large it may make a loop."""

from __future__ import annotations

from typing import Final

from vividc.compiler.planning.candidates import Kind
from vividc.compiler.planning.estimate import Estimate
from vividc.compiler.planning.plan import Stage

OPERATIONS_PER_PE: Final[dict[Kind, int]] = {
    "full unrolling": 24,
    "unrolling": 12,
    "masked unrolling": 12,
    "flattening": 24,
    "threads": 24,
    "interleaving": 24,
    "restructuring": 8,
    "versioning": 24,
    "partial results": 12,
}
"""A loop's graph may not have more. What lies side by side is mapped soon (367 operations of 8
modular inverses at their bound in 4 s), and code that is unrolled fully has no other form as good
(302 operations of morton64 in 2 s). Of the others several sizes are tried: smaller ones come near.
"""

GAIN_WITHOUT_LOOP: Final = 0.8
"""The same where full unrolling leaves no loop around, for code that runs once."""

GAIN: Final[dict[Kind, float]] = {
    "full unrolling": 0.97,
    "unrolling": 0.9,
    "masked unrolling": 0.98,
    "flattening": 0.95,
    "threads": 0.9,
    "interleaving": 0.9,
    "restructuring": 0.9,
    "versioning": 0.9,
    "partial results": 0.985,
}
"""A transformation must bring the cycles below this share: its overheads vary more with the sizes
than full unrolling's, which are known.
"""

LARGE, GAIN_OF_LARGE = 256, 0.9
"""The same with a loop of so many operations (339 of bilateral, at 0.949, map nothing in 19 s)."""

LITTLE: Final = 0.045
"""A nest that saves a smaller share of the kernel's cycles is left alone, whatever it gains of its
own (`GAIN`): other nests are not restructured yet, and may lose most of theirs. At 0.02 the sums
of deriche, which save 0.04, take the constant stores that its other loops need.
"""


def pays_inside(base: Stage, header: str, estimate: Estimate) -> bool:
    """Whether a restructured nest gains of its own cycles what a kernel has to gain."""
    saved = base.estimate.cycles - estimate.cycles
    least = (1.0 - GAIN["restructuring"]) * base.cycles_in(header)
    return saved >= max(least, LITTLE * base.estimate.cycles)

"""Which blocks of pixels are simulated when not all are."""

from __future__ import annotations

import numpy as np

from vividc.render.arrays import Int32Array

_GOLDEN = 0.6180339887498949


def sampled(corners: Int32Array, share: float) -> Int32Array:
    """Return about a share of the blocks, spread evenly: the same ones each time.

    Block k counts if the fractional part of k times the golden ratio's is below the share (Weyl
    1916); at least one does.
    """
    place = np.arange(len(corners)) * _GOLDEN % 1.0
    chosen = corners[place < share]
    return chosen if len(chosen) else corners[:1]

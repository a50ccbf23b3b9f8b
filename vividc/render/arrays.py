"""Array types the renderers share, and the rule that arrays inside frozen records are read-only."""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

Float32Array: TypeAlias = npt.NDArray[np.float32]
Int32Array: TypeAlias = npt.NDArray[np.int32]
Int64Array: TypeAlias = npt.NDArray[np.int64]
UInt8Array: TypeAlias = npt.NDArray[np.uint8]

LARGEST_FLOAT32: Final = float(np.finfo(np.float32).max)


def frozen_float32(values: npt.ArrayLike) -> Float32Array:
    """Return a contiguous, read-only float32 copy of `values`."""
    array = np.array(values, dtype=np.float32, order="C")
    array.flags.writeable = False
    return array

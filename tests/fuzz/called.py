"""Kernels that random kernels call: in a module of their own they are compiled once a search."""

from __future__ import annotations

import numpy as np

from vividc.frontend import kernel


@kernel("int32(int32, int32)")
def mix(v, w):  # type: ignore[no-untyped-def]
    if v > w:
        return np.int32(v - w)
    return np.int32((v ^ w) + 1)


@kernel("UniTuple(int32, 2)(int32, int32)")
def pair(v, w):  # type: ignore[no-untyped-def]
    return np.int32(w + 1), np.int32(v ^ w)


@kernel("float32(float32, float32)")
def blend(v, w):  # type: ignore[no-untyped-def]
    k = v
    for _ in range(2):
        if k > w:
            break
        k = k + w
    return k

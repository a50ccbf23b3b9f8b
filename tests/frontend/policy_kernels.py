"""The same kernels without casts, for the policy, and with them."""

import numpy as np
from numba import prange

import vividc
from vividc import lang

CASTS = {"fp16": lang.fp16, "fp8": lang.fp8, "e5m2": lang.e5m2}


@vividc.kernel("void(float32[::1], float32[::1], int32)")
def chain(x, y, m):
    for i in prange(len(x)):
        total = x[i]
        for _ in range(m):
            if total < np.float32(1.0):
                total = lang.fma(total, np.float32(0.75), x[i])
            else:
                total = total - np.float32(0.5)
        y[i] = total * x[i]


def chain_in(name):
    """`chain` with the casts that the policy stands for."""
    cast = CASTS[name]

    @vividc.kernel("void(float32[::1], float32[::1], int32)", name=f"chain_{name}")
    def kernel(x, y, m):
        for i in prange(len(x)):
            total = x[i]
            for _ in range(m):
                if total < np.float32(1.0):
                    here = lang.fma(cast(total), cast(0.75), cast(x[i]))
                else:
                    here = cast(total) - cast(0.5)
                total = np.float32(here)
            y[i] = np.float32(cast(total) * cast(x[i]))

    return kernel


@vividc.kernel("float32(float32[::1], float32[::1])")
def inner(x, y):
    total = np.float32(0.0)
    for i in range(len(x)):
        total = lang.fma(x[i], y[i], total)
    return total


def inner_in(name):
    """`inner` with the casts that the policy stands for."""
    cast = CASTS[name]

    @vividc.kernel("float32(float32[::1], float32[::1])", name=f"inner_{name}")
    def kernel(x, y):
        total = cast(0.0)
        for i in range(len(x)):
            total = lang.fma(cast(x[i]), cast(y[i]), total)
        return float(total)

    return kernel

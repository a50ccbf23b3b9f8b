"""Finite impulse response filter over an integer signal."""

import numpy as np

import vividc


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def fir(signal, taps, out):
    for i in range(len(out)):
        total = np.int32(0)
        for k in range(len(taps)):
            total = np.int32(total + taps[k] * signal[i + k])
        out[i] = total

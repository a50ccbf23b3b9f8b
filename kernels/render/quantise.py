"""Numbers of 16 and 8 bits for networks: neighbouring features become the lanes of a word, lane 0
in the lowest bits.

Networks have blocks of 16 samples, [block, feature, sample].
"""

import numpy as np
from numba import njit

import vividc
from vividc import lang


@njit
def fp16_word(a, b):
    """Two numbers as the lanes of a word."""
    low = np.uint32(lang.bits_of(lang.fp16(a)))
    return low | (np.uint32(lang.bits_of(lang.fp16(b))) << np.uint32(16))


@njit
def fp8_word(a, b, c, d):
    """Four numbers as the lanes of a word."""
    low = np.uint32(lang.bits_of(lang.fp8(a)))
    low |= np.uint32(lang.bits_of(lang.fp8(b))) << np.uint32(8)
    low |= np.uint32(lang.bits_of(lang.fp8(c))) << np.uint32(16)
    return low | (np.uint32(lang.bits_of(lang.fp8(d))) << np.uint32(24))


@vividc.kernel("void(float32[:, :, ::1], float32, uint32[:, :, ::1])")
def to_fp16(x, scale, out):
    """Words of two features, times `scale`."""
    for block in range(out.shape[0]):
        for word in range(out.shape[1]):
            for sample in range(16):
                first = x[block, 2 * word, sample] * scale
                second = x[block, 2 * word + 1, sample] * scale
                out[block, word, sample] = fp16_word(first, second)


@vividc.kernel("void(float32[:, :, ::1], float32, uint32[:, :, ::1])")
def to_fp8(x, scale, out):
    """Words of four features, times `scale`."""
    for block in range(out.shape[0]):
        for word in range(out.shape[1]):
            for sample in range(16):
                first = x[block, 4 * word, sample] * scale
                second = x[block, 4 * word + 1, sample] * scale
                third = x[block, 4 * word + 2, sample] * scale
                fourth = x[block, 4 * word + 3, sample] * scale
                out[block, word, sample] = fp8_word(first, second, third, fourth)

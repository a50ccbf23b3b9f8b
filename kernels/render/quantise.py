"""Numbers of 16 and 8 bits for networks: neighbouring features become the lanes of a word, lane 0
in the lowest bits.

Networks have blocks of 16 samples, [block, feature, sample].
"""

import vividc
from vividc import lang


@vividc.kernel("void(float32[:, :, ::1], float32, uint32[:, :, ::1])")
def to_fp16(x, scale, out):
    """Words of two features, times `scale`."""
    for block in range(out.shape[0]):
        for word in range(out.shape[1]):
            for sample in range(16):
                first = x[block, 2 * word, sample] * scale
                second = x[block, 2 * word + 1, sample] * scale
                out[block, word, sample] = lang.pack_fp16(first, second)


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
                out[block, word, sample] = lang.pack_fp8(first, second, third, fourth)

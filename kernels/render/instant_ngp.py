"""What stands between the networks of Instant-NGP (Mueller et al. 2022): directions, and the inputs
of the second network, from the first one's outputs.

Networks have blocks of 16 samples, [block, feature, sample].
"""

import numpy as np
from numba import njit

import vividc
from vividc import lang

ONE = np.float32(1.0)
HIGH = np.int32(16)
RAYS = np.uint32(63)
PLACE = np.uint32(22)
UPPER = np.uint32(0x3C000000)
"""0 and 1 as float16: the products with a word of finite numbers add up to the upper one."""

# Degree 4 (16 values) in the order and signs of tiny-cuda-nn.
Y0 = np.float32(0.28209479177387814)
Y1 = np.float32(0.48860251190291987)
Y2_XY = np.float32(1.0925484305920792)
Y2_ZZ = np.float32(0.94617469575755997)
Y2_Z0 = np.float32(0.31539156525251999)
Y2_XX = np.float32(0.54627421529603959)
Y3_XXY = np.float32(0.59004358992664352)
Y3_XYZ = np.float32(2.8906114426405538)
Y3_YZZ = np.float32(0.45704579946446572)
Y3_ZZZ = np.float32(0.3731763325901154)
Y3_XXZ = np.float32(1.4453057213202769)
THREE = np.float32(3.0)
FIVE = np.float32(5.0)


@njit
def word(a, b, c, d, scale):
    """Four numbers, times `scale`, as float8."""
    return lang.pack_fp8(a * scale, b * scale, c * scale, d * scale)


@njit
def halves(word):
    """Two float16 in a word."""
    return np.float32(lang.fp16_from_bits(word)), lang.dot_fp16(word, UPPER, np.float32(0))


@njit
def harmonics(directions, block, sample):
    """The 16 spherical harmonics of a sample's direction."""
    x = directions[block, sample, 0]
    y = directions[block, sample, 1]
    z = directions[block, sample, 2]
    xy = x * y
    xx = x * x
    yy = y * y
    zz = z * z
    return (
        Y0,
        -Y1 * y,
        Y1 * z,
        -Y1 * x,
        Y2_XY * xy,
        -Y2_XY * (y * z),
        Y2_ZZ * zz - Y2_Z0,
        -Y2_XY * (x * z),
        Y2_XX * (xx - yy),
        Y3_XXY * y * (yy - THREE * xx),
        Y3_XYZ * xy * z,
        Y3_YZZ * y * (ONE - FIVE * zz),
        Y3_ZZZ * z * (FIVE * zz - THREE),
        Y3_YZZ * x * (ONE - FIVE * zz),
        Y3_XXZ * z * (xx - yy),
        Y3_XXY * x * (THREE * yy - xx),
    )


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1])")
def directions(directions, out):
    """16 spherical harmonics of unit directions, [block, 16, 16]."""
    for block in range(out.shape[0]):
        for ray in range(16):
            t = harmonics(directions, block, ray)
            out[block, ray, 0] = t[0]
            out[block, ray, 1] = t[1]
            out[block, ray, 2] = t[2]
            out[block, ray, 3] = t[3]
            out[block, ray, 4] = t[4]
            out[block, ray, 5] = t[5]
            out[block, ray, 6] = t[6]
            out[block, ray, 7] = t[7]
            out[block, ray, 8] = t[8]
            out[block, ray, 9] = t[9]
            out[block, ray, 10] = t[10]
            out[block, ray, 11] = t[11]
            out[block, ray, 12] = t[12]
            out[block, ray, 13] = t[13]
            out[block, ray, 14] = t[14]
            out[block, ray, 15] = t[15]


@vividc.kernel("void(float32[:, :, ::1], float32, uint32[:, :, ::1])")
def directions_fp8(directions, scale, out):
    """As `directions`, times `scale`, four to a word, [block, 16, 4]."""
    for block in range(out.shape[0]):
        for ray in range(16):
            t = harmonics(directions, block, ray)
            out[block, ray, 0] = word(t[0], t[1], t[2], t[3], scale)
            out[block, ray, 1] = word(t[4], t[5], t[6], t[7], scale)
            out[block, ray, 2] = word(t[8], t[9], t[10], t[11], scale)
            out[block, ray, 3] = word(t[12], t[13], t[14], t[15], scale)


@njit
def ray_of(items, sample):
    """The ray of a sample, or of the last one, among the piece's."""
    return np.uint32(items[min(np.int32(sample), np.int32(len(items) - 1))] >> HIGH) & RAYS


@njit
def place_of(items, sample, first):
    """Where among the blocks a sample, or the last one, is."""
    item = items[min(np.int32(sample), np.int32(len(items) - 1))]
    return np.uint32((np.uint32(item) >> PLACE) + np.uint32(first))


@vividc.kernel("void(float32[:, :, ::1], float32[:, ::1], int32[::1], int32, float32[:, :, ::1])")
def colour_inputs(outputs, of_rays, items, first, out):
    """The network's inputs of those samples of a piece that survive: the terms of their ray's
    direction, then the first network's outputs. The last sample fills the last block up.

    Parameters
    ----------
    outputs
        [block, output, sample]: all blocks with samples that survive.
    of_rays
        [64, 16] of its rays.
    items
        As in marching.py.
    first
        Where the piece begins, counted from the first block's first sample; it may be before it.
    """
    for sample in range(16 * out.shape[0]):
        ray = ray_of(items, sample)
        for k in range(16):
            out[sample >> 4, k, sample & 15] = of_rays[ray, k]
    for sample in range(16 * out.shape[0]):
        for k in range(out.shape[1] - 16):
            place = place_of(items, sample, first)
            block, lane = place >> np.uint32(4), place & np.uint32(15)
            out[sample >> 4, 16 + k, sample & 15] = outputs[block, k, lane]


@vividc.kernel(
    "void(uint32[:, :, ::1], uint32[:, ::1], int32[::1], int32, float32, uint32[:, :, ::1])"
)
def colour_inputs_fp8(outputs, of_rays, items, first, scale, out):
    """As `colour_inputs`: four words of directions, `of_rays` [64, 4]; `outputs` are words of two
    float16, a multiple of four of a sample, which times `scale` become float8.
    """
    for sample in range(16 * out.shape[0]):
        ray = ray_of(items, sample)
        out[sample >> 4, 0, sample & 15] = of_rays[ray, 0]
        out[sample >> 4, 1, sample & 15] = of_rays[ray, 1]
        out[sample >> 4, 2, sample & 15] = of_rays[ray, 2]
        out[sample >> 4, 3, sample & 15] = of_rays[ray, 3]
    for sample in range(16 * out.shape[0]):
        for k in range(out.shape[1] - 4):
            place = place_of(items, sample, first)
            block, lane = place >> np.uint32(4), place & np.uint32(15)
            a, b = halves(outputs[block, 2 * k, lane])
            c, d = halves(outputs[block, 2 * k + 1, lane])
            out[sample >> 4, 4 + k, sample & 15] = word(a, b, c, d, scale)

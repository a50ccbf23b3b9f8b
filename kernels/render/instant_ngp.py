"""What stands between the networks of Instant-NGP (Mueller et al. 2022): the density from the first
network's outputs, the inputs of the second, the colour.

Networks have blocks of 16 samples, [block, feature, sample]; else they lie by block, sample and
feature.
"""

import math

import numpy as np
from numba import njit

import vividc
from vividc import lang

ONE = np.float32(1.0)
LARGEST = np.float32(80.0)
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


@vividc.kernel("void(float32[:, :, ::1], float32, float32, float32[:, ::1], float32[:, :, ::1])")
def density(x, limit, step, thickness, features):
    """Optical thickness of a step, exp of the first output, clamped; and all outputs by sample."""
    for block in range(x.shape[0]):
        for sample in range(16):
            for feature in range(features.shape[2]):
                features[block, sample, feature] = x[block, feature, sample]
    for block in range(x.shape[0]):
        for sample in range(16):
            thickness[block, sample] = math.exp(min(x[block, 0, sample], limit)) * step


@njit
def word(a, b, c, d, scale):
    """Four numbers, times `scale`, as float8."""
    return lang.pack_fp8(a * scale, b * scale, c * scale, d * scale)


@njit
def halves(word):
    """Two float16 in a word."""
    return np.float32(lang.fp16_from_bits(word)), lang.dot_fp16(word, UPPER, np.float32(0))


@vividc.kernel("void(uint32[:, ::1], float32, float32, float32[:, ::1])")
def density_fp8(x, limit, step, thickness):
    """Optical thickness of a step as `density`, of words of float16: the first output is the lower
    one.
    """
    for block in range(x.shape[0]):
        for sample in range(16):
            first = np.float32(lang.fp16_from_bits(x[block, sample]))
            thickness[block, sample] = math.exp(min(first, limit)) * step


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


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1], float32[:, :, ::1])")
def colour_inputs(features, directions, out):
    """16 spherical harmonics of the unit directions, then the features."""
    for block in range(out.shape[0]):
        for sample in range(16):
            terms = harmonics(directions, block, sample)
            out[block, 0, sample] = terms[0]
            out[block, 1, sample] = terms[1]
            out[block, 2, sample] = terms[2]
            out[block, 3, sample] = terms[3]
            out[block, 4, sample] = terms[4]
            out[block, 5, sample] = terms[5]
            out[block, 6, sample] = terms[6]
            out[block, 7, sample] = terms[7]
            out[block, 8, sample] = terms[8]
            out[block, 9, sample] = terms[9]
            out[block, 10, sample] = terms[10]
            out[block, 11, sample] = terms[11]
            out[block, 12, sample] = terms[12]
            out[block, 13, sample] = terms[13]
            out[block, 14, sample] = terms[14]
            out[block, 15, sample] = terms[15]
    for block in range(out.shape[0]):
        for sample in range(16):
            for feature in range(features.shape[2]):
                out[block, feature + 16, sample] = features[block, sample, feature]


@vividc.kernel("void(float32[:, :, ::1], float32, uint32[:, :, ::1])")
def directions_fp8(directions, scale, out):
    """16 spherical harmonics of unit directions, times `scale`, four to a word, [block, 16, 4]."""
    for block in range(out.shape[0]):
        for ray in range(16):
            t = harmonics(directions, block, ray)
            out[block, ray, 0] = word(t[0], t[1], t[2], t[3], scale)
            out[block, ray, 1] = word(t[4], t[5], t[6], t[7], scale)
            out[block, ray, 2] = word(t[8], t[9], t[10], t[11], scale)
            out[block, ray, 3] = word(t[12], t[13], t[14], t[15], scale)


@vividc.kernel(
    "void(uint32[:, :, ::1], uint32[:, ::1], int32[::1], int32, float32, uint32[:, :, ::1])"
)
def colour_inputs_fp8(outputs, of_rays, items, first, scale, out):
    """The network's inputs of those samples of a piece that survive: four words of their ray's
    direction, then the first network's outputs. The last sample fills the last block up.

    Parameters
    ----------
    outputs
        [block, word, sample] of two float16, a multiple of four of a sample: all blocks with
        samples of the piece. Times `scale` they become float8.
    of_rays
        [64, 4] of its rays.
    items
        As in marching.py.
    first
        The first block's sample that is the piece's first.
    """
    last = np.int32(len(items) - 1)
    for sample in range(16 * out.shape[0]):
        ray = np.uint32(items[min(np.int32(sample), last)] >> HIGH) & RAYS
        out[sample >> 4, 0, sample & 15] = of_rays[ray, 0]
        out[sample >> 4, 1, sample & 15] = of_rays[ray, 1]
        out[sample >> 4, 2, sample & 15] = of_rays[ray, 2]
        out[sample >> 4, 3, sample & 15] = of_rays[ray, 3]
    for sample in range(16 * out.shape[0]):
        for k in range(out.shape[1] - 4):
            place = (np.uint32(items[min(np.int32(sample), last)]) >> PLACE) + np.uint32(first)
            block, lane = place >> np.uint32(4), place & np.uint32(15)
            a, b = halves(outputs[block, 2 * k, lane])
            c, d = halves(outputs[block, 2 * k + 1, lane])
            out[sample >> 4, 4 + k, sample & 15] = word(a, b, c, d, scale)


@njit
def sigmoid(x):
    return ONE / (ONE + math.exp(min(max(-x, -LARGEST), LARGEST)))


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1])")
def colour(x, out):
    """Sigmoids of the first three outputs."""
    for block in range(x.shape[0]):
        for sample in range(16):
            for channel in range(3):
                out[block, sample, channel] = sigmoid(x[block, channel, sample])


@vividc.kernel("void(uint32[:, :, ::1], float32[:, :, ::1])")
def colour_fp8(x, out):
    """As `colour`, of words of two float16."""
    for block in range(x.shape[0]):
        for sample in range(16):
            red, green = halves(x[block, 0, sample])
            out[block, sample, 0] = sigmoid(red)
            out[block, sample, 1] = sigmoid(green)
            blue = np.float32(lang.fp16_from_bits(x[block, 1, sample]))
            out[block, sample, 2] = sigmoid(blue)

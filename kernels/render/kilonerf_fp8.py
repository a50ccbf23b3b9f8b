"""KiloNeRF's networks (Reiser et al. 2021) with operands of float8 (E4M3) and sums of float32.

A word holds four inputs of a sample or four weights of a neuron, and one operation adds their four
products. A chunk of inputs is eight words of each sample, sample after sample; a layer has one or
two. It takes those of eight neurons' weights at a time, which stay where they are used while all
samples come by. `weights` has the words of each neuron, and after those of eight neurons (of the
last layer: of one) their biases.
"""

import math

import numba
import numpy as np
from numba import prange

import vividc
from vividc.lang import bitcast_f32, dot_fp8, max_fp8, pack_fp8

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
S3, S5, S7, S9 = (np.float32(x) for x in (-1 / 6, 1 / 120, -1 / 5040, 1 / 362880))
C2, C4, C6 = (np.float32(x) for x in (-1 / 2, 1 / 24, -1 / 720))
C8, C10 = (np.float32(x) for x in (1 / 40320, -1 / 3628800))
LARGEST = np.float32(80.0)
CHUNK = 8
EIGHT_OF_BOTH = 8 * (2 * CHUNK + 1)
EIGHT_NEURONS = 8 * (CHUNK + 1)
NEURON = CHUNK + 1
SECOND = 4 * EIGHT_OF_BOTH
THIRD = SECOND + 4 * EIGHT_NEURONS
LAST = THIRD + 4 * EIGHT_NEURONS
LOWEST = np.uint32(0xFEFEFEFE)
"""-448 four times."""


@numba.njit
def sine_and_cosine(x):
    """Of -1 to 1, by Taylor's polynomials of degrees 9 and 10: wrong by less than 2^-23."""
    y = x * x
    sine = S9 * y + S7
    sine = sine * y + S5
    sine = sine * y + S3
    cosine = C10 * y + C8
    cosine = cosine * y + C6
    cosine = cosine * y + C4
    cosine = cosine * y + C2
    return sine * y * x + x, cosine * y + ONE


@numba.njit
def doubled(sine, cosine):
    """Sine and cosine of twice the angle."""
    twice = sine + sine
    return twice * cosine, ONE - twice * sine


@numba.njit
def four_octaves(x):
    """Two words of the sines and cosines of x, 2x, 4x and 8x, and those of 8x."""
    s0, c0 = sine_and_cosine(x)
    s1, c1 = doubled(s0, c0)
    s2, c2 = doubled(s1, c1)
    s3, c3 = doubled(s2, c2)
    return pack_fp8(s0, c0, s1, c1), pack_fp8(s2, c2, s3, c3), s3, c3


@numba.njit
def ten_octaves(x):
    """Five words of the sines and cosines of x, 2x, ... 512x."""
    w0, w1, s3, c3 = four_octaves(x)
    s4, c4 = doubled(s3, c3)
    s5, c5 = doubled(s4, c4)
    s6, c6 = doubled(s5, c5)
    s7, c7 = doubled(s6, c6)
    s8, c8 = doubled(s7, c7)
    s9, c9 = doubled(s8, c8)
    return w0, w1, pack_fp8(s4, c4, s5, c5), pack_fp8(s6, c6, s7, c7), pack_fp8(s8, c8, s9, c9)


@numba.njit
def encode_position(points, low, high):
    """Two chunks of the terms of Mildenhall et al. (2020) of places within -1 to 1: five words of
    each coordinate, and x, y and z. Doubling adds errors below 2^-10 to that of rounding to float8.
    """
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        p = np.uint32(CHUNK * i)
        a, b, c, d, e = ten_octaves(x)
        low[p], low[p + np.uint32(1)], low[p + np.uint32(2)] = a, b, c
        low[p + np.uint32(3)], low[p + np.uint32(4)] = d, e
        a, b, c, d, e = ten_octaves(y)
        low[p + np.uint32(5)], low[p + np.uint32(6)], low[p + np.uint32(7)] = a, b, c
        high[p], high[p + np.uint32(1)] = d, e
        a, b, c, d, e = ten_octaves(z)
        high[p + np.uint32(2)], high[p + np.uint32(3)], high[p + np.uint32(4)] = a, b, c
        high[p + np.uint32(5)], high[p + np.uint32(6)] = d, e
        high[p + np.uint32(7)] = pack_fp8(x, y, z, ZERO)


@vividc.kernel("void(float32[:, ::1], uint32[:, ::1])")
def encode_direction(directions, out):
    """As `encode_position`, at four frequencies: two words of each coordinate; x, y, z; and 0."""
    for i in prange(directions.shape[0]):
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        out[i, 0], out[i, 1], _, _ = four_octaves(x)
        out[i, 2], out[i, 3], _, _ = four_octaves(y)
        out[i, 4], out[i, 5], _, _ = four_octaves(z)
        out[i, 6] = pack_fp8(x, y, z, ZERO)
        out[i, 7] = np.uint32(0)


@numba.njit
def words(array, at):
    """Eight words."""
    return (
        array[at],
        array[at + np.uint32(1)],
        array[at + np.uint32(2)],
        array[at + np.uint32(3)],
        array[at + np.uint32(4)],
        array[at + np.uint32(5)],
        array[at + np.uint32(6)],
        array[at + np.uint32(7)],
    )


@numba.njit
def with_chunk(total, x, w):
    """A sum with the products of a chunk of inputs and weights."""
    total = dot_fp8(x[0], w[0], total)
    total = dot_fp8(x[1], w[1], total)
    total = dot_fp8(x[2], w[2], total)
    total = dot_fp8(x[3], w[3], total)
    total = dot_fp8(x[4], w[4], total)
    total = dot_fp8(x[5], w[5], total)
    total = dot_fp8(x[6], w[6], total)
    return dot_fp8(x[7], w[7], total)


@numba.njit
def one_chunk_layer(x, weights, first, samples, y, lowest):
    """A layer of 32 neurons with one chunk of inputs, eight neurons at a time; its weights start
    at `first`. Results are not below `lowest`.
    """
    for block in range(4):
        v = np.uint32(first + EIGHT_NEURONS * block)
        w0, w1 = words(weights, v), words(weights, v + np.uint32(8))
        w2, w3 = words(weights, v + np.uint32(16)), words(weights, v + np.uint32(24))
        w4, w5 = words(weights, v + np.uint32(32)), words(weights, v + np.uint32(40))
        w6, w7 = words(weights, v + np.uint32(48)), words(weights, v + np.uint32(56))
        b = words(weights, v + np.uint32(64))
        for sample in range(samples):
            q = np.uint32(CHUNK * sample)
            p = np.uint32(CHUNK * sample + 2 * block)
            inputs = words(x, q)
            low = pack_fp8(
                with_chunk(bitcast_f32(b[0]), inputs, w0),
                with_chunk(bitcast_f32(b[1]), inputs, w1),
                with_chunk(bitcast_f32(b[2]), inputs, w2),
                with_chunk(bitcast_f32(b[3]), inputs, w3),
            )
            high = pack_fp8(
                with_chunk(bitcast_f32(b[4]), inputs, w4),
                with_chunk(bitcast_f32(b[5]), inputs, w5),
                with_chunk(bitcast_f32(b[6]), inputs, w6),
                with_chunk(bitcast_f32(b[7]), inputs, w7),
            )
            y[p] = max_fp8(low, lowest)
            y[p + np.uint32(1)] = max_fp8(high, lowest)


@numba.njit
def two_neurons(weights, first):
    """Words of two neurons with two chunks of inputs."""
    return (
        words(weights, first),
        words(weights, first + np.uint32(8)),
        words(weights, first + np.uint32(16)),
        words(weights, first + np.uint32(24)),
    )


@numba.njit
def four_results(bias, x0, x1, w, v):
    """A word of the results of four neurons with two chunks of inputs, cut at 0: `w` has the words
    of two of them, `v` those of the others.
    """
    results = pack_fp8(
        with_chunk(with_chunk(bitcast_f32(bias[0]), x0, w[0]), x1, w[1]),
        with_chunk(with_chunk(bitcast_f32(bias[1]), x0, w[2]), x1, w[3]),
        with_chunk(with_chunk(bitcast_f32(bias[2]), x0, v[0]), x1, v[1]),
        with_chunk(with_chunk(bitcast_f32(bias[3]), x0, v[2]), x1, v[3]),
    )
    return max_fp8(results, np.uint32(0))


@numba.njit
def two_chunk_layer(low, high, weights, first, samples, y):
    """A layer of 32 neurons with two chunks of inputs, eight neurons at a time, cut at 0."""
    for block in range(4):
        v = np.uint32(first + EIGHT_OF_BOTH * block)
        w0, w1 = two_neurons(weights, v), two_neurons(weights, v + np.uint32(32))
        w2, w3 = two_neurons(weights, v + np.uint32(64)), two_neurons(weights, v + np.uint32(96))
        b = words(weights, v + np.uint32(128))
        for sample in range(samples):
            q = np.uint32(CHUNK * sample)
            p = np.uint32(CHUNK * sample + 2 * block)
            x0, x1 = words(low, q), words(high, q)
            y[p] = four_results((b[0], b[1], b[2], b[3]), x0, x1, w0, w1)
            y[p + np.uint32(1)] = four_results((b[4], b[5], b[6], b[7]), x0, x1, w2, w3)


@numba.njit
def neuron(x, sample, weights, first):
    """Sum of one neuron with one chunk of inputs."""
    total = bitcast_f32(weights[np.uint32(first + CHUNK)])
    return with_chunk(total, words(x, np.uint32(CHUNK * sample)), words(weights, np.uint32(first)))


@vividc.kernel(
    "void(float32[:, ::1], uint32[::1], uint32[::1], uint32[::1], uint32[::1], float32,"
    " float32[::1])"
)
def density_network(local, low, high, features, weights, step, thickness):
    """Optical thickness at samples' places in their cell, and a chunk of `features` for their
    colour.

    `step` is its length over the scale of the last layer's sums. `low` and `high` are room to work
    in.
    """
    samples = len(thickness)
    encode_position(local, low, high)
    two_chunk_layer(low, high, weights, 0, samples, features)
    one_chunk_layer(features, weights, SECOND, samples, low, np.uint32(0))
    one_chunk_layer(low, weights, THIRD, samples, features, LOWEST)
    for sample in range(samples):
        thickness[sample] = max(neuron(low, sample, weights, LAST), ZERO) * step


@numba.njit
def sigmoid(x):
    return ONE / (ONE + math.exp(min(max(-x, -LARGEST), LARGEST)))


@vividc.kernel("void(uint32[::1], uint32[::1], uint32[::1], uint32[::1], float32, float32[:, ::1])")
def colour_network(features, seen, hidden, weights, unit, colours):
    """Red, green and blue of each sample, from its features and the terms of its direction; `unit`
    is what the last layer's sums are multiplied by.
    """
    samples = colours.shape[0]
    two_chunk_layer(features, seen, weights, 0, samples, hidden)
    for sample in range(samples):
        colours[sample, 0] = sigmoid(neuron(hidden, sample, weights, SECOND) * unit)
        colours[sample, 1] = sigmoid(neuron(hidden, sample, weights, SECOND + NEURON) * unit)
        colours[sample, 2] = sigmoid(neuron(hidden, sample, weights, SECOND + 2 * NEURON) * unit)

"""KiloNeRF's networks (Reiser et al. 2021) with operands of float8 (E4M3) and sums of float32.

A word holds four inputs of a sample or four weights of a neuron, and one operation adds their four
products. Layers take two samples, four neurons and eight words at a time: 64 such operations on
eight sums. A chunk of inputs is eight words of each sample, sample after sample; a layer has one or
two. `weights` has for each four neurons and each chunk 32 words, word by word, and four float32
numbers from which the sums start: the bias, of the second chunk 0.
"""

import math

import numba
import numpy as np
from numba import prange

import vividc
from vividc.lang import bitcast_f32, dot_fp8, max_fp8, pack_fp8

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
LARGEST = np.float32(80.0)
CHUNK = 8
PAIR = 16
BLOCK = 36
BLOCKS = 8
LAYER = BLOCKS * BLOCK


@numba.njit
def octaves(angle):
    """Sine and cosine of an angle and its doubles: eight numbers; and those of 16 times it."""
    s0, c0 = math.sin(angle), math.cos(angle)
    s1, c1 = doubled(s0, c0)
    s2, c2 = doubled(s1, c1)
    s3, c3 = doubled(s2, c2)
    s4, c4 = doubled(s3, c3)
    return pack_fp8(s0, c0, s1, c1), pack_fp8(s2, c2, s3, c3), s4, c4


@numba.njit
def doubled(sine, cosine):
    """Sine and cosine of twice the angle."""
    twice = sine + sine
    return twice * cosine, ONE - twice * sine


@numba.njit
def ten_octaves(value):
    """Words of the sines and cosines of a coordinate at ten frequencies."""
    w0, w1, s4, c4 = octaves(value)
    s5, c5 = doubled(s4, c4)
    s6, c6 = doubled(s5, c5)
    s7, c7 = doubled(s6, c6)
    s8, c8 = doubled(s7, c7)
    s9, c9 = doubled(s8, c8)
    return w0, w1, pack_fp8(s4, c4, s5, c5), pack_fp8(s6, c6, s7, c7), pack_fp8(s8, c8, s9, c9)


@vividc.kernel("void(float32[:, ::1], uint32[:, ::1], uint32[:, ::1])")
def encode_position(points, low, high):
    """Two chunks of the terms of Mildenhall et al. (2020): five words of each coordinate, and x, y
    and z.

    Sine and cosine are computed at the first of the ten frequencies and doubled: the error, which
    doubling makes larger, stays below 2^-13.
    """
    for i in prange(points.shape[0]):
        x = min(max(points[i, 0], -TWO), TWO)
        y = min(max(points[i, 1], -TWO), TWO)
        z = min(max(points[i, 2], -TWO), TWO)
        low[i, 0], low[i, 1], low[i, 2], low[i, 3], low[i, 4] = ten_octaves(x)
        low[i, 5], low[i, 6], low[i, 7], high[i, 0], high[i, 1] = ten_octaves(y)
        high[i, 2], high[i, 3], high[i, 4], high[i, 5], high[i, 6] = ten_octaves(z)
        high[i, 7] = pack_fp8(x, y, z, ZERO)


@vividc.kernel("void(float32[:, ::1], uint32[:, ::1])")
def encode_direction(directions, out):
    """As `encode_position`, at four frequencies: two words of each coordinate; x, y, z; and 0."""
    for i in prange(directions.shape[0]):
        x = min(max(directions[i, 0], -ONE), ONE)
        y = min(max(directions[i, 1], -ONE), ONE)
        z = min(max(directions[i, 2], -ONE), ONE)
        out[i, 0], out[i, 1], _, _ = octaves(x)
        out[i, 2], out[i, 3], _, _ = octaves(y)
        out[i, 4], out[i, 5], _, _ = octaves(z)
        out[i, 6] = pack_fp8(x, y, z, ZERO)
        out[i, 7] = np.uint32(0)


@numba.njit
def add_word(x, q, w, v, s):
    """Adds the products of a word of two samples' inputs with those of four neurons."""
    one = x[q]
    other = x[q + np.uint32(CHUNK)]
    w0 = w[v]
    w1 = w[v + np.uint32(1)]
    w2 = w[v + np.uint32(2)]
    w3 = w[v + np.uint32(3)]
    return (
        dot_fp8(one, w0, s[0]),
        dot_fp8(one, w1, s[1]),
        dot_fp8(one, w2, s[2]),
        dot_fp8(one, w3, s[3]),
        dot_fp8(other, w0, s[4]),
        dot_fp8(other, w1, s[5]),
        dot_fp8(other, w2, s[6]),
        dot_fp8(other, w3, s[7]),
    )


@numba.njit
def sums_of_chunk(x, q, w, v):
    """Sums of four neurons over a chunk of two samples."""
    b0 = bitcast_f32(w[v + np.uint32(32)])
    b1 = bitcast_f32(w[v + np.uint32(33)])
    b2 = bitcast_f32(w[v + np.uint32(34)])
    b3 = bitcast_f32(w[v + np.uint32(35)])
    s = add_word(x, q, w, v, (b0, b1, b2, b3, b0, b1, b2, b3))
    s = add_word(x, q + np.uint32(1), w, v + np.uint32(4), s)
    s = add_word(x, q + np.uint32(2), w, v + np.uint32(8), s)
    s = add_word(x, q + np.uint32(3), w, v + np.uint32(12), s)
    s = add_word(x, q + np.uint32(4), w, v + np.uint32(16), s)
    s = add_word(x, q + np.uint32(5), w, v + np.uint32(20), s)
    s = add_word(x, q + np.uint32(6), w, v + np.uint32(24), s)
    return add_word(x, q + np.uint32(7), w, v + np.uint32(28), s)


@numba.njit
def store_results(y, p, s, lowest):
    """Rounds the sums of four neurons of two samples to words, none below `lowest`."""
    y[p] = max_fp8(pack_fp8(s[0], s[1], s[2], s[3]), lowest)
    y[p + np.uint32(CHUNK)] = max_fp8(pack_fp8(s[4], s[5], s[6], s[7]), lowest)


@numba.njit
def one_chunk_layer(x, weights, first, pairs, y, lowest):
    """A layer of 32 neurons and one chunk of inputs, of `pairs` of samples; its weights start at
    `first`."""
    v = np.uint32(first)
    q = np.uint32(0)
    p = np.uint32(0)
    for _ in range(BLOCKS * pairs):
        store_results(y, p, sums_of_chunk(x, q, weights, v), lowest)
        v = np.uint32(v + np.uint32(BLOCK))
        p = np.uint32(p + np.uint32(1))
        if v == np.uint32(first + LAYER):
            v = np.uint32(first)
            q = np.uint32(q + np.uint32(PAIR))
            p = q


@numba.njit
def two_chunk_layer(x, stride, weights, first, pairs, y):
    """As `one_chunk_layer`, cut at 0; the second chunk is `stride` words after the first."""
    v = np.uint32(first)
    q = np.uint32(0)
    p = np.uint32(0)
    start = np.uint32(0)
    second = False
    a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = ZERO
    for _ in range(2 * BLOCKS * pairs):
        s = sums_of_chunk(x, q, weights, v)
        a0 = s[0] + (a0 if second else ZERO)
        a1 = s[1] + (a1 if second else ZERO)
        a2 = s[2] + (a2 if second else ZERO)
        a3 = s[3] + (a3 if second else ZERO)
        a4 = s[4] + (a4 if second else ZERO)
        a5 = s[5] + (a5 if second else ZERO)
        a6 = s[6] + (a6 if second else ZERO)
        a7 = s[7] + (a7 if second else ZERO)
        v = np.uint32(v + np.uint32(BLOCK))
        q = np.uint32(start + np.uint32(stride))
        if second:
            store_results(y, p, (a0, a1, a2, a3, a4, a5, a6, a7), np.uint32(0))
            p = np.uint32(p + np.uint32(1))
            if v == np.uint32(first + 2 * LAYER):
                v = np.uint32(first)
                start = np.uint32(start + np.uint32(PAIR))
                p = start
            q = start
        second = not second


@numba.njit
def neuron(x, q, w, v):
    """Sum of one neuron of a sample over one chunk; its weights are consecutive words."""
    total = bitcast_f32(w[v + np.uint32(8)])
    total = dot_fp8(x[q], w[v], total)
    total = dot_fp8(x[q + np.uint32(1)], w[v + np.uint32(1)], total)
    total = dot_fp8(x[q + np.uint32(2)], w[v + np.uint32(2)], total)
    total = dot_fp8(x[q + np.uint32(3)], w[v + np.uint32(3)], total)
    total = dot_fp8(x[q + np.uint32(4)], w[v + np.uint32(4)], total)
    total = dot_fp8(x[q + np.uint32(5)], w[v + np.uint32(5)], total)
    total = dot_fp8(x[q + np.uint32(6)], w[v + np.uint32(6)], total)
    return dot_fp8(x[q + np.uint32(7)], w[v + np.uint32(7)], total)


@vividc.kernel(
    "void(uint32[::1], uint32[::1], uint32[::1], uint32[::1], float32, int32, float32[::1])"
)
def density_network(inputs, hidden, features, weights, step, stride, thickness):
    """Optical thickness at each sample, and one chunk of `features` for its colour.

    `step` is its length over the scale of the last layer's sums. `inputs` is overwritten.
    """
    pairs = (len(thickness) + 1) >> 1
    two_chunk_layer(inputs, stride, weights, 0, pairs, hidden)
    one_chunk_layer(hidden, weights, 2 * LAYER, pairs, inputs, np.uint32(0))
    one_chunk_layer(inputs, weights, 3 * LAYER, pairs, features, np.uint32(0xFEFEFEFE))
    for sample in range(len(thickness)):
        total = neuron(inputs, np.uint32(CHUNK * sample), weights, np.uint32(4 * LAYER))
        thickness[sample] = max(total, ZERO) * step


@numba.njit
def sigmoid(x):
    return ONE / (ONE + math.exp(min(max(-x, -LARGEST), LARGEST)))


@vividc.kernel("void(uint32[::1], uint32[::1], uint32[::1], float32, int32, float32[:, ::1])")
def colour_network(inputs, hidden, weights, unit, stride, colours):
    """Red, green and blue of each sample; `unit` is what the last layer's sums are multiplied by.

    Chunks are the features and the terms of the direction.
    """
    samples = colours.shape[0]
    two_chunk_layer(inputs, stride, weights, 0, (samples + 1) >> 1, hidden)
    for sample in range(samples):
        q = np.uint32(CHUNK * sample)
        colours[sample, 0] = sigmoid(neuron(hidden, q, weights, np.uint32(2 * LAYER)) * unit)
        colours[sample, 1] = sigmoid(neuron(hidden, q, weights, np.uint32(2 * LAYER + 9)) * unit)
        colours[sample, 2] = sigmoid(neuron(hidden, q, weights, np.uint32(2 * LAYER + 18)) * unit)

"""A layer of a network, eight samples and eight neurons at a time: each word that is loaded enters
eight products, and 64 sums do not wait for one another.

Activations lie in blocks of 16 samples, [block, feature, sample]; weights in blocks of eight
neurons, [block, 1 + inputs, neuron], the bias first.
"""

import numpy as np
from numba import njit

import vividc

ONE = np.uint32(1)
THREE = np.uint32(3)
FOUR = np.uint32(4)
SEVEN = np.uint32(7)


@njit
def eight(values, first):
    """Eight neighbours of an array, as a tuple."""
    return (
        values[first],
        values[first + np.uint32(1)],
        values[first + np.uint32(2)],
        values[first + np.uint32(3)],
        values[first + np.uint32(4)],
        values[first + np.uint32(5)],
        values[first + np.uint32(6)],
        values[first + np.uint32(7)],
    )


@njit
def plus_products(sums, weights, x):
    """Eight sums, each with one more product."""
    return (
        sums[0] + weights[0] * x,
        sums[1] + weights[1] * x,
        sums[2] + weights[2] * x,
        sums[3] + weights[3] * x,
        sums[4] + weights[4] * x,
        sums[5] + weights[5] * x,
        sums[6] + weights[6] * x,
        sums[7] + weights[7] * x,
    )


@njit
def put(out, first, sums, least):
    """Eight features of one sample."""
    out[first] = max(sums[0], least)
    out[first + np.uint32(16)] = max(sums[1], least)
    out[first + np.uint32(32)] = max(sums[2], least)
    out[first + np.uint32(48)] = max(sums[3], least)
    out[first + np.uint32(64)] = max(sums[4], least)
    out[first + np.uint32(80)] = max(sums[5], least)
    out[first + np.uint32(96)] = max(sums[6], least)
    out[first + np.uint32(112)] = max(sums[7], least)


@vividc.kernel("void(float32[::1], float32[::1], float32[::1], uint32, uint32, uint32, float32)")
def layer(x, weights, out, inputs, neurons, blocks, least):
    """out = max(least, x weights + bias); `neurons` counts blocks of eight."""
    for group in range(blocks << ONE):
        place = np.uint32((np.uint32(group) & ONE) << THREE)
        block = np.uint32(np.uint32(group) >> ONE)
        first = np.uint32(((block * inputs) << FOUR) + place)
        for o in range(neurons):
            start = np.uint32((np.uint32(o) * (inputs + ONE)) << THREE)
            s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = eight(weights, start)
            start += np.uint32(8)
            for k in range(inputs):
                row = eight(weights, np.uint32((np.uint32(k) << THREE) + start))
                c = eight(x, np.uint32((np.uint32(k) << FOUR) + first))
                s0 = plus_products(s0, row, c[0])
                s1 = plus_products(s1, row, c[1])
                s2 = plus_products(s2, row, c[2])
                s3 = plus_products(s3, row, c[3])
                s4 = plus_products(s4, row, c[4])
                s5 = plus_products(s5, row, c[5])
                s6 = plus_products(s6, row, c[6])
                s7 = plus_products(s7, row, c[7])
            end = np.uint32(((block * neurons + np.uint32(o)) << SEVEN) + place)
            put(out, end, s0, least)
            put(out, end + np.uint32(1), s1, least)
            put(out, end + np.uint32(2), s2, least)
            put(out, end + np.uint32(3), s3, least)
            put(out, end + np.uint32(4), s4, least)
            put(out, end + np.uint32(5), s5, least)
            put(out, end + np.uint32(6), s6, least)
            put(out, end + np.uint32(7), s7, least)

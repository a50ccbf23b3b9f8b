"""Signal processing."""

import numpy as np

import vividc

WINDOW = 8
DECAY = np.float32(0.95)


@vividc.kernel("void(float32[::1], float32[::1], float32[::1])")
def fir_filter(x, taps, y):
    """Causal FIR filter: samples before the first are zero."""
    for i in range(len(x)):
        total = np.float32(0.0)
        for k in range(min(len(taps), i + 1)):
            total += taps[k] * x[i - k]
        y[i] = total


@vividc.kernel("void(float32[::1], float32[::1], float32[::1])")
def biquad(x, coefficients, y):
    """Second-order IIR section, transposed direct form II."""
    b0, b1, b2 = coefficients[0], coefficients[1], coefficients[2]
    a1, a2 = coefficients[3], coefficients[4]
    s1 = np.float32(0.0)
    s2 = np.float32(0.0)
    for i in range(len(x)):
        out = b0 * x[i] + s1
        s1 = b1 * x[i] - a1 * out + s2
        s2 = b2 * x[i] - a2 * out
        y[i] = out


@vividc.kernel("void(float32[::1], int32, float32)")
def comb_filter(x, delay, feedback):
    """Echo in place; the delay is known only when it runs."""
    for i in range(delay, len(x)):
        x[i] += feedback * x[i - delay]


@vividc.kernel("void(int32[::1], int32[::1])")
def autocorrelation(x, r):
    for lag in range(len(r)):
        total = 0
        for i in range(len(x) - lag):
            total += x[i] * x[i + lag]
        r[lag] = total


@vividc.kernel("void(int32[::1], int32[::1])")
def moving_average(x, y):
    """Mean of the last eight samples by a running sum."""
    total = np.int32(0)
    for i in range(len(x)):
        total = np.int32(total + x[i])
        if i >= WINDOW:
            total = np.int32(total - x[i - WINDOW])
        y[i] = total >> 3


@vividc.kernel("void(float32[::1], float32[::1])")
def envelope(x, y):
    """Peak follower: jumps up at once, decays slowly."""
    level = np.float32(0.0)
    for i in range(len(x)):
        level *= DECAY
        level = max(level, abs(x[i]))
        y[i] = level


@vividc.kernel("void(int32[::1], int32[::1])")
def haar(x, scratch):
    """Integer Haar transform by lifting, all levels, in place; the length is a power of two."""
    n = len(x)
    while n > 1:
        n >>= 1
        for i in range(n):
            difference = np.int32(x[2 * i + 1] - x[2 * i])
            scratch[i] = x[2 * i] + (difference >> 1)
            scratch[n + i] = difference
        for i in range(2 * n):
            x[i] = scratch[i]


@vividc.kernel("int32(float32[::1], int32[::1], float32)")
def zero_crossings(x, where, hysteresis):
    """Writes where the signal changes sign and returns how often."""
    count = 0
    positive = x[0] > 0
    for i in range(1, len(x)):
        if positive and x[i] < -hysteresis:
            positive = False
        elif not positive and x[i] > hysteresis:
            positive = True
        else:
            continue
        where[count] = i
        count += 1
    return count

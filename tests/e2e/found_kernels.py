"""Kernels that once failed, as users wrote them."""

import numpy as np

import vividc


@vividc.kernel("void(int32[::1], int32)")
def return_early(x, n):
    if n < 0:
        return
    x[0] = n


@vividc.kernel("void(int32[::1])")
def count_up(x):
    i = 0
    while i < len(x):
        x[i] += i
        i += 3


@vividc.kernel("void(int32[::1])")
def step_down(x):
    for i in range(len(x) - 1, -1, -3):
        x[i] = np.int32(x[i] + 7)


@vividc.kernel("void(int32[::1])")
def step_up(x):
    for i in range(0, len(x), 3):
        x[i] = np.int32(x[i] + 7)


@vividc.kernel("int32(int32[::1])")
def find_back(x):
    i = len(x) - 1
    while i >= 0 and x[i] != 5:
        i -= 1
    return i


@vividc.kernel("void(int32[::1])")
def insertion_sort(x):
    for i in range(1, len(x)):
        k = x[i]
        j = i - 1
        while j >= 0 and x[j] > k:
            x[j + 1] = x[j]
            j -= 1
        x[j + 1] = k


@vividc.kernel("void(int32[::1], int32)")
def fill(a, n):
    for i in range(n):
        a[i] = 99


@vividc.kernel("int32(int32[::1], int32[::1])")
def sum_until(a, b):
    s = np.int32(0)
    for i in range(len(b)):
        if a[i] < 0:
            break
        s = np.int32(s + b[i])
    return s


@vividc.kernel("float32(float32[::1])")
def huge_literal(x):
    return x[0] * 1e39


@vividc.kernel("float32(float32)")
def tiny_literal(a):
    return a * 1e-60


@vividc.kernel("float32(float32[::1])")
def euclidean_norm(a):
    return np.linalg.norm(a)


@vividc.kernel("int32(int32[::1], int32)")
def return_from_loop(a, n):
    for i in range(n):
        v = a[i]
        if v > 10:
            return np.int32(v * 3)
    return np.int32(-1)


@vividc.kernel("void(int32[::1], float32[::1])")
def signed_zeros(a, o):
    for i in range(len(a)):
        o[i] = np.float32(-0.0) if a[i] < 3 else np.float32(0.0)


@vividc.kernel("int32(int32[::1], int32, int32)")
def wrapping_counter(o, k, n):
    i = k
    f = np.int32(0)
    while True:
        if i >= n:
            break
        if i < 0:
            f = np.int32(7)
            break
        o[i & 15] += 1
        i = np.int32(i + 2)
    return f


@vividc.kernel("void(float32[::1], int32[::1])")
def low_byte(x, o):
    for i in range(len(x)):
        o[i] = int(x[i]) & 255


@vividc.kernel("void(int32[::1], int32[::1], int32, int32)")
def shifted(a, b, k, n):
    for i in range(n):
        b[i] = a[i + k] + a[-1]


@vividc.kernel("void(float32[::1], int32, int32)")
def flat_index(out, width, height):
    for y in range(height):
        for x in range(width):
            pixel = 4 * (y * width + x)
            out[pixel] = np.float32(x)
            out[pixel + 1] = np.float32(y)


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def compare_sums(a, b, t):
    found = np.int32(0)
    for i in range(len(a)):
        if a[i] + b[i] > t:
            found = np.int32(found + 1)
        if a[i] - b[i] <= t:
            found = np.int32(found + 100)
        if a[i] + b[i] + t == 7:
            found = np.int32(found + 10000)
    return found


@vividc.kernel("void(int32[::1], int32, int32)")
def every_third(a, n, s):
    for i in range(0, n, 3):
        a[i] += 10
    if n + 3 > s - 4:
        a[0] += 1


@vividc.kernel("void(int32[::1], int32, int32)")
def counters_of_two_words(a, n, s):
    for i in range(n - 5, n):
        if i >= 0:
            a[i] += 1
    for i in range(s, n, 2):
        a[i] += 100
    for i in range(n + 3, 0, -7):
        if i < n:
            a[i] += 1000
    j = n - 3
    while j < n + 3:
        if j >= 0 and j < 40:
            a[j] += 7
        j += 2


@vividc.kernel("int32(int32[::1], int32)")
def accumulate_wide(x, limit):
    total = 0
    for i in range(len(x)):
        total += x[i]
        if total > limit:
            return np.int32(i)
    return np.int32(-1)


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def extrema_of_sums(a, b, out):
    for i in range(len(a)):
        low = min(a[i] + 1, b[i] - 1)
        high = max(a[i] + b[i], b[i])
        out[i] ^= np.int32(low) ^ np.int32(high)
        out[i] += np.int32(min(abs(a[i] - b[i]), 255))
        out[i] ^= (a[i] + b[i] + 8) >> 4
        out[i] += (a[i] - b[i]) >> 1
        if min(a[i] + 7, b[i]) > max(b[i] - 9, a[i]):
            out[i] += 1


@vividc.kernel("void(uint32[::1], int32[::1])")
def product_with_lowest_bit(u, x):
    s = 1
    for i in range(0, 14, 3):
        u[15 - i] = (s & x[1]) * x[1]

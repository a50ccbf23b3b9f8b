"""Kernels of the frontend's tests, one per feature of Python that a kernel may use."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from vividc.frontend import KernelFunction, kernel

SCALE = 3
OFFSET = np.float32(0.25)


@njit
def weight(t: float, power: int = 2) -> float:
    result = t
    for _ in range(power - 1):
        result = result * t
    return result


@njit
def clamp(value: int, low: int, high: int) -> int:
    return max(low, min(value, high))


@kernel("void(float32[::1], float32[::1], int32)")
def saxpy(x, y, n):
    for i in range(n):
        y[i] += 2.0 * x[i]


@kernel("void(float32[::1], float32[::1], int32, float32)")
def saxpy_float32(x, y, n, a):
    for i in range(n):
        y[i] += a * x[i]


@kernel("float32(float32[::1], float32[::1])")
def dot(x, y):
    total = np.float32(0)
    for i in range(len(x)):
        total += x[i] * y[i]
    return total


@kernel("void(float32[::1], float32[::1], float32[::1])")
def fir(x, taps, y):
    for i in range(y.shape[0]):
        total = np.float32(0.0)
        for k in range(taps.shape[0]):
            total += taps[k] * x[i + k]
        y[i] = total


@kernel("void(int32[::1], int32[::1])")
def prefix_sum(x, out):
    total = 0
    for i in range(len(x)):
        total += x[i]
        out[i] = total


@kernel("void(float32[:, ::1], float32[::1], float32[::1])")
def relu_gemv(w, x, y):
    for i in range(w.shape[0]):
        total = np.float32(0)
        for j in range(w.shape[1]):
            total += w[i, j] * x[j]
        y[i] = max(total, np.float32(0))


@kernel("int32(int32[::1], int32)")
def break_continue(x, n):
    total = 0
    for i in range(n):
        if x[i] < 0:
            continue
        if x[i] > 90:
            break
        total += x[i]
    return np.int32(total)


@kernel("void(float32[::1], int32)")
def with_helper(x, n):
    for i in range(n):
        x[i] = weight(x[i]) + weight(x[i], 3)


@kernel("void(float32[::1], float32[::1], int32)")
def exponential(x, y, n):
    for i in range(n):
        y[i] = math.exp(-x[i])


@kernel("void(int32[:, ::1], int32[:, ::1], int32[:, ::1])")
def matmul(a, b, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = 0
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@kernel("void(int32[:, :, ::1], int32[::1])")
def planes(x, out):
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            for k in range(x.shape[2]):
                out[i] += x[i, j, k] * (j + 1)


@kernel("float32(float32[:, ::1], float32, float32, int32)")
def blend(gaussians, px, py, n):
    """3D Gaussian splatting (Kerbl et al. 2023): front to back, with both of its early
    terminations.
    """
    transmittance = np.float32(1)
    colour = np.float32(0)
    for i in range(n):
        dx = gaussians[i, 0] - px
        dy = gaussians[i, 1] - py
        power = (
            np.float32(-0.5) * (gaussians[i, 2] * dx * dx + gaussians[i, 4] * dy * dy)
            - gaussians[i, 3] * dx * dy
        )
        if power > 0:
            continue
        alpha = min(np.float32(0.99), gaussians[i, 5] * math.exp(power))
        if alpha < np.float32(1 / 255):
            continue
        left = transmittance * (np.float32(1) - alpha)
        if left < np.float32(1e-4):
            break
        colour += gaussians[i, 6] * alpha * transmittance
        transmittance = left
    return colour + transmittance * OFFSET


@kernel("int32(int32[::1], int32)")
def while_loop(x, key):
    i = 0
    while i < len(x) and x[i] != key:
        i += 1
    return np.int32(i)


@kernel("int32(int32[::1], int32)")
def binary_search(x, key):
    low = 0
    high = len(x)
    while low < high:
        middle = (low + high) // 2
        if x[middle] < key:
            low = middle + 1
        else:
            high = middle
    return np.int32(low)


@kernel("void(int32[::1], int32, int32, int32)")
def range_steps(x, start, stop, scale):
    for i in range(min(start, 40), min(stop, 1000), 3):
        x[i] += scale
    for i in range(20, -1, -2):
        x[i] += i * SCALE
    for i in range(len(x)):
        x[-1 - i] += i


@kernel("void(int32[::1], int32)")
def negative_indices(x, n):
    for i in range(-n, n):
        x[i] += i


@kernel("void(uint32[::1], int32)")
def hashing(x, n):
    for i in range(n):
        h = x[i]
        h = np.uint32(h ^ (h >> 16)) * np.uint32(0x7FEB352D)
        h = np.uint32(h)
        h = np.uint32(h ^ (h >> np.uint32(15))) * np.uint32(0x846CA68B)
        x[i] = np.uint32(h) ^ (np.uint32(h) >> np.uint32(16))


@kernel("void(int32[::1], int32[::1], int32)")
def powers_of_two(x, y, n):
    for i in range(n):
        y[i] = (x[i] // 8) * 3 + x[i] % 16 + (x[i] >> 2) - (x[i] << 3) + abs(x[i])


@kernel("int64(float32[::1], int64)")
def count(x, n):
    found = 0
    for i in range(n):
        if x[i] > np.float32(0.5):
            found += 1
    return found


@kernel("void(float32[::1], int32[::1], int32[::1], bool)")
def conversions(x, i, out, flag):
    for k in range(len(x)):
        value = int(x[k])
        if flag:
            value += i[k] & 7
        x[k] = np.float32(i[k]) * np.float32(0.5)
        out[k] = value


@kernel("void(float32[::1], float32[::1], int32[::1])")
def choose(x, y, out):
    for i in range(len(x)):
        a = x[i]
        b = y[i]
        out[i] = (a < b) + 2 * (a <= b) + 4 * (a > b) + 8 * (a >= b) + 16 * (a == b) + 32 * (a != b)
        x[i] = min(a, b) if a < 0 else max(abs(a), -b)


@kernel("bool(int32[::1], int32)")
def contains(x, key):
    for value in x:  # noqa: SIM110 - the loop is what is tested
        if value == key:
            return True
    return False


@kernel("void(int32[::1], int32[::1])")
def zipped(x, y):
    for i, (a, b) in enumerate(zip(x, y)):  # noqa: B905 - numba knows no `strict`
        x[i] = clamp(np.int32(a + b), -5, 50) ^ i


@kernel("void(int32[::1], int32[::1], int32)")
def one_or_the_other(x, y, n):
    for i in range(n):
        value = x[i] if i & 1 else y[i]
        y[i] = value + 1


@kernel("void(int32[:, ::1], int32)")
def view(x, row):
    line = x[row]
    part = line[1:]
    for i in range(len(part)):
        part[i] += line[0]


@kernel("uint32(uint32, int32)")
def rotate(word, n):
    for _ in range(n):
        word = np.uint32((word << np.uint32(7)) | (word >> np.uint32(25)))
    return word


@kernel("void(float32[::1], int32)")
def powers_and_ufuncs(x, n):
    for i in range(n):
        x[i] = np.exp(-np.abs(x[i])) + x[i] ** 2 - x[i] ** 3 + abs(x[i]) ** 0


@kernel("int32(int32[:, ::1], int32)")
def nested_break(x, limit):
    total = 0
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            total += x[i, j]
            if x[i, j] > limit:
                break
        else:
            total += 1000
        if np.int32(total) < 0:
            return np.int32(-1)
    return np.int32(total)


@kernel("int64(int32[:, ::1])")
def nested_count(x):
    found = 0
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            if x[i, j] > 0:
                found += 2
            if x[i, j] > 5:
                found -= 1
    return found


@kernel("void(int32[::1], uint32[::1], int32[::1])")
def unsigned_and_signed(x, u, out):
    for i in range(len(x)):
        word = u[i]
        wide = x[i] * 65536
        out[i] = (word >> 3) + (word > 7) + (np.int32(wide) >> 16) + (wide & 0xFFFF0000)


@kernel("void(float32[::1], int32)")
def small_tuple(x, n):
    pair = (x[0], x[1])
    for i in range(n):
        x[i] = pair[i & 1] + x[i]


@kernel("int64(int64, int64, bool, int64, int32[::1])")
def awkward_names(ret, entry, value, größe, x):  # noqa: PLC2401 - LLVM escapes such names
    return np.int32(ret + entry * 2 + größe * 3) if value else np.int32(x[0])


@kernel("void(float32[::1])")
def special_constants(x):
    for i in range(len(x)):
        if x[i] > np.float32(3):
            x[i] = np.float32(np.inf)
        elif x[i] < np.float32(-3):
            x[i] = np.float32(np.nan)
        elif x[i] == np.float32(0):
            x[i] = np.float32(1e-45)
        else:
            x[i] = x[i] * np.float32(1e30) * np.float32(-0.0) + np.float32(0.1)


KERNELS = tuple(value for value in list(globals().values()) if isinstance(value, KernelFunction))


@kernel("void(float32[::1], float32[::1], int32)")
def elementary(x, y, n):
    for i in range(n):
        root = math.sqrt(abs(x[i])) + np.sqrt(y[i] * y[i])
        y[i] = root / x[i] + np.floor(x[i]) - math.ceil(y[i])
        x[i] = np.ceil(y[i]) / np.float32(n) + np.exp2(-x[i]) + math.exp2(x[i])


@kernel("float32(float32[::1])")
def mean(x):
    total = np.float32(0)
    for i in range(len(x)):
        total += x[i]
    return total / len(x)


@kernel("int32(int32[::1], int32[::1], int32[::1], int32)")
def load_of_three(a, b, c, n):
    """LLVM makes one load of the three, one of whose pointers comes straight from a branch."""
    acc = 0
    for i in range(n):
        if a[0] > b[i]:
            acc ^= a[i + 1]
        elif c[i] > n:
            acc ^= b[i + 1]
        else:
            acc ^= c[i]
    return acc

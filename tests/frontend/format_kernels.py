"""Kernels on float16 and float8: casts, arithmetic, comparisons, arrays of codes."""

import numpy as np

import vividc
from vividc import lang

CASTS = {"f16": lang.fp16, "e4m3": lang.fp8, "e5m2": lang.e5m2}
CODES = {"f16": lang.fp16_from_bits, "e4m3": lang.fp8_from_bits, "e5m2": lang.e5m2_from_bits}


def on_codes(fmt):
    """Results of everything that two codes can go through, nine words for each pair."""
    number = CODES[fmt]

    @vividc.kernel("void(uint32[::1], uint32[::1], uint32[::1], int32)", name=f"on_{fmt}")
    def kernel(a, b, out, n):
        for i in range(n):
            x = number(a[i])
            y = number(b[i])
            at = 9 * i
            out[at] = lang.bits_of(x + y)
            out[at + 1] = lang.bits_of(x - y)
            out[at + 2] = lang.bits_of(x * y)
            out[at + 3] = lang.bits_of(lang.fma(x, y, x))
            out[at + 4] = lang.bits_of(-x)
            out[at + 5] = lang.bits_of(abs(x))
            out[at + 6] = (x < y) + 2 * (x <= y) + 4 * (x == y) + 8 * (x != y) + 16 * (x > y)
            out[at + 7] = lang.bits_of(min(x, y))
            out[at + 8] = lang.bits_of(max(x, y))

    return kernel


def rounded(fmt):
    """Each number in a format, and back as float32."""
    cast = CASTS[fmt]

    @vividc.kernel("void(float32[::1], float32[::1], int32)", name=f"rounded_{fmt}")
    def kernel(x, out, n):
        for i in range(n):
            out[i] = np.float32(cast(x[i]))

    return kernel


@vividc.kernel("void(float16[:, ::1], float16[::1], float32[::1], uint8[::1])")
def halves(a, x, y, codes):
    """A matrix and a vector of float16: rows of sums in float16, and their codes in float8."""
    for i in range(a.shape[0]):
        total = lang.fp16(0.0)
        for j in range(a.shape[1]):
            total = lang.fma(a[i, j], x[j], total)
        if total < lang.fp16(0.0):
            total = -total
        y[i] = float(total)
        x[i] = total
        codes[i] = lang.bits_of(lang.fp8(total))


def chains(fmt):
    """Four chains side by side, which share lanes."""
    cast = CASTS[fmt]

    @vividc.kernel("void(float32[::1], float32[::1], int32, int32)", name=f"chains_{fmt}")
    def kernel(x, out, n, m):
        for i in range(n):
            a0 = cast(x[4 * i])
            a1 = cast(x[4 * i + 1])
            a2 = cast(x[4 * i + 2])
            a3 = cast(x[4 * i + 3])
            c0, c1, c2, c3 = a0, a1, a2, a3
            for _ in range(m):
                c0 = lang.fma(c0, a0, a1) * a2
                c1 = lang.fma(c1, a1, a2) * a3
                c2 = lang.fma(c2, a2, a3) * a0
                c3 = lang.fma(c3, a3, a0) * a1
                c0 = -(c0 - a0)
                c1 = -(c1 - a1)
                c2 = -(c2 - a2)
                c3 = -(c3 - a3)
            out[4 * i] = np.float32(c0)
            out[4 * i + 1] = np.float32(c1)
            out[4 * i + 2] = np.float32(c2)
            out[4 * i + 3] = np.float32(c3)

    return kernel


@vividc.kernel("void(float16[::1], int32[::1])")
def truths(x, out):
    for i in range(len(x)):
        if x[i]:
            out[i] += 1
        if not x[i]:
            out[i] += 2
        out[i] += 4 * bool(x[i])


@vividc.kernel("void(float16[::1])")
def ordered(x):
    x.sort()


WORDS = {
    "f16": (lang.pack_fp16, lang.dot_fp16, lang.max_fp16),
    "e4m3": (lang.pack_fp8, lang.dot_fp8, lang.max_fp8),
    "e5m2": (lang.pack_e5m2, lang.dot_e5m2, lang.max_e5m2),
}


def on_words(fmt):
    """Words of neighbours, and of each with the next: the sum of products, and the larger lanes."""
    pack, dot, larger = WORDS[fmt]
    if fmt == "f16":

        @vividc.kernel(
            "void(float32[::1], uint32[::1], float32[::1], uint32[::1])", name="words_f16"
        )
        def kernel(x, words, sums, most):
            for i in range(len(words)):
                words[i] = pack(x[2 * i], x[2 * i + 1])
            for i in range(len(sums)):
                sums[i] = dot(words[i], words[i + 1], x[i])
                most[i] = larger(words[i], words[i + 1])

        return kernel

    @vividc.kernel(
        "void(float32[::1], uint32[::1], float32[::1], uint32[::1])", name=f"words_{fmt}"
    )
    def kernel(x, words, sums, most):
        for i in range(len(words)):
            words[i] = pack(x[4 * i], x[4 * i + 1], x[4 * i + 2], x[4 * i + 3])
        for i in range(len(sums)):
            sums[i] = dot(words[i], words[i + 1], x[i])
            most[i] = larger(words[i], words[i + 1])

    return kernel

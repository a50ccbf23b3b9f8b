"""Arithmetic of 64 bits: hashes, fixed point, modular products, wide sums and counters."""

import numpy as np

import vividc

ADLER = 65521
MODULUS = 1000000007
PRIME = 998244353


@vividc.kernel("uint64(uint32[::1])")
def fnv1a_64(data):
    """Fowler, Noll and Vo: one byte in each word, 64 bits of hash."""
    h = np.uint64(0xCBF29CE484222325)
    for i in range(len(data)):
        h = (h ^ np.uint64(data[i] & 0xFF)) * np.uint64(0x100000001B3)
    return h


@vividc.kernel("void(uint64, uint32[::1], uint32[::1])")
def splitmix64(seed, low, high):
    """Steele, Lea and Flood 2014; both words of each number are stored."""
    state = seed
    for i in range(len(low)):
        state += np.uint64(0x9E3779B97F4A7C15)
        z = state
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z = z ^ (z >> np.uint64(31))
        low[i] = z
        high[i] = z >> np.uint64(32)


@vividc.kernel("uint64(uint64, uint32[::1])")
def xorshift64_star(seed, out):
    """Vigna 2016: the upper words of the product; gives the state for the next call."""
    x = seed
    for i in range(len(out)):
        x ^= x >> np.uint64(12)
        x ^= x << np.uint64(25)
        x ^= x >> np.uint64(27)
        out[i] = (x * np.uint64(0x2545F4914F6CDD1D)) >> np.uint64(32)
    return x


@vividc.kernel("void(uint64, uint32[::1])")
def pcg32(seed, out):
    """O'Neill 2014: a congruential generator of 64 bits, its output rotated by its top bits."""
    state = seed
    for i in range(len(out)):
        mixed = np.uint32(((state >> np.uint64(18)) ^ state) >> np.uint64(27))
        turn = np.uint32(state >> np.uint64(59))
        out[i] = (mixed >> turn) | (mixed << ((32 - turn) & 31))
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def q31_multiply(a, b, out):
    """Products of fixed-point fractions, rounded and saturated."""
    for i in range(len(out)):
        product = (a[i] * b[i] + (1 << 30)) >> 31
        out[i] = min(max(product, -(1 << 31)), (1 << 31) - 1)


@vividc.kernel("int64(int32[::1], int32[::1])")
def dot64(a, b):
    """A dot product of integers, no bit lost."""
    total = 0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@vividc.kernel("int32(int32[::1], int64)")
def squares_until(x, limit):
    """How many squares add up to no more than a limit."""
    total = 0
    for i in range(len(x)):
        total += x[i] * x[i]
        if total > limit:
            return i
    return len(x)


@vividc.kernel("uint32(uint32[::1])")
def adler32_lazy(data):
    """Adler-32 with its sums reduced by comparisons."""
    a = 1
    b = 0
    for byte in data:
        a += byte
        if a >= ADLER:
            a -= ADLER
        b += a
        if b >= ADLER:
            b -= ADLER
    return (b << 16) | a


@vividc.kernel("void(uint32[::1], uint32, uint32, uint32[::1])")
def montgomery(x, modulus, inverse, out):
    """x * x / 2**32 modulo an odd number below 2**31; modulus * inverse = -1 modulo 2**32."""
    n = np.uint64(modulus)
    for i in range(len(out)):
        product = np.uint64(x[i]) * np.uint64(x[i])
        factor = np.uint64(np.uint32(product) * inverse & 0xFFFFFFFF)
        reduced = (product + factor * n) >> np.uint64(32)
        out[i] = reduced - n if reduced >= n else reduced


@vividc.kernel("int32(int64, int64)")
def power_modulo_wide(base, exponent):
    """Square and multiply modulo a prime of number-theoretic transforms."""
    result = 1
    square = base % PRIME
    while exponent > 0:
        if exponent & 1:
            result = result * square % PRIME
        square = square * square % PRIME
        exponent >>= 1
    return result


@vividc.kernel("int32(uint32[::1])")
def rolling_hash(text):
    """Of Rabin and Karp."""
    h = 0
    for c in text:
        h = (h * 911382323 + c) % MODULUS
    return np.int32(h)


@vividc.kernel("void(uint32[::1], uint32[::1], uint32[::1], uint32[::1])")
def morton64(x, y, low, high):
    """Bits of two words interleaved to 64."""
    for i in range(len(x)):
        code = np.uint64(0)
        for bit in range(32):
            one = np.uint64((x[i] >> bit) & 1)
            other = np.uint64((y[i] >> bit) & 1)
            code |= (one | (other << np.uint64(1))) << np.uint64(2 * bit)
        low[i] = code
        high[i] = code >> np.uint64(32)


@vividc.kernel("int64(int64, int64)")
def gcd64(a, b):
    """Stein's algorithm on positive integers of 64 bits."""
    shift = 0
    while (a | b) & 1 == 0:
        a >>= 1
        b >>= 1
        shift += 1
    while a & 1 == 0:
        a >>= 1
    while b != 0:
        while b & 1 == 0:
            b >>= 1
        if a > b:
            a, b = b, a
        b -= a
    return a << shift


@vividc.kernel("int32(int32)")
def integer_root(n):
    """The largest i with i * i <= n."""
    i = 0
    while (i + 1) * (i + 1) <= n:
        i += 1
    return i

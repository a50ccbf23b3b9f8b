"""Kernels whose 64-bit integers outgrow a word where it matters."""

import numpy as np

from vividc.frontend import kernel


@kernel("int32(int32, int32)")
def square_exceeds(n, t):
    return 1 if n * n > t else 0


@kernel("int32(int32)")
def root(n):
    i = 46300
    while i * i < n:
        i += 1
    return i


@kernel("int64(int64, int64)")
def gcd_by_subtraction(x, y):
    while x != y:
        if x > y:
            x -= y
        else:
            y -= x
    return x


@kernel("uint32(uint32[::1])")
def adler(data):
    a, b = 1, 0
    for byte in data:
        a += byte
        if a >= 65521:
            a -= 65521
        b += a
        if b >= 65521:
            b -= 65521
    return b << 16 | a


@kernel("int64(uint32)")
def spread(x):
    code = 0
    for bit in range(32):
        code |= (x >> bit & 1) << (2 * bit)
    return code


@kernel("int64(int64, int64)")
def shifts(x, n):
    return (x << n) ^ (x >> n) ^ (x >> (n & 31)) ^ (x << (n | 32))


@kernel("uint64(uint64, uint64)")
def unsigned_shifts(x, n):
    turned = (x << n) | (x >> (np.uint64(64) - n & np.uint64(63)))
    return turned ^ (x >> n)


@kernel("uint64(uint64)")
def congruential(x):
    return x * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)


@kernel("uint32(uint64, int32)")
def splitmix_word(x, count):
    for _ in range(count):
        x += np.uint64(0x9E3779B97F4A7C15)
        z = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        x = z ^ (z >> np.uint64(31))
    return x >> np.uint64(32)


@kernel("int32(int32, int32)")
def q16(a, b):
    return np.int32((a * b) >> 16)


@kernel("int32(int32[::1], int32[::1])")
def saturated_dot(a, b):
    total = 0
    for i in range(len(a)):
        total += a[i] * b[i]
    return min(max(total, -(2**31)), 2**31 - 1)


@kernel("int64(int64, int32)")
def crosses(start, count):
    x = start
    steps = 0
    for _ in range(count):
        x += 3
        if x > 4294967296 or x == 2147483648:
            steps += 1
    return x * 1000 + steps


@kernel("int32(int64, int64)")
def orders(a, b):
    return (
        (a < b)
        + 2 * (a <= b)
        + 4 * (a == b)
        + 8 * (np.uint64(a) < np.uint64(b))
        + 16 * (a > 0)
        + 32 * (b >= 0)
        + 64 * (a != 0)
    )


@kernel("int32(int32, int32, int32)")
def sums_against_words(a, b, c):
    """Sums and differences that a word does not hold, by what a word does."""
    more, less = a + b, a - b
    return (
        (more < c)
        + 2 * (more <= c)
        + 4 * (c < more)
        + 8 * (c <= more)
        + 16 * (less < c)
        + 32 * (less <= c)
        + 64 * (c < less)
        + 128 * (c <= less)
        + 256 * (more < less)
    )


@kernel("int64(int32[::1], int32)")
def extremes_of_sums(x, a):
    low = high = first = x[0]
    for i in range(len(x) - 1):
        low = min(low, x[i] + x[i + 1])
        high = max(high, x[i] - x[i + 1])
        first = np.int32(min(first, x[i] + a))
    return low ^ (high << 8) ^ first


@kernel("int64(int64, int64)")
def extremes(a, b):
    return max(a, b) - min(a, b) + abs(a) - max(a - b, 0)


@kernel("uint64(uint64, uint64)")
def unsigned_extremes(a, b):
    less = a - b if a > b else np.uint64(0)
    return max(a, b) ^ (min(a, b) << np.uint64(1)) ^ less


@kernel("int64(int64, int64)")
def divides(a, b):
    return (a // b) ^ (a % b << 1)


@kernel("uint64(uint64, uint64)")
def divides_unsigned(a, b):
    return (a // b) ^ (a % b << np.uint64(1))


@kernel("int64(int64)")
def divides_by_constants(a):
    return a // 10 ^ a % 1000000007 ^ a // -7 ^ a % 1099511627776 ^ a // 4294967311 ^ a % 3000000000


@kernel("uint64(uint64)")
def divides_unsigned_by_constants(a):
    return (
        a // np.uint64(10)
        ^ a % np.uint64(0xFFFFFFFFFFFFFFC5)
        ^ a // np.uint64(0x8000000000000001)
        ^ a % np.uint64(4096)
        ^ a // np.uint64(1 << 40)
    )


@kernel("float32(int64)")
def to_float(a):
    return np.float32(a)


@kernel("float32(uint64)")
def unsigned_to_float(a):
    return np.float32(a)


@kernel("float32(int32, int32)")
def product_to_float(a, b):
    return np.float32(a * (b >> 16))


@kernel("uint64(uint32, uint32)")
def modular_product(a, b):
    return np.uint64(a) * np.uint64(b) % np.uint64(4294967291)


@kernel("int64(int32, int32, int32, int32)")
def mixed_product(a, b, c, d):
    return (np.int64(np.uint32(a)) * b) ^ ((a + b) * c) ^ ((a << 3) * (np.int64(np.uint32(d)) - b))


@kernel("int64(bool, int64, int32)")
def chosen(flag, a, b):
    return a if flag else b * 3


@kernel("uint64(int32)")
def wraps(a):
    return np.uint64(a)


@kernel("int64(uint32)")
def large_word(a):
    return np.int64(a)


@kernel("int64(int64)")
def early_return(a):
    if a < 0:
        return 1
    if a > 1 << 40:
        return a >> 3
    return a * a

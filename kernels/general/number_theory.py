"""Division and remainder: divisors, digits, dates, codes and residues."""

import math

import numpy as np

import vividc

MODULUS = 10007
JANUARY = 10  # months of a year that starts in March


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def gcd_by_remainder(a, b, out):
    """Euclid's algorithm."""
    for i in range(len(out)):
        x = a[i]
        y = b[i]
        while y != 0:
            x, y = y, np.int32(x % y)
        out[i] = abs(x)


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def gcd_of_library(a, b, out):
    for i in range(len(out)):
        out[i] = math.gcd(a[i], b[i])


@vividc.kernel("void(uint32[::1], int32[::1])")
def digit_sums(x, out):
    for i in range(len(x)):
        rest = x[i]
        total = 0
        while rest > 0:
            total += rest % 10
            rest //= 10
        out[i] = total


@vividc.kernel("int32(uint32)")
def count_primes(limit):
    """Below a limit, by trial division."""
    found = np.int32(0)
    for n in range(2, limit):
        divisor = np.uint32(2)
        while np.uint32(divisor * divisor) <= n and n % divisor != 0:
            divisor = np.uint32(divisor + 1)
        if np.uint32(divisor * divisor) > n:
            found = np.int32(found + 1)
    return found


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def power_modulo(base, exponent, out):
    """By repeated squaring."""
    for i in range(len(out)):
        b = base[i] % MODULUS
        e = exponent[i]
        result = 1
        while e > 0:
            if e & 1:
                result = result * b % MODULUS
            b = b * b % MODULUS
            e >>= 1
        out[i] = result


@vividc.kernel("void(uint32, uint32, uint32[::1])")
def lcg_modulo(seed, modulus, out):
    """The minimal multiplier that keeps the product in a word, and any modulus."""
    x = seed
    for i in range(len(out)):
        x = np.uint32(x % modulus)
        x = np.uint32(np.uint32(x * np.uint32(69069)) + np.uint32(1))
        out[i] = x % modulus


@vividc.kernel("void(int32[::1], int32[:, ::1])")
def civil_from_days(days, dates):
    """Year, month and day of days since 1970-01-01, also before (proleptic Gregorian calendar)."""
    for i in range(len(days)):
        z = np.int32(days[i] + 719468)
        era = z // 146097
        day_of_era = z % 146097
        year_of_era = (
            day_of_era - day_of_era // 1460 + day_of_era // 36524 - day_of_era // 146096
        ) // 365
        day_of_year = day_of_era - (365 * year_of_era + year_of_era // 4 - year_of_era // 100)
        shifted = (5 * day_of_year + 2) // 153
        is_next_year = shifted >= JANUARY
        dates[i, 0] = year_of_era + era * 400 + is_next_year
        dates[i, 1] = shifted + 3 - 12 * is_next_year
        dates[i, 2] = day_of_year - (153 * shifted + 2) // 5 + 1


@vividc.kernel("void(int32[::1], int32, int32[:, ::1])")
def digits_in_base(x, base, digits):
    """The lowest digit first; of negative numbers the digits of Python's floor division."""
    for i in range(digits.shape[0]):
        rest = x[i]
        for k in range(digits.shape[1]):
            quotient, digit = divmod(rest, base)
            digits[i, k] = digit
            rest = np.int32(quotient)


@vividc.kernel("int32(int32)")
def longest_collatz(limit):
    """The start below a limit with the most steps; 3 n + 1 stays a word for limits below 100000."""
    best = 0
    longest = np.int32(0)
    for start in range(1, limit):
        n = np.uint32(start)
        steps = np.int32(0)
        while n != 1:
            n = np.uint32(n // 2) if n % 2 == 0 else np.uint32(3 * n + 1)
            steps = np.int32(steps + 1)
        if steps > longest:
            longest = steps
            best = start
    return best


@vividc.kernel("void(int32[:, ::1], int32[::1])")
def isbn13_check(digits, check):
    """The check digits of rows of twelve digits."""
    for row in range(digits.shape[0]):
        total = 0
        for k in range(12):
            total += digits[row, k] * (1 + 2 * (k % 2))
        check[row] = (10 - np.int32(total) % 10) % 10


@vividc.kernel("void(int32[::1], int32, int32[::1])")
def modular_inverse(a, modulus, out):
    """By the extended Euclidean algorithm; 0 where there is none."""
    for i in range(len(a)):
        r0 = modulus
        r1 = np.int32(a[i] % modulus)
        t0 = np.int32(0)
        t1 = np.int32(1)
        while r1 != 0:
            q = np.int32(r0 // r1)
            r0, r1 = r1, np.int32(r0 - q * r1)
            t0, t1 = t1, np.int32(t0 - q * t1)
        out[i] = t0 % modulus if r0 == 1 else 0


@vividc.kernel("int32(int32, uint32)")
def fibonacci_modulo(n, modulus):
    a = np.uint32(0)
    b = np.uint32(1)
    for _ in range(n):
        a, b = b, np.uint32(np.uint32(a + b) % modulus)
    return np.int32(a % modulus)


@vividc.kernel("void(uint32[::1], int32[::1])")
def bit_counts(x, counts):
    """By the sums of neighbouring bits."""
    for i in range(len(x)):
        v = x[i]
        v = v - ((v >> 1) & 0x55555555)
        v = (v & 0x33333333) + ((v >> 2) & 0x33333333)
        v = (v + (v >> 4)) & 0x0F0F0F0F
        counts[i] = np.uint32(v * 0x01010101) >> 24


@vividc.kernel("void(int32[::1], int32, int32[::1])")
def bin_counts(x, width, counts):
    """A histogram of bins of any width, the values below 0 included."""
    for i in range(len(x)):
        counts[np.int32(x[i] // width) % len(counts)] += 1

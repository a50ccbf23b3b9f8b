"""Checksums, ciphers, random numbers and bit tricks."""

import numpy as np

import vividc

MASK = 0xFFFFFFFF
ADLER = 65521
DELTA = 0x9E3779B9


@vividc.kernel("uint32(uint32[::1])")
def crc32(data):
    """One byte in each word; bit by bit, with masks."""
    crc = 0xFFFFFFFF
    for i in range(len(data)):
        crc ^= data[i] & 0xFF
        for _ in range(8):
            if crc & 1:
                crc = (crc >> 1) ^ 0xEDB88320
            else:
                crc >>= 1
    return crc ^ 0xFFFFFFFF


@vividc.kernel("void(uint32[::1])")
def crc32_table(table):
    for n in range(256):
        c = n
        for _ in range(8):
            c = 0xEDB88320 ^ (c >> 1) if c & 1 else c >> 1
        table[n] = c


@vividc.kernel("uint32(uint32[::1], uint32[::1])")
def crc32_by_table(data, table):
    crc = np.uint32(0xFFFFFFFF)
    for byte in data:
        crc = table[(crc ^ byte) & 0xFF] ^ (crc >> 8)
    return crc ^ 0xFFFFFFFF


@vividc.kernel("uint32(int32[::1])")
def adler32(data):
    a = np.int32(1)
    b = np.int32(0)
    for byte in data:
        a = np.int32(a + (byte & 255))
        if a >= ADLER:
            a = np.int32(a - ADLER)
        b = np.int32(b + a)
        if b >= ADLER:
            b = np.int32(b - ADLER)
    return (b << 16) | a


@vividc.kernel("void(uint32, uint32[::1])")
def xorshift32(seed, out):
    """Marsaglia 2003."""
    x = np.int64(seed)
    for i in range(len(out)):
        x ^= (x << 13) & MASK
        x ^= x >> 17
        x ^= (x << 5) & MASK
        out[i] = x


@vividc.kernel("void(int64, int32[::1])")
def lcg(seed, out):
    """The high 15 bits of a linear congruential generator."""
    x = seed & MASK
    for i in range(len(out)):
        x = (x * 1103515245 + 12345) & 0x7FFFFFFF
        out[i] = x >> 16


@vividc.kernel("uint32(uint32[::1])")
def fnv1a(data):
    h = 0x811C9DC5
    for i in range(len(data)):
        h = ((h ^ (data[i] & 0xFF)) * 0x01000193) & MASK
    return h


@vividc.kernel("void(uint32[::1], uint32[::1])")
def xtea(block, key):
    """Enciphers pairs of words in place, 32 rounds (Needham and Wheeler 1997)."""
    for p in range(0, len(block) - 1, 2):
        v0 = np.int64(block[p])
        v1 = np.int64(block[p + 1])
        total = 0
        for _ in range(32):
            v0 += (((v1 << 4) ^ (v1 >> 5)) + v1) ^ (total + key[total & 3])
            v0 &= MASK
            total = (total + DELTA) & MASK
            v1 += (((v0 << 4) ^ (v0 >> 5)) + v0) ^ (total + key[(total >> 11) & 3])
            v1 &= MASK
        block[p] = v0
        block[p + 1] = v1


@vividc.kernel("void(uint32[::1])")
def sha256_schedule(w):
    """Extends 16 words of a message to 64 (FIPS 180-4)."""
    for t in range(16, 64):
        x = w[t - 15]
        y = w[t - 2]
        s0 = ((x >> 7) | (x << 25)) ^ ((x >> 18) | (x << 14)) ^ (x >> 3)
        s1 = ((y >> 17) | (y << 15)) ^ ((y >> 19) | (y << 13)) ^ (y >> 10)
        w[t] = (w[t - 16] + s0 + w[t - 7] + s1) & MASK


@vividc.kernel("void(uint32[::1], int32[::1])")
def popcount(x, counts):
    """Clears the lowest set bit until none is left (Kernighan)."""
    for i in range(len(x)):
        v = x[i]
        n = 0
        while v != 0:
            v &= v - 1
            n += 1
        counts[i] = n


@vividc.kernel("void(uint32[::1], uint32[::1])")
def bit_reverse(x, out):
    for i in range(len(x)):
        v = x[i]
        reverse = 0
        for _ in range(32):
            reverse = (reverse << 1) | (v & 1)
            v >>= 1
        out[i] = reverse


@vividc.kernel("void(uint32[::1], uint32[::1], uint32[::1])")
def morton(x, y, code):
    """Interleaves the low 15 bits of two coordinates."""
    for i in range(len(x)):
        result = 0
        for bit in range(15):
            result |= ((x[i] >> bit) & 1) << (2 * bit)
            result |= ((y[i] >> bit) & 1) << (2 * bit + 1)
        code[i] = result

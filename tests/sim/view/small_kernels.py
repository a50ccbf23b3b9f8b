"""Kernels for the views: a loop, and one whose loads meet in a bank."""

import vividc


@vividc.kernel("int32(int32[::1], int32)")
def total(x, n):
    found = 0
    for i in range(n):
        found += x[i]
    return found


@vividc.kernel("void(int32[::1], int32[::1], int32, int32, int32)")
def strided(x, y, a, b, n):
    for i in range(n):
        y[i] = x[a * i] + x[b * i]


@vividc.kernel("int32(int32[::1], int32)")
def find(x, wanted):
    i = 0
    while x[i] != wanted:
        i += 1
    return i

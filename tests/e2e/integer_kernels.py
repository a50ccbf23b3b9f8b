"""Kernels of `test_integers`: integer operators in loops that the array runs."""

import numpy as np

import vividc


@vividc.kernel("void(int32[::1], int32[::1], int32[::1], int32[::1])")
def signed_division(a, b, quotient, remainder):
    for i in range(len(a)):
        q, r = divmod(a[i], b[i])
        quotient[i] = q
        remainder[i] = r


@vividc.kernel("void(uint32[::1], uint32[::1], uint32[::1], uint32[::1])")
def unsigned_division(a, b, quotient, remainder):
    for i in range(len(a)):
        quotient[i] = a[i] // b[i]
        remainder[i] = a[i] % b[i]


@vividc.kernel("void(int32, int32, int32[::1])")
def signed_once(a, b, out):
    q, r = divmod(a, b)
    out[0] = q
    out[1] = r


@vividc.kernel("void(uint32, uint32, uint32[::1])")
def unsigned_once(a, b, out):
    out[0] = a // b
    out[1] = a % b


@vividc.kernel("void(int32[::1], int32, int32[::1], int32[::1])")
def by_a_parameter(a, b, quotient, remainder):
    for i in range(len(a)):
        quotient[i] = a[i] // b
        remainder[i] = a[i] % b


@vividc.kernel("void(int32[::1], int32[::1], uint32[::1])")
def by_constants(a, out, unsigned):
    for i in range(len(a)):
        x = np.uint32(a[i])
        out[i] = a[i] // 10 + a[i] % 7
        unsigned[i] = np.uint32(x // 7 + x % 10)


@vividc.kernel("void(uint32[::1], uint32[::1], uint32[::1])")
def rotations(a, b, out):
    for i in range(len(a)):
        by = b[i] & 31
        left = np.uint32(a[i] << by) | np.uint32(a[i] >> (-by & 31))
        out[i] = left ^ np.uint32(np.int8(a[i]) * np.int8(b[i]))

"""Inner functions called with keyword arguments: in any order, mixed, with defaults left out."""

import numba
import numpy as np

import vividc


@numba.njit
def _mix(a, b, c=3):
    return a * 100 + b * 10 + c


@vividc.kernel("int32(int32[::1], int32)")
def keywords(x, n):
    s = np.int32(0)
    for i in range(n):
        s += _mix(b=x[i], a=n) + _mix(x[i], c=1, b=i) - _mix(c=i, b=x[i], a=2)
    return s


def test_keywords_of_an_inner_function_mean_what_they_mean_in_numba():
    x = np.array([4, -7, 9], np.int32)
    result = vividc.simulate(vividc.compile(keywords, fabric="vivid-tile"), x, 3)
    assert result.value == keywords(x, 3)

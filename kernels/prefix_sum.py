"""Inclusive prefix sum in place: a recurrence through memory."""

import vividc


@vividc.kernel("void(int32[::1])")
def prefix_sum(x):
    for i in range(1, len(x)):
        x[i] += x[i - 1]

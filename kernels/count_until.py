"""Counts the words above a threshold up to the first negative one: a loop with `break` and
`continue`.
"""

import numpy as np

import vividc


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def count_until(x, marks, threshold):
    count = np.int32(0)
    for i in range(len(x)):
        value = x[i]
        if value < 0:
            break
        if value <= threshold:
            continue
        marks[i] = 1
        count = np.int32(count + 1)
    return count

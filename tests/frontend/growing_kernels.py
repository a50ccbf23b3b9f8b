"""Kernels with lists that grow and shrink, by what is done to them; each is called with an array of
float32, one of int32 and a number.
"""

from __future__ import annotations

import numba
import numpy as np

GROWING = []


def growing(function):
    """Add a kernel to the cases."""
    GROWING.append(function)
    return function


@growing
def appended(x, a, n):
    out = []
    for i in range(len(x)):
        if x[i] > 0:
            out.append(x[i] * x[i])
    return np.array(out), len(out)


@growing
def appended_in_two_loops(x, a, n):
    out = [n]
    for i in range(len(x)):
        for j in range(i):
            if x[i] * x[j] > 1:
                out.append(100 * i + j)
    return np.array(out)


@growing
def comprehended(x, a, n):
    out = [v * 2 for v in x if v > 0.5]
    return np.array(out), sum(out), max(out)


@growing
def stack_of_pairs(x, a, n):
    seen = np.zeros((4, 4), np.bool_)
    stack = [(0, n)]
    count = 0
    while len(stack) > 0:
        i, j = stack.pop()
        if i < 0 or j < 0 or i > 3 or j > 3 or seen[i, j] or a[4 * i + j] > 3:
            continue
        seen[i, j] = True
        count += 1
        stack.append((i + 1, j))
        stack.append((i - 1, j))
        stack.append((i, j + 1))
        stack.append((i, j - 1))
    return count, seen


@growing
def elements_of_two_types(x, a, n):
    out = []
    for i in range(len(x)):
        if x[i] > 0:
            out.append((i, x[i], x[i] > 1))
    total = np.float32(0)
    for k, v, big in out:
        total += k * v if big else v
    return total


@growing
def inserted(x, a, n):
    out = [x[0]]
    for i in range(1, len(x)):
        k = 0
        while k < len(out) and out[k] < x[i]:
            k += 1
        out.insert(k, x[i])
    return np.array(out)


@growing
def queued(x, a, n):
    queue = [x[i] for i in range(len(x))]
    total, k = np.float32(0), 0
    while queue:
        v = queue.pop(0)
        total += v * k
        k += 1
        if v > 1 and k < 40:
            queue.append(v * np.float32(0.5))
    return total, k


@growing
def made_in_each_iteration(x, a, n):
    total = np.float32(0)
    for i in range(len(x)):
        part = [x[i]]
        for j in range(i):
            part.append(x[j])
        total += part[len(part) // 2] + part[-1]
    return total


@growing
def cut_and_joined(x, a, n):
    out = [v for v in x if v > 0]
    part = out[1:-1] + [np.float32(n)]  # noqa: RUF005 - a sum is what is tested
    part += [x[0], x[1]]
    part.extend(x[2:4])
    del part[0]
    return np.array(part), out == part, part[::-1]


@growing
def searched(x, a, n):
    out = [v for v in a if v > -3]
    out.reverse()
    out.remove(out[1])
    return np.array(out), out.index(out[2]), out[1] in out, out.count(out[0])


@growing
def repeated(x, a, n):
    out = [0.0] * n
    for i in range(n):
        out[i] = x[i] * i
    return np.array(out)


@growing
def emptied(x, a, n):
    out = [x[0]]
    total = np.float32(0)
    for i in range(len(x)):
        if len(out) > n:
            for v in out:
                total += v * i
            out.clear()
        out.append(x[i])
    return total


@growing
def sorted_up_and_down(x, a, n):
    up = [v for v in x]
    up.sort()
    down = sorted(a, reverse=True)
    return np.array(up), np.array(down)


@growing
def longest_increasing_part(x, a, n):
    tails = [a[0]]
    for v in a:
        low, high = 0, len(tails)
        while low < high:
            middle = (low + high) // 2
            if tails[middle] < v:
                low = middle + 1
            else:
                high = middle
        if low == len(tails):
            tails.append(v)
        else:
            tails[low] = v
    return len(tails), np.array(tails)


@numba.njit
def positive(x):
    out = []
    for v in x:
        if v > 0:
            out.append(v)
    return out


@numba.njit
def add_to(out, v):
    if v > 0:
        out.append(v)


@growing
def made_and_filled_by_helpers(x, a, n):
    out = positive(x)
    both = positive(a)
    for v in x:
        add_to(out, -v)
    return np.array(out), np.array(both)


@growing
def returned(x, a, n):
    return [v for v in a if v > 0], [v > 0 for v in x], positive(x), len(x) > n


@growing
def complex_elements(x, a, n):
    out = []
    for v in x:
        if v > 0:
            out.append(complex(v, 2 * v))
    total = 0j
    for c in out:
        total += c * c
    return total


@growing
def one_list_by_two_names(x, a, n):
    out = [x[0]]
    again = out
    for i in range(n):
        again.append(x[i])
    return len(out), out is again


@growing
def numpys_that_keep_lists(x, a, n):
    return np.unique(a)

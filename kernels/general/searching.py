"""Sorting, searching and scans."""

import numba
import numpy as np

import vividc


@vividc.kernel("void(int32[::1])")
def insertion_sort(x):
    for i in range(1, len(x)):
        key = x[i]
        j = i - 1
        while j >= 0 and x[j] > key:
            x[j + 1] = x[j]
            j -= 1
        x[j + 1] = key


@vividc.kernel("void(float32[::1])")
def selection_sort(x):
    n = len(x)
    for i in range(n - 1):
        least = i
        for j in range(i + 1, n):
            if x[j] < x[least]:
                least = j
        x[i], x[least] = x[least], x[i]


@vividc.kernel("int32(int32[::1])")
def bubble_sort(x):
    """Sorts in place, until a pass swaps nothing; returns the number of passes."""
    passes = 0
    swapped = True
    while swapped:
        swapped = False
        passes += 1
        for j in range(len(x) - passes):
            if x[j] > x[j + 1]:
                x[j], x[j + 1] = x[j + 1], x[j]
                swapped = True
    return passes


@vividc.kernel("void(int32[::1])")
def shell_sort(x):
    n = len(x)
    gap = n >> 1
    while gap > 0:
        for i in range(gap, n):
            value = x[i]
            j = i
            while j >= gap and x[j - gap] > value:
                x[j] = x[j - gap]
                j -= gap
            x[j] = value
        gap >>= 1


@numba.njit
def sift_down(x, root, end):
    """Lets x[root] sink until no child below `end` is larger."""
    while True:
        child = 2 * root + 1
        if child >= end:
            return
        if child + 1 < end and x[child] < x[child + 1]:
            child += 1
        if x[root] >= x[child]:
            return
        x[root], x[child] = x[child], x[root]
        root = child


@vividc.kernel("void(int32[::1])")
def heap_sort(x):
    n = len(x)
    for root in range(n // 2 - 1, -1, -1):
        sift_down(x, root, n)
    for end in range(n - 1, 0, -1):
        x[0], x[end] = x[end], x[0]
        sift_down(x, 0, end)


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def binary_search(x, wanted, found):
    """Index of each wanted value in the sorted x, or -1."""
    for q in range(len(wanted)):
        low = 0
        high = len(x) - 1
        found[q] = -1
        while low <= high:
            middle = (low + high) // 2
            if x[middle] == wanted[q]:
                found[q] = middle
                break
            if x[middle] < wanted[q]:
                low = middle + 1
            else:
                high = middle - 1


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def merge(a, b, out):
    """Merges two sorted arrays."""
    i = 0
    j = 0
    k = 0
    while i < len(a) and j < len(b):
        if a[i] <= b[j]:
            out[k] = a[i]
            i += 1
        else:
            out[k] = b[j]
            j += 1
        k += 1
    while i < len(a):
        out[k] = a[i]
        i += 1
        k += 1
    while j < len(b):
        out[k] = b[j]
        j += 1
        k += 1


@vividc.kernel("int32(int32[::1], int32[::1])")
def exclusive_scan(x, out):
    """Sums of all before; returns the sum of all."""
    total = 0
    for i in range(len(x)):
        out[i] = total
        total += x[i]
    return total


@vividc.kernel("void(float32[::1])")
def running_max(x):
    for i in range(1, len(x)):
        x[i] = max(x[i], x[i - 1])


@vividc.kernel("int32(float32[::1])")
def argmax(x):
    """Index of the first largest value; -1 if there is none."""
    if len(x) == 0:
        return -1
    best = 0
    for i in range(1, len(x)):
        if x[i] > x[best]:
            best = i
    return best


@vividc.kernel("int32(int32[::1], int32[::1])")
def find_text(text, pattern):
    """Where the pattern first occurs, or -1."""
    for start in range(len(text) - len(pattern) + 1):
        for k in range(len(pattern)):
            if text[start + k] != pattern[k]:
                break
        else:
            return start
    return -1


@vividc.kernel("int32(int32[::1], int32[::1])")
def compact(x, out):
    """Keeps the values that are not zero, in order; returns how many."""
    n = 0
    for value in x:
        if value != 0:
            out[n] = value
            n += 1
    return n


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def counting_sort(x, counts, out):
    """Stable sort of small values; `counts` starts as zeros."""
    for i in range(len(x)):
        counts[x[i]] += 1
    for v in range(1, len(counts)):
        counts[v] += counts[v - 1]
    for i in range(len(x) - 1, -1, -1):
        counts[x[i]] -= 1
        out[counts[x[i]]] = x[i]


@vividc.kernel("int32(int32[::1], int32)")
def quickselect(x, k):
    """The k-th smallest value; reorders x (Hoare 1961)."""
    low = np.int32(0)
    high = np.int32(len(x) - 1)
    while low < high:
        pivot = x[np.int32(low + high) >> 1]
        i = low
        j = high
        while i <= j:
            while x[i] < pivot:
                i = np.int32(i + 1)
            while x[j] > pivot:
                j = np.int32(j - 1)
            if i <= j:
                x[i], x[j] = x[j], x[i]
                i = np.int32(i + 1)
                j = np.int32(j - 1)
        if k <= j:
            high = j
        elif k >= i:
            low = i
        else:
            break
    return x[k]


@vividc.kernel("bool(int32[::1], int32, int32[::1])")
def pair_with_sum(x, target, where):
    """Looks for two values with this sum, from the front, and stops at the first."""
    for i in range(len(x)):
        for j in range(i + 1, len(x)):
            if np.int32(x[i] + x[j]) == target:
                where[0] = i
                where[1] = j
                return True
    return False

"""Binning and sorting for 3D Gaussian Splatting: a stable radix sort by depth (Knuth, The Art of
Computer Programming 3, 5.2.5), then lists of screen tiles, first by row and then by column.

Each pass counts the digits of chunks, turns the counts into places, and scatters each chunk within
its scratchpad; the runs of equal digits then move to their places. Entries are rows of 3 words
(bounds, splat, bits of the depth) or 2 words (bounds, splat).
"""

import numpy as np

import vividc

# Masks that change nothing: they tell the compiler that an index is small and not negative.
SMALL = 8191
DIGIT = 63
BYTE = 255


@vividc.kernel("void(int32[::1], int32, int32, int32, int32[::1])")
def depth_counts(entries, n, least, shift, counts):
    """How often each digit of 6 bits occurs in the depths above the least."""
    for d in range(64):
        counts[d] = 0
    for i in range(n):
        o = (3 * i) & SMALL
        digit = ((entries[o + 2] - least) >> shift) & DIGIT
        counts[digit] += 1


@vividc.kernel("void(int32[::1], int32, int32, int32, int32[::1], int32[::1])")
def depth_scatter(entries, n, least, shift, counts, out):
    """Groups a chunk by digit, in order within a digit; `counts` are used up."""
    total = np.int32(0)
    for d in range(64):
        count = counts[d]
        counts[d] = total
        total = np.int32(total + count)
    for i in range(n):
        o = (3 * i) & SMALL
        bounds = entries[o]
        splat = entries[o + 1]
        depth = entries[o + 2]
        digit = ((depth - least) >> shift) & DIGIT
        place = counts[digit]
        counts[digit] = np.int32(place + 1)
        q = (3 * place) & SMALL
        out[q] = bounds
        out[q + 1] = splat
        out[q + 2] = depth


@vividc.kernel("void(int32[::1], int32, int32, int32[::1])")
def chunk_places(counts, chunks, digits, total):
    """Counts [chunks, digits] become places, in the order of digits and then of chunks, from
    total[0] on, which becomes the place of what comes next.
    """
    place = total[0]
    digit = np.int32(0)
    o = np.int32(0)
    for _ in range((chunks * digits) & SMALL):
        here = counts[o & SMALL]
        counts[o & SMALL] = place
        place = np.int32(place + here)
        o = np.int32(o + digits)
        if o >= chunks * digits:
            digit = np.int32(digit + 1)
            o = digit
    total[0] = place


@vividc.kernel("void(int32[::1], int32, int32, int32, int32[::1])")
def span_counts(entries, n, words, shift, counts):
    """How many entries of `words` words cover each value from one byte of bounds to the next."""
    for d in range(len(counts)):
        counts[d] = 0
    for i in range(n):
        bounds = entries[(words * i) & SMALL]
        for d in range((bounds >> shift) & BYTE, (bounds >> (shift + 8)) & BYTE):
            counts[d] += 1


@vividc.kernel("void(int32[::1], int32, int32, int32, int32[::1], int32[::1])")
def row_scatter(entries, n, low, high, counts, out):
    """An entry of two words for each row from `low` to `high` that an entry of three covers, by
    row; `counts` are those of all rows, and used up.
    """
    total = np.int32(0)
    for d in range(low & BYTE, high & BYTE):
        count = counts[d]
        counts[d] = total
        total = np.int32(total + count)
    for i in range(n):
        o = (3 * i) & SMALL
        bounds = entries[o]
        splat = entries[o + 1]
        for d in range(max(low, bounds & BYTE) & BYTE, min(high, (bounds >> 8) & BYTE) & BYTE):
            place = counts[d]
            counts[d] = np.int32(place + 1)
            q = (2 * place) & SMALL
            out[q] = bounds
            out[q + 1] = splat


@vividc.kernel("void(int32[::1], int32, int32, int32, int32[::1], int32[::1])")
def column_scatter(entries, n, low, high, counts, out):
    """The splat's number for each column from `low` to `high` that an entry of two words covers, by
    column; `counts` are those of all columns, and used up.
    """
    total = np.int32(0)
    for d in range(low & BYTE, high & BYTE):
        count = counts[d]
        counts[d] = total
        total = np.int32(total + count)
    for i in range(n):
        o = (2 * i) & SMALL
        bounds = entries[o]
        splat = entries[o + 1]
        first = max(low, (bounds >> 16) & BYTE) & BYTE
        for d in range(first, min(high, (bounds >> 24) & BYTE) & BYTE):
            place = counts[d]
            counts[d] = np.int32(place + 1)
            out[place & SMALL] = splat

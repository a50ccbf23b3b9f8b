"""The encoding of Instant-NGP (Mueller et al. 2022) for grids that fit no scratchpad: the cells of
samples, each once; table rows of their corners; trilinear interpolation of gathered rows.

A cell is a word, ten bits an axis.
"""

import numpy as np
from numba import njit

import vividc

HALF = np.float32(0.5)
NO_CELL = np.uint32(0xFFFFFFFF)
ONE = np.uint32(1)
TEN = np.uint32(10)
AXIS = np.uint32(1023)
PLACES = np.uint32(128)
PRIME_Y = np.uint32(2654435761)
PRIME_Z = np.uint32(805459861)


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], uint32[::1], uint32[::1], uint32[::1],"
    " uint32[:, ::1], uint32[::1])"
)
def find_cells(points, low, scales, seen, where, cells, slots, ends):
    """List the cells that the points lie in, level by level.

    `slots` says where in `cells` that of each level and point is; a level's are those from
    `ends[level]` up to `ends[level + 1]`. A cell that was met lately is not listed again: a
    direct-mapped cache of 128 remembers them in `seen` and `where`.
    """
    low_x = low[0]
    low_y = low[1]
    low_z = low[2]
    count = np.uint32(0)
    ends[0] = count
    for level in range(len(scales)):
        for place in range(len(seen)):
            seen[place] = NO_CELL
        scale = scales[level]
        for i in range(points.shape[0]):
            x = np.uint32(np.int32((points[i, 0] - low_x) * scale + HALF))
            y = np.uint32(np.int32((points[i, 1] - low_y) * scale + HALF))
            z = np.uint32(np.int32((points[i, 2] - low_z) * scale + HALF))
            cell = x | (y << TEN) | (z << np.uint32(20))
            place = (x ^ (y << np.uint32(2)) ^ (z << np.uint32(4))) & (PLACES - ONE)
            new = seen[place] != cell
            slot = count if new else where[place]
            seen[place] = cell
            where[place] = slot
            cells[count] = cell
            slots[level, i] = slot
            count += np.uint32(1) if new else np.uint32(0)
        ends[level + 1] = count


@njit
def put_rows(rows, c, row):
    """Rows of the eight corners; x changes fastest."""
    first = np.uint32(c << np.uint32(3))
    rows[first] = row[0]
    rows[first + np.uint32(1)] = row[1]
    rows[first + np.uint32(2)] = row[2]
    rows[first + np.uint32(3)] = row[3]
    rows[first + np.uint32(4)] = row[4]
    rows[first + np.uint32(5)] = row[5]
    rows[first + np.uint32(6)] = row[6]
    rows[first + np.uint32(7)] = row[7]


@njit
def wrapped(row, entries, offset):
    """A row that is at most once too large; what is negative is large without a sign."""
    row = np.uint32(row)
    return np.uint32(min(row, np.uint32(row - entries)) + offset)


@njit
def dense_corners(cell, resolution, entries, offset):
    """Rows x + y res + z res^2 of a cell's corners."""
    square = np.uint32(resolution * resolution)
    y = np.uint32((cell >> TEN) & AXIS)
    z = np.uint32(cell >> np.uint32(20))
    base = np.uint32((cell & AXIS) + y * resolution + z * square)
    above = np.uint32(base + resolution)
    behind = np.uint32(base + square)
    both = np.uint32(above + square)
    return (
        wrapped(base, entries, offset),
        wrapped(base + ONE, entries, offset),
        wrapped(above, entries, offset),
        wrapped(above + ONE, entries, offset),
        wrapped(behind, entries, offset),
        wrapped(behind + ONE, entries, offset),
        wrapped(both, entries, offset),
        wrapped(both + ONE, entries, offset),
    )


@njit
def hashed_corners(cell, mask, offset):
    """Rows of a cell's corners: x ^ y prime ^ z prime, modulo a power of two."""
    x = np.uint32(cell & AXIS)
    right = np.uint32(x + ONE)
    y = np.uint32(np.uint32((cell >> TEN) & AXIS) * PRIME_Y)
    z = np.uint32(np.uint32(cell >> np.uint32(20)) * PRIME_Z)
    above = np.uint32(y + PRIME_Y)
    behind = np.uint32(z + PRIME_Z)
    yz, az, yb, ab = y ^ z, above ^ z, y ^ behind, above ^ behind
    return (
        np.uint32(((x ^ yz) & mask) + offset),
        np.uint32(((right ^ yz) & mask) + offset),
        np.uint32(((x ^ az) & mask) + offset),
        np.uint32(((right ^ az) & mask) + offset),
        np.uint32(((x ^ yb) & mask) + offset),
        np.uint32(((right ^ yb) & mask) + offset),
        np.uint32(((x ^ ab) & mask) + offset),
        np.uint32(((right ^ ab) & mask) + offset),
    )


@vividc.kernel("void(uint32[::1], uint32[::1], uint32[:, ::1], int32, int32, uint32[::1])")
def corner_rows(cells, ends, grids, level, stop, rows):
    """Table rows of the corners of each cell of some levels.

    `cells` starts with those of `level`. A row of `grids` is: resolution (0 if hashed), entries
    (hashed: less one), first row.
    """
    first = ends[level]
    for k in range(level, stop):
        begin = np.uint32(ends[k] - first)
        end = np.uint32(ends[k + 1] - first)
        resolution = grids[k, 0]
        entries = grids[k, 1]
        offset = grids[k, 2]
        if resolution > np.uint32(0):
            for c in range(begin, end):
                put_rows(rows, np.uint32(c), dense_corners(cells[c], resolution, entries, offset))
        else:
            for c in range(begin, end):
                put_rows(rows, np.uint32(c), hashed_corners(cells[c], entries, offset))


@njit
def between(low, high, share):
    """Linear interpolation of both features."""
    return low[0] + (high[0] - low[0]) * share, low[1] + (high[1] - low[1]) * share


@njit
def corners(table, first):
    """Both features of two neighbours along x."""
    return (
        (table[first], table[first + np.uint32(1)]),
        (table[first + np.uint32(2)], table[first + np.uint32(3)]),
    )


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], float32[::1], uint32[:, ::1], int32, uint32,"
    " float32[:, :, ::1])"
)
def interpolate(points, low, scales, table, slots, level, first, out):
    """Two features of some levels from `level` on, trilinear.

    `table` has the 16 words of each cell from number `first` on; `out` is by block of 16 samples,
    feature and sample.
    """
    low_x = low[0]
    low_y = low[1]
    low_z = low[2]
    for k in range(slots.shape[0]):
        scale = scales[level + k]
        for i in range(points.shape[0]):
            x = (points[i, 0] - low_x) * scale + HALF
            y = (points[i, 1] - low_y) * scale + HALF
            z = (points[i, 2] - low_z) * scale + HALF
            x -= np.float32(np.int32(x))
            y -= np.float32(np.int32(y))
            z -= np.float32(np.int32(z))
            cell = np.uint32((slots[k, i] - first) << np.uint32(4))
            c0, c1 = corners(table, cell)
            c2, c3 = corners(table, cell + np.uint32(4))
            c4, c5 = corners(table, cell + np.uint32(8))
            c6, c7 = corners(table, cell + np.uint32(12))
            front = between(between(c0, c1, x), between(c2, c3, x), y)
            back = between(between(c4, c5, x), between(c6, c7, x), y)
            both = between(front, back, z)
            block = np.uint32(i) >> np.uint32(4)
            sample = np.uint32(i) & np.uint32(15)
            feature = np.uint32(k) << ONE
            out[block, feature, sample] = both[0]
            out[block, feature + ONE, sample] = both[1]

"""The encoding of Instant-NGP (Mueller et al. 2022) for grids that fit no scratchpad, two levels at
a time: the cells that samples lie in, each once, and the table rows of their corners; then, when
DMA has brought these, trilinear interpolation.

A cell is a word, ten bits an axis. Levels are told by scale, resolution (0: hashed), entries
(hashed: less one) and first row.
"""

import numpy as np
from numba import njit

import vividc
from vividc import lang

HALF = np.float32(0.5)
NO_CELL = np.uint32(0xFFFFFFFF)
ONE = np.uint32(1)
TEN = np.uint32(10)
AXIS = np.uint32(1023)
SPREAD = np.uint32(2654435769)
NOT_PLACES = np.uint32(25)
"""Shift that leaves the upper seven bits of a product: one of 128 places."""
PRIME_Y = np.uint32(2654435761)
PRIME_Z = np.uint32(805459861)
LOW = np.uint32(0xFFFF)
SIXTEEN = np.uint32(16)
HIGH = np.uint32(0xFFFF0000)
ZERO = np.float32(0)
UNIT = np.float32(1)
FIRST = np.uint32(8)
"""Word of `rows` from which the rows lie that were asked for."""


@njit
def put_rows(rows, c, row):
    """Rows of the eight corners of cell c, behind the word that says how many rows there are; x
    changes fastest.
    """
    first = np.uint32(np.uint32(c << np.uint32(3)) + ONE)
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


@njit
def level_of(low, scale):
    """Where points lie in a level, in cells from its corner: what they are multiplied by, and what
    is added then.
    """
    return scale, HALF - low[0] * scale, HALF - low[1] * scale, HALF - low[2] * scale


@njit
def cell_of(x, y, z, level):
    """The cell that a point is in, and its place among those that are remembered."""
    i = np.uint32(np.int32(x * level[0] + level[1]))
    j = np.uint32(np.int32(y * level[0] + level[2]))
    k = np.uint32(np.int32(z * level[0] + level[3]))
    cell = np.uint32(i | (j << TEN) | (k << np.uint32(20)))
    return cell, np.uint32(cell * SPREAD) >> NOT_PLACES


@njit
def list_cells(points, level, other_level, seen, where, other_seen, other_where, cells, slots):
    """List the cells of two levels, those of the second in the second half of `cells`; returns how
    many of each. `slots` says which are a point's: 16 bits each.

    A cell that was met lately is not listed again: direct-mapped caches of 128 remember them in
    `seen` and `where`. The two levels' do not wait for each other.
    """
    for place in range(64):  # four words a cycle, each in another bank
        seen[2 * place] = NO_CELL
        seen[2 * place + 1] = NO_CELL
        other_seen[2 * place] = NO_CELL
        other_seen[2 * place + 1] = NO_CELL
    second = np.uint32(points.shape[0])
    count = np.uint32(0)
    other_count = np.uint32(0)
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        cell, place = cell_of(x, y, z, level)
        new = seen[place] != cell
        slot = count if new else where[place]
        seen[place] = cell
        where[place] = slot
        cells[count] = cell
        count += ONE if new else np.uint32(0)
        cell, place = cell_of(x, y, z, other_level)
        new = other_seen[place] != cell
        other = other_count if new else other_where[place]
        other_seen[place] = cell
        other_where[place] = other
        cells[second + other_count] = cell
        other_count += ONE if new else np.uint32(0)
        slots[i] = slot | (other << SIXTEEN)
    return count, other_count


@njit
def ask_for_rows(points, counts, grid, other_grid, cells, slots, rows, room):
    """Ask for the rows of the cells' corners, or for none if there are more cells than room; behind
    the points' slots lie the number of the first level's cells, and of all.
    """
    total = counts[0] + counts[1]
    fits = total <= np.uint32(room)
    samples = np.uint32(points.shape[0])
    slots[samples] = counts[0]
    slots[samples + ONE] = total
    rows[0] = np.uint32(total << np.uint32(3)) if fits else np.uint32(0)
    for k in range(2):
        resolution = other_grid[0] if k else grid[0]
        entries = other_grid[1] if k else grid[1]
        offset = other_grid[2] if k else grid[2]
        begin = counts[0] if k else np.uint32(0)
        end = counts[1] if k else counts[0]
        end = end if fits else np.uint32(0)
        source = samples if k else np.uint32(0)
        if resolution > np.uint32(0):
            for c in range(end):
                at = np.uint32(c)
                corners = dense_corners(cells[source + at], resolution, entries, offset)
                put_rows(rows, begin + at, corners)
        else:
            for c in range(end):
                at = np.uint32(c)
                put_rows(rows, begin + at, hashed_corners(cells[source + at], entries, offset))


@njit
def within(x, y, z, level):
    """Where a point lies in its cell."""
    x = x * level[0] + level[1]
    y = y * level[0] + level[2]
    z = z * level[0] + level[3]
    return x - np.float32(np.int32(x)), y - np.float32(np.int32(y)), z - np.float32(np.int32(z))


@njit
def between(low, high, share):
    """Linear interpolation of both features."""
    return low[0] + (high[0] - low[0]) * share, low[1] + (high[1] - low[1]) * share


@njit
def blended(c0, c1, c2, c3, c4, c5, c6, c7, at):
    """Both features at a place in a cell, from those of its corners."""
    front = between(between(c0, c1, at[0]), between(c2, c3, at[0]), at[1])
    back = between(between(c4, c5, at[0]), between(c6, c7, at[0]), at[1])
    return between(front, back, at[2])


@njit
def pair(rows, at):
    """Both features of a row of float32."""
    return lang.bitcast_f32(rows[at]), lang.bitcast_f32(rows[at + ONE])


@njit
def from_pairs(rows, first, at):
    """Both features at a place in the cell whose rows of two words begin at `first`."""
    return blended(
        pair(rows, first),
        pair(rows, first + np.uint32(2)),
        pair(rows, first + np.uint32(4)),
        pair(rows, first + np.uint32(6)),
        pair(rows, first + np.uint32(8)),
        pair(rows, first + np.uint32(10)),
        pair(rows, first + np.uint32(12)),
        pair(rows, first + np.uint32(14)),
        at,
    )


@njit
def pair_corners(rows, total):
    """Rows of a word hold both features of a corner; from here on a word holds a feature of two
    corners, the right one in the upper half.
    """
    for c in range(total):
        first = np.uint32((np.uint32(c) << np.uint32(3)) + FIRST)
        for side in range(4):
            at = np.uint32(first + np.uint32(2 * side))
            left, right = rows[at], rows[at + ONE]
            rows[at] = (left & LOW) | (right << SIXTEEN)
            rows[at + ONE] = (left >> SIXTEEN) | (right & HIGH)


@njit
def blended_pairs(rows, first, at):
    """Both features at a place in the cell whose `pair_corners` begin at `first`: one operation
    adds two corners with their shares, which are float16.
    """
    x, y, z = at
    right_above = x * y
    left_above = y - right_above
    above = lang.pack_fp16(left_above, right_above)
    below = lang.pack_fp16((UNIT - x) - left_above, x - right_above)
    two, four, six = np.uint32(2), np.uint32(4), np.uint32(6)
    front = face(rows[first], rows[first + two], below, above)
    back = face(rows[first + four], rows[first + six], below, above)
    other_front = face(rows[first + ONE], rows[first + np.uint32(3)], below, above)
    other_back = face(rows[first + np.uint32(5)], rows[first + np.uint32(7)], below, above)
    return front + (back - front) * z, other_front + (other_back - other_front) * z


@njit
def face(lower, upper, below, above):
    """A feature in a face of a cell, of its corners below and above."""
    return lang.dot_fp16(upper, above, lang.dot_fp16(lower, below, ZERO))


@vividc.kernel(
    "int32(int32, float32[:, ::1], float32, float32, float32, float32, float32, uint32, uint32,"
    " uint32, uint32, uint32, uint32, int32, uint32[::1], uint32[::1], uint32[::1], uint32[::1],"
    " uint32[::1], uint32[::1], uint32[::1], float32[:, :, ::1])"
)
def two_levels(
    phase, points, low_x, low_y, low_z, scale, scale_1, resolution, entries, offset,
    resolution_1, entries_1, offset_1, room, seen, where, seen_1, where_1, cells, slots, rows, out,
):  # fmt: skip
    """Two features of each of two levels, by block of 16 samples, feature and sample. Returns how
    many cells the points lie in: if there are more than `room`, nothing was computed.
    """
    low = low_x, low_y, low_z
    level, level_1 = level_of(low, scale), level_of(low, scale_1)
    if phase == 0:
        counts = list_cells(points, level, level_1, seen, where, seen_1, where_1, cells, slots)
        grid, grid_1 = (resolution, entries, offset), (resolution_1, entries_1, offset_1)
        ask_for_rows(points, counts, grid, grid_1, cells, slots, rows, room)
        return np.int32(0)
    samples = np.uint32(points.shape[0])
    second = np.uint32(FIRST + (slots[samples] << np.uint32(4)))
    total = np.int32(slots[samples + ONE])
    if total > room:
        return total
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        first = np.uint32(((slots[i] & LOW) << np.uint32(4)) + FIRST)
        other = np.uint32(((slots[i] >> SIXTEEN) << np.uint32(4)) + second)
        a = from_pairs(rows, first, within(x, y, z, level))
        b = from_pairs(rows, other, within(x, y, z, level_1))
        block = np.uint32(i) >> np.uint32(4)
        sample = np.uint32(i) & np.uint32(15)
        out[block, 0, sample] = a[0]
        out[block, 1, sample] = a[1]
        out[block, 2, sample] = b[0]
        out[block, 3, sample] = b[1]
    return total


@vividc.kernel(
    "int32(int32, float32[:, ::1], float32, float32, float32, float32, float32, uint32, uint32,"
    " uint32, uint32, uint32, uint32, int32, uint32[::1], uint32[::1], uint32[::1], uint32[::1],"
    " uint32[::1], uint32[::1], uint32[::1], uint32[::1])"
)
def two_levels_fp8(
    phase, points, low_x, low_y, low_z, scale, scale_1, resolution, entries, offset,
    resolution_1, entries_1, offset_1, room, seen, where, seen_1, where_1, cells, slots, rows, out,
):  # fmt: skip
    """As `two_levels`, of rows of two float16; the four features are float8, in a word."""
    low = low_x, low_y, low_z
    level, level_1 = level_of(low, scale), level_of(low, scale_1)
    if phase == 0:
        counts = list_cells(points, level, level_1, seen, where, seen_1, where_1, cells, slots)
        grid, grid_1 = (resolution, entries, offset), (resolution_1, entries_1, offset_1)
        ask_for_rows(points, counts, grid, grid_1, cells, slots, rows, room)
        return np.int32(0)
    samples = np.uint32(points.shape[0])
    second = np.uint32(FIRST + (slots[samples] << np.uint32(3)))
    total = np.int32(slots[samples + ONE])
    if total > room:
        return total
    pair_corners(rows, total)
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        first = np.uint32(((slots[i] & LOW) << np.uint32(3)) + FIRST)
        other = np.uint32(((slots[i] >> SIXTEEN) << np.uint32(3)) + second)
        a = blended_pairs(rows, first, within(x, y, z, level))
        b = blended_pairs(rows, other, within(x, y, z, level_1))
        out[i] = lang.pack_fp8(a[0], a[1], b[0], b[1])
    return total

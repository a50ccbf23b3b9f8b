"""Plane and line factors of TensoRF (Chen et al. 2022) for planes that fit no scratchpad: the cells
of samples, each once; when DMA has brought their rows, products of planes and resident lines, 16
channels at a time; the inputs of the colour network.

A network's blocks are of 16 samples, [block, feature, sample].
"""

import math

import numpy as np
from numba import njit

import vividc
from vividc import lang

ONE = np.uint32(1)
TWO_BITS = np.uint32(2)
PLACES = np.uint32(64)
NO_CELL = np.uint32(0xFFFFFFFF)
FIRST = np.uint32(8)
"""Word of `rows` from which the rows lie that were asked for."""
UPPER = np.uint32(0x3C000000)
"""0 and 1 as float16: the products with a word of finite numbers add up to the upper one."""
UNIT = np.float32(1.0)
TWO = np.float32(2.0)
LARGEST = np.float32(80.0)
LARGE = np.float32(20.0)
LARGEST_ANGLE = np.float32(65536.0)
TURNS = np.float32(1 / (2 * math.pi))
NEAREST = np.float32(1.5 * 2**23)
"""Added to a float32 below 2^22 and subtracted again, it leaves the nearest integer."""
S1, S3, S5, S7, S9 = (
    np.float32((-1) ** (n // 2) * math.pi**n / math.factorial(n)) for n in (1, 3, 5, 7, 9)
)
C2, C4, C6, C8 = (
    np.float32((-1) ** (n // 2) * math.pi**n / math.factorial(n)) for n in (2, 4, 6, 8)
)
ZERO = np.float32(0)


@njit
def node(place, last):
    """The node below a place along an axis, and not the last one."""
    return min(np.int32(place), last)


@njit
def ask_for_cells(points, low, scale, last, axes, room, seen, where, slots, rows, bits):
    """Ask for the rows, four each, of the plane cells that points lie in, or for none if there are
    more cells than room. Of rows that hold the next column's numbers, too, there are two: `bits`
    tells.

    `slots` says which cell is a point's, and behind the points' how many there are. A direct-mapped
    cache of 64 remembers cells in `seen` and `where`.
    """
    for place in range(64):
        seen[place] = NO_CELL
    columns = np.uint32(last[0] + np.int32(2))
    count = np.uint32(0)
    for i in range(points.shape[0]):
        column = np.uint32(node((points[i, axes[0]] - low[0]) * scale[0], last[0]))
        row = np.uint32(node((points[i, axes[1]] - low[1]) * scale[1], last[1]))
        cell = np.uint32(row * columns + column)
        place = (column ^ (row << np.uint32(3))) & (PLACES - ONE)
        new = seen[place] != cell
        slot = count if new else where[place]
        seen[place] = cell
        where[place] = slot
        first = np.uint32((min(count, np.uint32(room)) << bits) + ONE)
        rows[first] = cell
        if bits == ONE:
            rows[first + ONE] = np.uint32(cell + columns)
        else:
            rows[first + ONE] = np.uint32(cell + ONE)
            rows[first + np.uint32(2)] = np.uint32(cell + columns)
            rows[first + np.uint32(3)] = np.uint32(cell + columns + ONE)
        slots[i] = slot
        count += ONE if new else np.uint32(0)
    slots[np.uint32(points.shape[0])] = count
    rows[0] = np.uint32(count << bits) if count <= np.uint32(room) else np.uint32(0)


@njit
def within(points, i, low, scale, last, axes):
    """Where point i lies in its cell and between its nodes of the line, and the first of these."""
    x = (points[i, axes[0]] - low[0]) * scale[0]
    y = (points[i, axes[1]] - low[1]) * scale[1]
    z = (points[i, axes[2]] - low[2]) * scale[2]
    line_node = node(z, last[2])
    x -= np.float32(node(x, last[0]))
    y -= np.float32(node(y, last[1]))
    z -= np.float32(line_node)
    return (x, y, z), np.uint32(line_node)


@njit
def product(above, right, below, across, here, there, at):
    """A channel of the plane, bilinear, times that of the line, linear."""
    above += (right - above) * at[0]
    below += (across - below) * at[0]
    here += (there - here) * at[2]
    return (above + (below - above) * at[1]) * here


@njit
def channel(rows, line, cell, start, at):
    """A channel of rows of 16 float32, from its words in the first of the four and of the two."""
    return product(
        lang.bitcast_f32(rows[cell]),
        lang.bitcast_f32(rows[cell + np.uint32(16)]),
        lang.bitcast_f32(rows[cell + np.uint32(32)]),
        lang.bitcast_f32(rows[cell + np.uint32(48)]),
        lang.bitcast_f32(line[start]),
        lang.bitcast_f32(line[start + np.uint32(16)]),
        at,
    )


@njit
def eight_channels(rows, line, cell, start, at):
    """Eight neighbouring `channel`s."""
    return (
        channel(rows, line, cell, start, at),
        channel(rows, line, cell + ONE, start + ONE, at),
        channel(rows, line, cell + np.uint32(2), start + np.uint32(2), at),
        channel(rows, line, cell + np.uint32(3), start + np.uint32(3), at),
        channel(rows, line, cell + np.uint32(4), start + np.uint32(4), at),
        channel(rows, line, cell + np.uint32(5), start + np.uint32(5), at),
        channel(rows, line, cell + np.uint32(6), start + np.uint32(6), at),
        channel(rows, line, cell + np.uint32(7), start + np.uint32(7), at),
    )


@njit
def halves(word):
    """Two float16 in a word."""
    first = np.float32(lang.fp16_from_bits(word))
    return first, lang.dot_fp16(word, UPPER, np.float32(0))


@njit
def weights_of(at):
    """Shares of a cell's corners and of a line's nodes, in words of float16: of both columns in the
    upper row and in the lower one; of the node and of the next one in the lower and the upper half.
    """
    x, y, z = at
    left, above, here = UNIT - x, UNIT - y, UNIT - z
    return (
        lang.pack_fp16(left * above, x * above),
        lang.pack_fp16(left * y, x * y),
        lang.pack_fp16(here, ZERO),
        lang.pack_fp16(z, ZERO),
        lang.pack_fp16(ZERO, here),
        lang.pack_fp16(ZERO, z),
    )


@njit
def two_channels(rows, line, cell, start, w):
    """Two channels of the plane and of the line; a word of the plane holds a channel in both
    columns, one of the line two channels.
    """
    above, below = rows[cell], rows[cell + np.uint32(16)]
    one = lang.dot_fp16(below, w[1], lang.dot_fp16(above, w[0], ZERO))
    above, below = rows[cell + ONE], rows[cell + np.uint32(17)]
    two = lang.dot_fp16(below, w[1], lang.dot_fp16(above, w[0], ZERO))
    here, there = line[start], line[start + np.uint32(8)]
    first = lang.dot_fp16(there, w[3], lang.dot_fp16(here, w[2], ZERO))
    second = lang.dot_fp16(there, w[5], lang.dot_fp16(here, w[4], ZERO))
    return one, two, first, second


@njit
def four_products(rows, line, cell, start, w):
    """Four channels of plane times line, as float8."""
    a, b, la, lb = two_channels(rows, line, cell, start, w)
    c, d, lc, ld = two_channels(
        rows, line, np.uint32(cell + np.uint32(2)), np.uint32(start + ONE), w
    )
    return lang.pack_fp8(a * la, b * lb, c * lc, d * ld)


@njit
def four_sum(rows, line, cell, start, w):
    """Sum of four channels of plane times line."""
    a, b, la, lb = two_channels(rows, line, cell, start, w)
    c, d, lc, ld = two_channels(
        rows, line, np.uint32(cell + np.uint32(2)), np.uint32(start + ONE), w
    )
    return a * la + b * lb + (c * lc + d * ld)


@vividc.kernel(
    "int32(int32, float32[:, ::1], float32, float32, float32, float32, float32, float32, int32,"
    " int32, int32, int32, int32, int32, int32, uint32[::1], uint32[::1], uint32[::1],"
    " uint32[::1], uint32[::1], float32[:, :, ::1])"
)
def factor_products(
    phase, points, low_x, low_y, low_z, scale_x, scale_y, scale_z, last_x, last_y, last_z,
    axis_x, axis_y, axis_z, room, line, seen, where, slots, rows, out,
):  # fmt: skip
    """16 channels of plane times line, by block of 16 samples, channel and sample.

    `axes` are the plane's columns and rows, and the line's. Returns how many cells the points lie
    in: if there are more than `room`, nothing was computed.
    """
    low, scale, last = (low_x, low_y, low_z), (scale_x, scale_y, scale_z), (last_x, last_y, last_z)
    axes = axis_x, axis_y, axis_z
    if phase == 0:
        ask_for_cells(points, low, scale, last, axes, room, seen, where, slots, rows, TWO_BITS)
        return np.int32(0)
    total = np.int32(slots[np.uint32(points.shape[0])])
    samples = points.shape[0] if total <= room else 0
    for half in range(2):
        for i in range(samples):
            at, start = within(points, i, low, scale, last, axes)
            cell = np.uint32((slots[i] << np.uint32(6)) + np.uint32(8 * half) + FIRST)
            start = np.uint32((start << np.uint32(4)) + np.uint32(8 * half))
            c = eight_channels(rows, line, cell, start, at)
            block = np.uint32(i) >> np.uint32(4)
            sample = np.uint32(i) & np.uint32(15)
            out[block, 8 * half, sample] = c[0]
            out[block, 8 * half + 1, sample] = c[1]
            out[block, 8 * half + 2, sample] = c[2]
            out[block, 8 * half + 3, sample] = c[3]
            out[block, 8 * half + 4, sample] = c[4]
            out[block, 8 * half + 5, sample] = c[5]
            out[block, 8 * half + 6, sample] = c[6]
            out[block, 8 * half + 7, sample] = c[7]
    return total


@vividc.kernel(
    "int32(int32, float32[:, ::1], float32, float32, float32, float32, float32, float32, int32,"
    " int32, int32, int32, int32, int32, int32, uint32[::1], uint32[::1], uint32[::1],"
    " uint32[::1], uint32[::1], uint32[:, :, ::1])"
)
def factor_products_fp8(
    phase, points, low_x, low_y, low_z, scale_x, scale_y, scale_z, last_x, last_y, last_z,
    axis_x, axis_y, axis_z, room, line, seen, where, slots, rows, out,
):  # fmt: skip
    """`factor_products` of float16, as float8, four channels to a word. A row of the plane is 16
    words, of a channel in its own and the next column; one of the line eight, of two channels.
    """
    low, scale, last = (low_x, low_y, low_z), (scale_x, scale_y, scale_z), (last_x, last_y, last_z)
    axes = axis_x, axis_y, axis_z
    if phase == 0:
        ask_for_cells(points, low, scale, last, axes, room, seen, where, slots, rows, ONE)
        return np.int32(0)
    total = np.int32(slots[np.uint32(points.shape[0])])
    for i in range(points.shape[0] if total <= room else 0):
        at, start = within(points, i, low, scale, last, axes)
        w = weights_of(at)
        cell = np.uint32((slots[i] << np.uint32(5)) + FIRST)
        start = np.uint32(start << np.uint32(3))
        block = np.uint32(i) >> np.uint32(4)
        sample = np.uint32(i) & np.uint32(15)
        out[block, 0, sample] = four_products(rows, line, cell, start, w)
        cell, start = np.uint32(cell + np.uint32(4)), np.uint32(start + np.uint32(2))
        out[block, 1, sample] = four_products(rows, line, cell, start, w)
        cell, start = np.uint32(cell + np.uint32(4)), np.uint32(start + np.uint32(2))
        out[block, 2, sample] = four_products(rows, line, cell, start, w)
        cell, start = np.uint32(cell + np.uint32(4)), np.uint32(start + np.uint32(2))
        out[block, 3, sample] = four_products(rows, line, cell, start, w)
    return total


@vividc.kernel(
    "int32(int32, float32[:, ::1], float32, float32, float32, float32, float32, float32, int32,"
    " int32, int32, int32, int32, int32, int32, uint32[::1], uint32[::1], uint32[::1],"
    " uint32[::1], uint32[::1], float32[::1])"
)
def factor_sums(
    phase, points, low_x, low_y, low_z, scale_x, scale_y, scale_z, last_x, last_y, last_z,
    axis_x, axis_y, axis_z, room, line, seen, where, slots, rows, out,
):  # fmt: skip
    """Sums over the 16 channels of `factor_products`."""
    low, scale, last = (low_x, low_y, low_z), (scale_x, scale_y, scale_z), (last_x, last_y, last_z)
    axes = axis_x, axis_y, axis_z
    if phase == 0:
        ask_for_cells(points, low, scale, last, axes, room, seen, where, slots, rows, TWO_BITS)
        return np.int32(0)
    total = np.int32(slots[np.uint32(points.shape[0])])
    samples = points.shape[0] if total <= room else 0
    for half in range(2):
        for i in range(samples):
            at, start = within(points, i, low, scale, last, axes)
            cell = np.uint32((slots[i] << np.uint32(6)) + np.uint32(8 * half) + FIRST)
            start = np.uint32((start << np.uint32(4)) + np.uint32(8 * half))
            c = eight_channels(rows, line, cell, start, at)
            before = out[i] if half else np.float32(0)
            first_four = (c[0] + c[1]) + (c[2] + c[3])
            out[i] = before + (first_four + ((c[4] + c[5]) + (c[6] + c[7])))
    return total


@vividc.kernel(
    "int32(int32, float32[:, ::1], float32, float32, float32, float32, float32, float32, int32,"
    " int32, int32, int32, int32, int32, int32, uint32[::1], uint32[::1], uint32[::1],"
    " uint32[::1], uint32[::1], float32[::1])"
)
def factor_sums_fp16(
    phase, points, low_x, low_y, low_z, scale_x, scale_y, scale_z, last_x, last_y, last_z,
    axis_x, axis_y, axis_z, room, line, seen, where, slots, rows, out,
):  # fmt: skip
    """As `factor_sums`, of float16 as in `factor_products_fp8`."""
    low, scale, last = (low_x, low_y, low_z), (scale_x, scale_y, scale_z), (last_x, last_y, last_z)
    axes = axis_x, axis_y, axis_z
    if phase == 0:
        ask_for_cells(points, low, scale, last, axes, room, seen, where, slots, rows, ONE)
        return np.int32(0)
    total = np.int32(slots[np.uint32(points.shape[0])])
    for i in range(points.shape[0] if total <= room else 0):
        at, start = within(points, i, low, scale, last, axes)
        w = weights_of(at)
        cell = np.uint32((slots[i] << np.uint32(5)) + FIRST)
        start = np.uint32(start << np.uint32(3))
        a = four_sum(rows, line, cell, start, w)
        b = four_sum(rows, line, np.uint32(cell + np.uint32(4)), np.uint32(start + np.uint32(2)), w)
        c = four_sum(rows, line, np.uint32(cell + np.uint32(8)), np.uint32(start + np.uint32(4)), w)
        d = four_sum(
            rows, line, np.uint32(cell + np.uint32(12)), np.uint32(start + np.uint32(6)), w
        )
        out[i] = (a + b) + (c + d)
    return total


@njit
def word(a, b, c, d, scale):
    """Four numbers, times `scale`, as float8."""
    return lang.pack_fp8(a * scale, b * scale, c * scale, d * scale)


@njit
def waves(value):
    """Sine of an angle and of its double, then their cosines."""
    angle = min(max(value, -LARGEST_ANGLE), LARGEST_ANGLE)
    sine = math.sin(angle)
    cosine = math.cos(angle)
    return sine, TWO * sine * cosine, cosine, UNIT - TWO * sine * sine


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1], float32[:, :, ::1])")
def colour_inputs(features, directions, out):
    """27 features, the direction, sine and cosine of the features and of their doubles, channel by
    channel, and those of the direction.

    Angles are clamped to 2**16 radians, where a float32 has no phase left worth encoding.
    """
    for block in range(out.shape[0]):
        for sample in range(16):
            for k in range(27):
                value = features[block, k, sample]
                out[block, k, sample] = value
                terms = waves(value)
                out[block, 30 + 2 * k, sample] = terms[0]
                out[block, 31 + 2 * k, sample] = terms[1]
                out[block, 84 + 2 * k, sample] = terms[2]
                out[block, 85 + 2 * k, sample] = terms[3]
    for block in range(out.shape[0]):
        for sample in range(16):
            for axis in range(3):
                value = directions[block, sample, axis]
                out[block, 27 + axis, sample] = value
                terms = waves(value)
                out[block, 138 + 2 * axis, sample] = terms[0]
                out[block, 139 + 2 * axis, sample] = terms[1]
                out[block, 144 + 2 * axis, sample] = terms[2]
                out[block, 145 + 2 * axis, sample] = terms[3]


@njit
def waves_fp8(value):
    """`waves` in as few operations as float8 needs: from half the angle in turns, with errors below
    2^-12 for angles of some tens of turns.
    """
    angle = min(max(value, -LARGEST_ANGLE), LARGEST_ANGLE)
    whole = (angle * TURNS + NEAREST) - NEAREST
    r = angle * TURNS - whole
    y = r * r
    sine = r * (S1 + y * (S3 + y * (S5 + y * (S7 + y * S9))))
    cosine = UNIT + y * (C2 + y * (C4 + y * (C6 + y * C8)))
    twice = sine + sine
    sine, cosine = twice * cosine, UNIT - twice * sine
    twice = sine + sine
    return sine, twice * cosine, cosine, UNIT - twice * sine


@njit
def put_numbers(features, directions, scale, out):
    """The features and the direction, and two lanes that are not for the network."""
    for block in range(out.shape[0]):
        for k in range(6):
            for sample in range(16):
                a, b = halves(features[block, 2 * k, sample])
                c, d = halves(features[block, 2 * k + 1, sample])
                out[block, 30 + k, sample] = word(a, b, c, d, scale)
    for block in range(out.shape[0]):
        for sample in range(16):
            a, b = halves(features[block, 12, sample])
            c = np.float32(lang.fp16_from_bits(features[block, 13, sample]))
            x = directions[block, sample, 0]
            y = directions[block, sample, 1]
            z = directions[block, sample, 2]
            out[block, 36, sample] = word(a, b, c, x, scale)
            out[block, 37, sample] = word(y, z, ZERO, ZERO, scale)


@vividc.kernel("void(uint32[:, :, ::1], float32[:, :, ::1], float32, uint32[:, :, ::1])")
def colour_inputs_fp8(features, directions, scale, out):
    """`colour_inputs` of words of two float16, times `scale`, four to a word: the waves of one
    feature or axis, then the features and the direction.
    """
    for block in range(out.shape[0]):
        for k in range(14):
            for sample in range(16):
                # Behind the last feature is a 0, whose word the first axis takes below.
                a, b = halves(features[block, k, sample])
                t = waves_fp8(a)
                out[block, 2 * k, sample] = word(t[0], t[1], t[2], t[3], scale)
                t = waves_fp8(b)
                out[block, 2 * k + 1, sample] = word(t[0], t[1], t[2], t[3], scale)
    for block in range(out.shape[0]):
        for axis in range(3):
            for sample in range(16):
                t = waves_fp8(directions[block, sample, axis])
                out[block, 27 + axis, sample] = word(t[0], t[1], t[2], t[3], scale)
    put_numbers(features, directions, scale, out)

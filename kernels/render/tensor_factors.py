"""Plane and line factors of TensoRF (Chen et al. 2022) for planes that fit no scratchpad: the cells
of samples, each once; products of gathered planes and resident lines, 16 channels at a time; the
inputs of the colour network.

A network's blocks are of 16 samples, [block, feature, sample].
"""

import math

import numpy as np
from numba import njit

import vividc
from vividc import lang

ONE = np.uint32(1)
TEN = np.uint32(10)
PLACES = np.uint32(64)
NO_CELL = np.uint32(0xFFFFFFFF)
UNIT = np.float32(1.0)
TWO = np.float32(2.0)
LARGEST = np.float32(80.0)
LARGE = np.float32(20.0)
LARGEST_ANGLE = np.float32(65536.0)
LAST_FEATURE = 26


@njit
def node(place, last):
    """The node below a place along an axis, and not the last one."""
    return min(np.int32(place), last)


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], int32[::1], int32[:, ::1], uint32[::1],"
    " uint32[::1], uint32[:, ::1], uint32[:, ::1], uint32[::1])"
)
def find_plane_cells(points, low, scales, nodes, axes, seen, where, rows, slots, counts):
    """List the rows, four each, of the plane cells that the points lie in.

    `axes[k]` are those along the columns and the rows of plane k; `slots` says which of its cells
    is a point's. A direct-mapped cache of 64 remembers cells in `seen` and `where`.
    """
    for k in range(axes.shape[0]):
        across = axes[k, 0]
        down = axes[k, 1]
        left = low[across]
        top = low[down]
        across_scale = scales[across]
        down_scale = scales[down]
        columns = np.uint32(nodes[across])
        last_column = np.int32(nodes[across] - 2)
        last_row = np.int32(nodes[down] - 2)
        for place in range(len(seen)):
            seen[place] = NO_CELL
        count = np.uint32(0)
        for i in range(points.shape[0]):
            column = np.uint32(node((points[i, across] - left) * across_scale, last_column))
            row = np.uint32(node((points[i, down] - top) * down_scale, last_row))
            cell = np.uint32(row * columns + column)
            place = (column ^ (row << np.uint32(3))) & (PLACES - ONE)
            new = seen[place] != cell
            slot = count if new else where[place]
            seen[place] = cell
            where[place] = slot
            first = np.uint32(count << np.uint32(2))
            rows[k, first] = cell
            rows[k, first + ONE] = np.uint32(cell + ONE)
            rows[k, first + np.uint32(2)] = np.uint32(cell + columns)
            rows[k, first + np.uint32(3)] = np.uint32(cell + columns + ONE)
            slots[k, i] = slot
            count += np.uint32(1) if new else np.uint32(0)
        counts[k] = count


@njit
def product(plane, cell, line, start, channel, across, down, along):
    """A channel of the plane, bilinear, times that of the line, linear."""
    at = np.uint32(cell + channel)
    above = plane[at]
    above += (plane[at + np.uint32(16)] - above) * across
    below = plane[at + np.uint32(32)]
    below += (plane[at + np.uint32(48)] - below) * across
    here = line[start + channel]
    here += (line[start + np.uint32(16) + channel] - here) * along
    return (above + (below - above) * down) * here


@njit
def along_axes(low, scales, nodes, axes):
    """Corner, scale and last node but one of the plane's columns and rows, and of the line."""
    across, down, along = axes[0], axes[1], axes[2]
    corner = low[across], low[down], low[along]
    scale = scales[across], scales[down], scales[along]
    last = np.int32(nodes[across] - 2), np.int32(nodes[down] - 2), np.int32(nodes[along] - 2)
    return corner, scale, last


@njit
def place(points, i, axes, grid):
    """Where point i lies in its cell and between its nodes of the line, and where those begin."""
    corner, scale, last = grid
    x = (points[i, axes[0]] - corner[0]) * scale[0]
    y = (points[i, axes[1]] - corner[1]) * scale[1]
    z = (points[i, axes[2]] - corner[2]) * scale[2]
    line_node = node(z, last[2])
    x -= np.float32(node(x, last[0]))
    y -= np.float32(node(y, last[1]))
    z -= np.float32(line_node)
    return x, y, z, np.uint32(np.uint32(line_node) << np.uint32(4))


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], int32[::1], int32[::1], float32[::1],"
    " float32[::1], uint32[::1], float32[:, :, ::1])"
)
def factor_products(points, low, scales, nodes, axes, line, plane, slots, out):
    """16 channels of plane times line; `axes` are the plane's columns and rows, and the line's."""
    grid = along_axes(low, scales, nodes, axes)
    for i in range(points.shape[0]):
        x, y, z, first = place(points, i, axes, grid)
        cell = np.uint32(slots[i] << np.uint32(6))
        block = np.uint32(i) >> np.uint32(4)
        sample = np.uint32(i) & np.uint32(15)
        for c in range(16):
            channel = np.uint32(c)
            out[block, channel, sample] = product(plane, cell, line, first, channel, x, y, z)


@njit
def word(a, b, c, d, scale):
    """Four numbers, times `scale`, as float8."""
    return lang.pack_fp8(a * scale, b * scale, c * scale, d * scale)


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], int32[::1], int32[::1], float32[::1],"
    " float32[::1], uint32[::1], float32, uint32[:, :, ::1])"
)
def factor_products_fp8(points, low, scales, nodes, axes, line, plane, slots, scale, out):
    """`factor_products` times `scale`, four channels to a word."""
    grid = along_axes(low, scales, nodes, axes)
    for i in range(points.shape[0]):
        x, y, z, first = place(points, i, axes, grid)
        cell = np.uint32(slots[i] << np.uint32(6))
        block = np.uint32(i) >> np.uint32(4)
        sample = np.uint32(i) & np.uint32(15)
        for k in range(4):
            channel = np.uint32(k) << np.uint32(2)
            a = product(plane, cell, line, first, channel, x, y, z)
            b = product(plane, cell, line, first, channel + ONE, x, y, z)
            c = product(plane, cell, line, first, channel + np.uint32(2), x, y, z)
            d = product(plane, cell, line, first, channel + np.uint32(3), x, y, z)
            out[block, k, sample] = word(a, b, c, d, scale)


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], int32[::1], int32[::1], float32[::1],"
    " float32[::1], uint32[::1], float32[::1])"
)
def factor_sums(points, low, scales, nodes, axes, line, plane, slots, out):
    """Sums over the 16 channels of `factor_products`."""
    grid = along_axes(low, scales, nodes, axes)
    for i in range(points.shape[0]):
        x, y, z, first = place(points, i, axes, grid)
        cell = np.uint32(slots[i] << np.uint32(6))
        total = np.float32(0)
        for c in range(16):
            total += product(plane, cell, line, first, np.uint32(c), x, y, z)
        out[i] = total


@vividc.kernel("void(float32[:, :, ::1], float32, float32, float32[:, ::1])")
def density(sums, shift, step, thickness):
    """Optical thickness of a step: log(1 + exp(x + shift)), which is x + shift where that is large.

    `sums` is by block of 16 samples, pair of factors and sample.
    """
    for block in range(thickness.shape[0]):
        for i in range(16):
            thickness[block, i] = shift
        for k in range(sums.shape[1]):
            for i in range(16):
                thickness[block, i] += sums[block, k, i]
    for block in range(thickness.shape[0]):
        for i in range(16):
            x = thickness[block, i]
            small = math.log1p(math.exp(min(x, LARGE)))
            thickness[block, i] = (x if x > LARGE else small) * step


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
def value_of(features, directions, block, sample, k):
    """Feature k, or behind the 27 features the direction, whose last coordinate repeats."""
    feature = features[block, min(k, LAST_FEATURE), sample]
    coordinate = directions[block, sample, min(max(k - LAST_FEATURE - 1, 0), 2)]
    return feature if k <= LAST_FEATURE else coordinate


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1], float32, uint32[:, :, ::1])")
def colour_inputs_fp8(features, directions, scale, out):
    """`colour_inputs` times `scale`, four to a word: the waves of one feature or axis, then the
    features and the direction. The last two lanes are not for the network.
    """
    for block in range(out.shape[0]):
        for k in range(30):
            for sample in range(16):
                t = waves(value_of(features, directions, block, sample, k))
                out[block, k, sample] = word(t[0], t[1], t[2], t[3], scale)
    for block in range(out.shape[0]):
        for k in range(8):
            for sample in range(16):
                a = value_of(features, directions, block, sample, 4 * k)
                b = value_of(features, directions, block, sample, 4 * k + 1)
                c = value_of(features, directions, block, sample, 4 * k + 2)
                d = value_of(features, directions, block, sample, 4 * k + 3)
                out[block, 30 + k, sample] = word(a, b, c, d, scale)

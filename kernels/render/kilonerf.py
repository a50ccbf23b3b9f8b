"""KiloNeRF (Reiser et al. 2021): samples find their network, are sorted by it, and run through it.

Layers take four samples and eight neurons at a time: 32 sums that do not wait for one another.
Unsigned places need no test for an index from the end.
"""

import math

import numba
import numpy as np
from numba import prange

import vividc

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
LARGEST = np.float32(80.0)
LOWEST = np.float32(-3.4e38)
HALF = np.float32(0.5)
HIGH = np.uint32(16)
PLACE = np.uint32(22)


@numba.njit
def in_cells(along, box, axis, count):
    """Where a coordinate is along its axis, in cells, and the cell it is in, one of `count`."""
    place = (along - box[axis]) * box[3 + axis]
    return place, np.int32(min(max(np.int32(place), 0), count - 1))


@numba.njit
def number_of(point, box, grid):
    """Number of the cell that a point is in, the last axis innermost."""
    _, x = in_cells(point[0], box, 0, grid[0])
    _, y = in_cells(point[1], box, 1, grid[1])
    _, z = in_cells(point[2], box, 2, grid[2])
    return (x * grid[1] + y) * grid[2] + z


@vividc.kernel("void(float32[:, ::1], float32[::1], int32[::1], int32[::1])")
def cell_numbers(points, box, grid, numbers):
    """Number of the cell of each point in a `grid` of cells. `box` is its lowest corner and cells
    a unit.
    """
    for i in prange(points.shape[0]):
        numbers[i] = number_of((points[i, 0], points[i, 1], points[i, 2]), box, grid)


@numba.njit
def ray_of(item):
    """The ray of a sample, among the block's."""
    return np.uint32((np.uint32(item) >> HIGH) & np.uint32(63))


@numba.njit
def point_of(item, directions, entries, geometry):
    """Place of a sample in the world, as `sample_points` in marching.py has it."""
    ray = ray_of(item)
    t = entries[ray] + (np.float32(item & 0xFFFF) + HALF) * geometry[14]
    return (
        geometry[0] + t * directions[ray, 0],
        geometry[1] + t * directions[ray, 1],
        geometry[2] + t * directions[ray, 2],
    )


@numba.njit
def counted(network, low, starts):
    """Count a sample in the place behind its network's in `starts`; returns that place and, << 16,
    how many were counted there before.
    """
    slot = np.uint32(min(max(network - low + 1, 0), np.int32(len(starts) - 1)))
    before = starts[slot]
    starts[slot] = before + 1
    return np.int32(slot) | (before << 16)


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], int32[::1], float32[::1], float32[::1], int32[::1],"
    " int32[::1], int32, int32, int32[::1], int32[::1], int32[::1], float32[:, ::1])"
)
def group_samples(
    directions, entries, items, geometry, box, grid, networks, known, low,
    chosen, starts, places, local,
):  # fmt: skip
    """Counting sort of the samples of a piece by network, those without one (-1) first; stable.

    Samples are `items` along a block's rays, as in marching.py. `local` gets their places in their
    networks' cells, -1 to 1, in the order of networks, and `places` where in it each sample is. The
    network of each of the `grid`'s cells is in `networks`; or that of each sample is `known`,
    in `chosen`.

    Only samples of the networks `low`, `low` + 1, ... are placed, as many networks as `starts` has
    elements but two. `starts[k]` is where network `low` + k starts, its last element nothing.
    `chosen` is room to work in.
    """
    last = np.int32(len(starts) - 1)
    for k in range(len(starts)):
        starts[k] = 0
    if known == 0:
        for i in range(len(items)):
            point = point_of(items[i], directions, entries, geometry)
            network = networks[np.uint32(number_of(point, box, grid))]
            chosen[i] = counted(network, low, starts)
    else:
        for i in range(len(items)):
            chosen[i] = counted(chosen[i], low, starts)
    total = np.int32(0)
    for k in range(len(starts)):
        total += starts[k]
        starts[k] = total
    for i in range(len(items)):
        slot = np.int32(chosen[i] & 0xFFFF)
        if slot > 0 and slot < last:
            x, y, z = point_of(items[i], directions, entries, geometry)
            place = np.uint32(starts[np.uint32(slot - 1)] + (chosen[i] >> 16))
            places[i] = np.int32(place)
            x, cell_x = in_cells(x, box, 0, grid[0])
            y, cell_y = in_cells(y, box, 1, grid[1])
            z, cell_z = in_cells(z, box, 2, grid[2])
            local[place, 0] = (x - np.float32(cell_x)) * TWO - ONE
            local[place, 1] = (y - np.float32(cell_y)) * TWO - ONE
            local[place, 2] = (z - np.float32(cell_z)) * TWO - ONE


@vividc.kernel(
    "void(int32[::1], int32[::1], int32[::1], int32, int32, int32[::1], int32[::1], int32[::1],"
    " int32[::1], int32[::1])"
)
def group_survivors(
    items, places, starts, first_ray, first_row, marks, kept_starts, kept_places, rows, rays
):
    """Those samples of a piece that survive in the order of networks that `group_samples` gave all.

    `items` has the place of each in the piece, << 22. `kept_starts` and `kept_places` are of them
    what `starts` and `places` are of all; `rows` are their places among all, counted from
    `first_row`, and `rays` their rays, from `first_ray`, in the order of networks. `marks` is room
    to work in: an element more than there are samples.
    """
    for place in range(len(marks)):
        marks[place] = 0
    for survivor in range(len(items)):
        sample = np.uint32(items[survivor]) >> PLACE
        marks[np.uint32(places[sample])] = np.int32(survivor + 1)
    found = np.int32(0)
    for place in range(len(marks)):
        mark = marks[place]
        marks[place] = found
        if mark != 0:
            survivor = np.uint32(mark - 1)
            kept_places[survivor] = found
            rows[np.uint32(found)] = np.int32(first_row + place)
            rays[np.uint32(found)] = first_ray + np.int32(ray_of(items[survivor]))
            found = np.int32(found + 1)
    for k in range(len(starts)):
        kept_starts[k] = marks[np.uint32(starts[k])]


@numba.njit
def doubled(sine, cosine):
    """Sine and cosine of twice the angle."""
    twice = sine + sine
    return twice * cosine, ONE - twice * sine


@vividc.kernel("void(float32[::1], float32[:, ::1])")
def encode_position(values, out):
    """x, sin x, cos x, sin 2x, cos 2x, ... of values within -2 to 2 at ten frequencies.

    The terms of Mildenhall et al. (2020), one coordinate after the other. Sine and cosine are
    computed at two of the frequencies and doubled in between; the error, which doubling makes
    larger, stays below 2^-17.
    """
    for i in prange(len(values)):
        value = min(max(values[i], -TWO), TWO)
        out[i, 0] = value
        angle = value
        sine, cosine = math.sin(angle), math.cos(angle)
        out[i, 1], out[i, 2] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 3], out[i, 4] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 5], out[i, 6] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 7], out[i, 8] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 9], out[i, 10] = sine, cosine
        angle = value * np.float32(32.0)
        sine, cosine = math.sin(angle), math.cos(angle)
        out[i, 11], out[i, 12] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 13], out[i, 14] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 15], out[i, 16] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 17], out[i, 18] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 19], out[i, 20] = sine, cosine


@vividc.kernel("void(float32[::1], float32[:, ::1])")
def encode_direction(values, out):
    """As `encode_position`, of values within -1 to 1 at four frequencies."""
    for i in prange(len(values)):
        value = min(max(values[i], -ONE), ONE)
        out[i, 0] = value
        angle = value
        sine, cosine = math.sin(angle), math.cos(angle)
        out[i, 1], out[i, 2] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 3], out[i, 4] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 5], out[i, 6] = sine, cosine
        sine, cosine = doubled(sine, cosine)
        out[i, 7], out[i, 8] = sine, cosine


@numba.njit
def run_layers(values, weights, layers, samples):  # noqa: PLR0915 - 32 sums have 32 names
    """Linear layers of a network, one after the other, over all samples.

    A row of `layers` says where a layer finds its inputs in `values`, the words between two
    samples' inputs, how many there are; where its weights [inputs, neurons] are in `weights`, how
    many neurons (a multiple of 8); where its results go, and the words between two samples';
    whether they are cut at 0; and where its bias is, or -1 where the results so far are added to.
    """
    for layer in range(layers.shape[0]):
        source = layers[layer, 0]
        pitch = layers[layer, 1]
        width = layers[layer, 2]
        neurons = layers[layer, 4]
        target = layers[layer, 5]
        step = layers[layer, 6]
        lowest = ZERO if layers[layer, 7] else LOWEST
        for s in range(0, samples, 4):
            for o in range(0, neurons, 8):
                x = np.uint32(source + s * pitch)
                w = np.uint32(layers[layer, 3] + o)
                y = np.uint32(target + s * step + o)
                if layers[layer, 8] >= 0:
                    b = np.uint32(layers[layer, 8] + o)
                    a0 = b0 = c0 = d0 = weights[b + np.uint32(0)]
                    a1 = b1 = c1 = d1 = weights[b + np.uint32(1)]
                    a2 = b2 = c2 = d2 = weights[b + np.uint32(2)]
                    a3 = b3 = c3 = d3 = weights[b + np.uint32(3)]
                    a4 = b4 = c4 = d4 = weights[b + np.uint32(4)]
                    a5 = b5 = c5 = d5 = weights[b + np.uint32(5)]
                    a6 = b6 = c6 = d6 = weights[b + np.uint32(6)]
                    a7 = b7 = c7 = d7 = weights[b + np.uint32(7)]
                else:
                    a0 = values[y + np.uint32(0 * step + 0)]
                    a1 = values[y + np.uint32(0 * step + 1)]
                    a2 = values[y + np.uint32(0 * step + 2)]
                    a3 = values[y + np.uint32(0 * step + 3)]
                    a4 = values[y + np.uint32(0 * step + 4)]
                    a5 = values[y + np.uint32(0 * step + 5)]
                    a6 = values[y + np.uint32(0 * step + 6)]
                    a7 = values[y + np.uint32(0 * step + 7)]
                    b0 = values[y + np.uint32(1 * step + 0)]
                    b1 = values[y + np.uint32(1 * step + 1)]
                    b2 = values[y + np.uint32(1 * step + 2)]
                    b3 = values[y + np.uint32(1 * step + 3)]
                    b4 = values[y + np.uint32(1 * step + 4)]
                    b5 = values[y + np.uint32(1 * step + 5)]
                    b6 = values[y + np.uint32(1 * step + 6)]
                    b7 = values[y + np.uint32(1 * step + 7)]
                    c0 = values[y + np.uint32(2 * step + 0)]
                    c1 = values[y + np.uint32(2 * step + 1)]
                    c2 = values[y + np.uint32(2 * step + 2)]
                    c3 = values[y + np.uint32(2 * step + 3)]
                    c4 = values[y + np.uint32(2 * step + 4)]
                    c5 = values[y + np.uint32(2 * step + 5)]
                    c6 = values[y + np.uint32(2 * step + 6)]
                    c7 = values[y + np.uint32(2 * step + 7)]
                    d0 = values[y + np.uint32(3 * step + 0)]
                    d1 = values[y + np.uint32(3 * step + 1)]
                    d2 = values[y + np.uint32(3 * step + 2)]
                    d3 = values[y + np.uint32(3 * step + 3)]
                    d4 = values[y + np.uint32(3 * step + 4)]
                    d5 = values[y + np.uint32(3 * step + 5)]
                    d6 = values[y + np.uint32(3 * step + 6)]
                    d7 = values[y + np.uint32(3 * step + 7)]
                for _ in range(width):
                    w0 = weights[w + np.uint32(0)]
                    w1 = weights[w + np.uint32(1)]
                    w2 = weights[w + np.uint32(2)]
                    w3 = weights[w + np.uint32(3)]
                    w4 = weights[w + np.uint32(4)]
                    w5 = weights[w + np.uint32(5)]
                    w6 = weights[w + np.uint32(6)]
                    w7 = weights[w + np.uint32(7)]
                    value = values[x + np.uint32(0 * pitch)]
                    a0 += value * w0
                    a1 += value * w1
                    a2 += value * w2
                    a3 += value * w3
                    a4 += value * w4
                    a5 += value * w5
                    a6 += value * w6
                    a7 += value * w7
                    value = values[x + np.uint32(1 * pitch)]
                    b0 += value * w0
                    b1 += value * w1
                    b2 += value * w2
                    b3 += value * w3
                    b4 += value * w4
                    b5 += value * w5
                    b6 += value * w6
                    b7 += value * w7
                    value = values[x + np.uint32(2 * pitch)]
                    c0 += value * w0
                    c1 += value * w1
                    c2 += value * w2
                    c3 += value * w3
                    c4 += value * w4
                    c5 += value * w5
                    c6 += value * w6
                    c7 += value * w7
                    value = values[x + np.uint32(3 * pitch)]
                    d0 += value * w0
                    d1 += value * w1
                    d2 += value * w2
                    d3 += value * w3
                    d4 += value * w4
                    d5 += value * w5
                    d6 += value * w6
                    d7 += value * w7
                    w = np.uint32(w + np.uint32(neurons))
                    x = np.uint32(x + np.uint32(1))
                values[y + np.uint32(0 * step + 0)] = max(a0, lowest)
                values[y + np.uint32(0 * step + 1)] = max(a1, lowest)
                values[y + np.uint32(0 * step + 2)] = max(a2, lowest)
                values[y + np.uint32(0 * step + 3)] = max(a3, lowest)
                values[y + np.uint32(0 * step + 4)] = max(a4, lowest)
                values[y + np.uint32(0 * step + 5)] = max(a5, lowest)
                values[y + np.uint32(0 * step + 6)] = max(a6, lowest)
                values[y + np.uint32(0 * step + 7)] = max(a7, lowest)
                values[y + np.uint32(1 * step + 0)] = max(b0, lowest)
                values[y + np.uint32(1 * step + 1)] = max(b1, lowest)
                values[y + np.uint32(1 * step + 2)] = max(b2, lowest)
                values[y + np.uint32(1 * step + 3)] = max(b3, lowest)
                values[y + np.uint32(1 * step + 4)] = max(b4, lowest)
                values[y + np.uint32(1 * step + 5)] = max(b5, lowest)
                values[y + np.uint32(1 * step + 6)] = max(b6, lowest)
                values[y + np.uint32(1 * step + 7)] = max(b7, lowest)
                values[y + np.uint32(2 * step + 0)] = max(c0, lowest)
                values[y + np.uint32(2 * step + 1)] = max(c1, lowest)
                values[y + np.uint32(2 * step + 2)] = max(c2, lowest)
                values[y + np.uint32(2 * step + 3)] = max(c3, lowest)
                values[y + np.uint32(2 * step + 4)] = max(c4, lowest)
                values[y + np.uint32(2 * step + 5)] = max(c5, lowest)
                values[y + np.uint32(2 * step + 6)] = max(c6, lowest)
                values[y + np.uint32(2 * step + 7)] = max(c7, lowest)
                values[y + np.uint32(3 * step + 0)] = max(d0, lowest)
                values[y + np.uint32(3 * step + 1)] = max(d1, lowest)
                values[y + np.uint32(3 * step + 2)] = max(d2, lowest)
                values[y + np.uint32(3 * step + 3)] = max(d3, lowest)
                values[y + np.uint32(3 * step + 4)] = max(d4, lowest)
                values[y + np.uint32(3 * step + 5)] = max(d5, lowest)
                values[y + np.uint32(3 * step + 6)] = max(d6, lowest)
                values[y + np.uint32(3 * step + 7)] = max(d7, lowest)


@vividc.kernel(
    "void(float32[::1], float32[::1], int32[:, ::1], int32, int32, float32, float32[::1])"
)
def density_network(values, weights, layers, first, pitch, step, thickness):
    """Optical thickness of a step at each sample: the last layer's first result, not below 0, which
    is at `first`, `pitch` words apart. The other results stay in `values`.
    """
    samples = len(thickness)
    run_layers(values, weights, layers, samples)
    for sample in range(samples):
        thickness[sample] = max(values[first + sample * pitch], ZERO) * step


@vividc.kernel("void(float32[::1], float32[::1], int32[:, ::1], int32, int32, float32[:, ::1])")
def colour_network(values, weights, layers, first, pitch, colours):
    """Red, green and blue of each sample: the sigmoid of the last layer's first three results."""
    samples = colours.shape[0]
    run_layers(values, weights, layers, samples)
    for sample in range(samples):
        for channel in range(3):
            exponent = -values[first + sample * pitch + channel]
            exponent = min(max(exponent, -LARGEST), LARGEST)
            colours[sample, channel] = ONE / (ONE + math.exp(exponent))

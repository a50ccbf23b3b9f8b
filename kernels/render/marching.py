"""The ray-marching pipeline, block by block of pixels: rays, samples in occupied cells, the light
that reaches them and which of them count, and the picture.

A block is a run of rays; a sample carries the number of its ray. `geometry` holds the camera's
place (0 to 2), the box's lowest corner (3 to 5) and highest (6 to 8), cells a unit (9 to 11), near,
far and the step (12 to 14). Occupancy is a grid of bricks of 4x4x4 cells: one bit a brick in
`coarse`, how many bricks are set before each of its words in `ranks`, and two words of cells for
each brick that is set.
"""

import math

import numba
import numpy as np
from numba import prange

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@vividc.kernel("void(float32[:, ::1], float32[::1], int32[:, ::1], float32[:, :, ::1])")
def camera_rays(pose, lens, corners, directions):
    """Unit directions of blocks of 8x8 pixels, row by row; (0, 0, 0) outside the picture.

    `pose` is the camera's rotation, [3, 3]; `lens` is width, height, focal length and its inverse;
    `corners` is the first column and row of each block.
    """
    for block in prange(corners.shape[0]):
        for pixel in range(64):
            column = np.float32(corners[block, 0] + (pixel & 7))
            row = np.float32(corners[block, 1] + (pixel >> 3))
            u = (column + HALF - HALF * lens[0]) * lens[3]
            v = (HALF * lens[1] - row - HALF) * lens[3]
            x = pose[0, 0] * u + pose[0, 1] * v - pose[0, 2]
            y = pose[1, 0] * u + pose[1, 1] * v - pose[1, 2]
            z = pose[2, 0] * u + pose[2, 1] * v - pose[2, 2]
            inside = column < lens[0] and row < lens[1]
            scale = ONE / math.sqrt(x * x + y * y + z * z) if inside else ZERO
            directions[block, pixel, 0] = x * scale
            directions[block, pixel, 1] = y * scale
            directions[block, pixel, 2] = z * scale


@numba.njit
def slab(geometry, directions, ray, axis):
    """Where a ray meets the two planes of the box across an axis, the nearer first."""
    along = directions[ray, axis]
    if math.fabs(along) < TINY:
        along = TINY
    inverse = ONE / along
    low = (geometry[3 + axis] - geometry[axis]) * inverse
    high = (geometry[6 + axis] - geometry[axis]) * inverse
    return min(low, high), max(low, high)


@numba.njit
def box_spans(directions, geometry, most, entries, exits, steps):
    """Entry and exit of each ray (slabs; Kay and Kajiya 1986), and steps, not over `most`."""
    for ray in range(directions.shape[0]):
        enter_x, leave_x = slab(geometry, directions, ray, 0)
        enter_y, leave_y = slab(geometry, directions, ray, 1)
        enter_z, leave_z = slab(geometry, directions, ray, 2)
        entry = min(max(enter_x, enter_y, enter_z, geometry[12]), geometry[13])
        leave = min(leave_x, leave_y, leave_z)
        total = math.fabs(directions[ray, 0]) + math.fabs(directions[ray, 1])
        outside = leave <= entry or total + math.fabs(directions[ray, 2]) < HALF
        between = ZERO if outside else (leave - entry) / geometry[14]
        entries[ray] = entry
        exits[ray] = leave
        steps[ray] = np.int32(0) if outside else min(most, np.int32(between) + 1)


@numba.njit
def cell_of(origin, along, t, low, cells):
    """The cell along an axis that a ray is in at distance `t`."""
    return np.int32(np.floor((origin + t * along - low) * cells))


@numba.njit
def coarse_samples(base, directions, geometry, grid, coarse, entries, exits, steps, candidates):
    """List the samples in bricks that are set, as far as there is room; returns how many."""
    origin_x, origin_y, origin_z = geometry[0], geometry[1], geometry[2]
    low_x, low_y, low_z = geometry[3], geometry[4], geometry[5]
    cells_x, cells_y, cells_z = geometry[9], geometry[10], geometry[11]
    pitch = geometry[14]
    size_x, size_y, size_z = np.uint32(grid[0]), np.uint32(grid[1]), np.uint32(grid[2])
    columns, rows = grid[3], grid[4]
    found = np.int32(0)
    for ray in range(directions.shape[0]):
        entry = entries[ray]
        leave = exits[ray]
        along_x, along_y, along_z = directions[ray, 0], directions[ray, 1], directions[ray, 2]
        for step in range(steps[ray]):
            t = entry + (np.float32(step) + HALF) * pitch
            x = cell_of(origin_x, along_x, t, low_x, cells_x)
            y = cell_of(origin_y, along_y, t, low_y, cells_y)
            z = cell_of(origin_z, along_z, t, low_z, cells_z)
            inside = (np.uint32(x) < size_x) & (np.uint32(y) < size_y) & (np.uint32(z) < size_z)
            if inside & (t <= leave):
                brick = np.uint32(((x >> 2) * columns + (y >> 2)) * rows + (z >> 2))
                word = coarse[brick >> np.uint32(5)]
                if (word >> (brick & np.uint32(31))) & np.uint32(1):
                    if found < len(candidates):
                        candidates[np.uint32(found)] = ((base + ray) << 16) | step
                    found = np.int32(found + 1)
    return found


@numba.njit
def bits_set(word):
    """How many bits of a word are set (Warren, Hacker's Delight, 2013)."""
    pairs = np.uint32(word - ((word >> np.uint32(1)) & np.uint32(0x55555555)))
    low = np.uint32(pairs & np.uint32(0x33333333))
    fours = np.uint32(low + ((pairs >> np.uint32(2)) & np.uint32(0x33333333)))
    bytes_ = np.uint32((fours + (fours >> np.uint32(4))) & np.uint32(0x0F0F0F0F))
    return np.int32(np.uint32(bytes_ * np.uint32(0x01010101)) >> np.uint32(24))


@numba.njit
def occupied_samples(
    base, directions, geometry, grid, coarse, ranks, bricks, entries, candidates, found, items
):
    """Those of the first `found` candidates that are in occupied cells; returns how many."""
    origin_x, origin_y, origin_z = geometry[0], geometry[1], geometry[2]
    low_x, low_y, low_z = geometry[3], geometry[4], geometry[5]
    cells_x, cells_y, cells_z = geometry[9], geometry[10], geometry[11]
    pitch = geometry[14]
    columns, rows = grid[3], grid[4]
    kept = np.int32(0)
    for number in range(found):
        item = candidates[number]
        ray = np.uint32((item >> 16) - base)
        t = entries[ray] + (np.float32(item & 0xFFFF) + HALF) * pitch
        x = cell_of(origin_x, directions[ray, 0], t, low_x, cells_x)
        y = cell_of(origin_y, directions[ray, 1], t, low_y, cells_y)
        z = cell_of(origin_z, directions[ray, 2], t, low_z, cells_z)
        brick = np.uint32(((x >> 2) * columns + (y >> 2)) * rows + (z >> 2))
        lower = (np.uint32(1) << (brick & np.uint32(31))) - np.uint32(1)
        below = bits_set(np.uint32(coarse[brick >> np.uint32(5)] & lower))
        place = np.uint32(2 * (ranks[brick >> np.uint32(5)] + below))
        cell = np.uint32(((x & 3) << 4) | ((y & 3) << 2) | (z & 3))
        word = bricks[place + (cell >> np.uint32(5))]
        if (word >> (cell & np.uint32(31))) & np.uint32(1):
            if kept < len(items):
                items[np.uint32(kept)] = item
            kept = np.int32(kept + 1)
    return kept


@vividc.kernel(
    "int32(float32[:, ::1], float32[::1], int32[::1], uint32[::1], int32[::1], uint32[::1],"
    " int32, int32, float32[::1], float32[::1], int32[::1], int32[::1], int32[::1])"
)
def march_rays(
    directions,
    geometry,
    grid,
    coarse,
    ranks,
    bricks,
    most,
    base,
    entries,
    exits,
    steps,
    candidates,
    items,
):
    """Samples of rays in occupied cells: (base + ray) << 16 | step, by ray and then by step.

    `grid` is the cells of each axis (0 to 2) and the bricks of the last two (3, 4); a ray has at
    most `most` samples. `exits`, `steps` and `candidates` are room to work in. Returns how many
    samples there are, or how many are in set bricks, if there is no room for those.
    """
    box_spans(directions, geometry, most, entries, exits, steps)
    found = coarse_samples(
        base, directions, geometry, grid, coarse, entries, exits, steps, candidates
    )
    if found > len(candidates):
        return found
    return occupied_samples(
        base, directions, geometry, grid, coarse, ranks, bricks, entries, candidates, found, items
    )


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], int32[::1], int32, float32[:, ::1],"
    " int32[::1])"
)
def sample_points(directions, entries, geometry, items, first_ray, points, rays):
    """Place in the world, and ray of the picture, of each sample of a block."""
    for sample in range(len(items)):
        ray = np.uint32(items[sample] >> 16)
        t = entries[ray] + (np.float32(items[sample] & 0xFFFF) + HALF) * geometry[14]
        points[sample, 0] = geometry[0] + t * directions[ray, 0]
        points[sample, 1] = geometry[1] + t * directions[ray, 1]
        points[sample, 2] = geometry[2] + t * directions[ray, 2]
        rays[sample] = first_ray + np.int32(ray)


@vividc.kernel(
    "int32(float32[::1], int32[::1], int32, int32, float32[::1], int32, float32[::1], int32[::1],"
    " int32[::1], float32[::1])"
)
def transmittance(
    thickness, rays, first_ray, first_sample, limits, keep_all, left, kept, kept_rays, weights
):
    """Light that reaches each sample of a block, and the samples that count: Lookahead Culling I.

    A sample counts if the light before it is at least `limits[0]`, and its weight above
    `limits[1]`. Those, or with `keep_all` all, are listed: number, ray and weight, which is 0 where
    a sample does not count. `left` is what passes all samples of a ray. Returns how many are
    listed.
    """
    for ray in range(len(left)):
        left[ray] = ONE
    listed = np.int32(0)
    last = np.int32(-1)
    light = ONE
    for sample in range(len(thickness)):
        ray = rays[sample]
        if ray != last:
            light = ONE
        last = ray
        alpha = ONE - math.exp(-thickness[sample])
        weight = light * alpha
        counts = light >= limits[0] and weight > limits[1]
        if counts or keep_all != 0:
            place = np.uint32(listed)
            kept[place] = first_sample + sample
            kept_rays[place] = ray
            weights[place] = weight if counts else ZERO
            listed = np.int32(listed + 1)
        light = light * (ONE - alpha)
        left[np.uint32(ray - first_ray)] = light
    return listed


@vividc.kernel(
    "void(float32[::1], int32[::1], float32[:, ::1], float32[::1], int32, float32[:, ::1])"
)
def accumulate(weights, rays, colours, left, first_ray, out):
    """Emission along the rays of a block, front to back (Max 1995), over white: r, g, b and
    transmittance.
    """
    for ray in range(len(left)):
        out[ray, 0] = ZERO
        out[ray, 1] = ZERO
        out[ray, 2] = ZERO
        out[ray, 3] = left[ray]
    last = np.uint32(0xFFFFFFFF)
    red = ZERO
    green = ZERO
    blue = ZERO
    for sample in range(len(weights)):
        ray = np.uint32(rays[sample] - first_ray)
        if ray != last:
            red = ZERO
            green = ZERO
            blue = ZERO
        last = ray
        red += weights[sample] * colours[sample, 0]
        green += weights[sample] * colours[sample, 1]
        blue += weights[sample] * colours[sample, 2]
        out[ray, 0] = red
        out[ray, 1] = green
        out[ray, 2] = blue
    for ray in range(len(left)):
        out[ray, 0] += out[ray, 3]
        out[ray, 1] += out[ray, 3]
        out[ray, 2] += out[ray, 3]

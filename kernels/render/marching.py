"""The ray-marching pipeline, block by block of pixels: rays, samples in occupied cells, the light
that reaches them and which of them count, and the picture.

A block is a run of rays; a sample carries the number of its ray. `geometry` holds the camera's
place (0 to 2), the box's lowest corner (3 to 5) and highest (6 to 8), cells a unit (9 to 11), near,
far and the step (12 to 14). Occupancy is a grid of bricks of 4x4x4 cells: one bit a brick in
`coarse`, how many bricks are set before each of its words in `ranks`, and two words of cells for
each brick that is set.
"""

import math

import numpy as np
from numba import prange

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
BEYOND = np.float32(3e38)


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


@vividc.kernel(
    "int32(float32[:, ::1], float32[::1], int32[::1], uint32[::1], int32[::1], uint32[::1],"
    " int32, float32[::1], float32[::1], int32[::1], int32[::1], int32[::1])"
)
def march_rays(
    directions,
    geometry,
    grid,
    coarse,
    ranks,
    bricks,
    most,
    entries,
    exits,
    steps,
    candidates,
    items,
):
    """Samples of a block in occupied cells: ray << 16 | step, by ray and then by step.

    `grid` is the cells of each axis (0 to 2) and the bricks of the last two (3, 4); a ray has at
    most `most` samples. `exits`, `steps` and `candidates` are room to work in. Returns how many
    samples there are, or how many are in set bricks, if more of either than there is room for.
    """
    for ray in range(directions.shape[0]):
        entry = geometry[12]
        leave = BEYOND
        total = ZERO
        for axis in range(3):
            along = directions[ray, axis]
            total += along * along
            if math.fabs(along) < TINY:
                along = TINY
            low = (geometry[3 + axis] - geometry[axis]) / along
            high = (geometry[6 + axis] - geometry[axis]) / along
            entry = max(entry, min(low, high))
            leave = min(leave, max(low, high))
        entry = min(entry, geometry[13])
        count = np.int32(0)
        if leave > entry and total > HALF:
            count = min(most, np.int32((leave - entry) / geometry[14]) + 1)
        entries[ray] = entry
        exits[ray] = leave
        steps[ray] = count
    found = np.int32(0)
    for ray in range(directions.shape[0]):
        for step in range(steps[ray]):
            t = entries[ray] + (np.float32(step) + HALF) * geometry[14]
            x = (geometry[0] + t * directions[ray, 0] - geometry[3]) * geometry[9]
            y = (geometry[1] + t * directions[ray, 1] - geometry[4]) * geometry[10]
            z = (geometry[2] + t * directions[ray, 2] - geometry[5]) * geometry[11]
            cx = np.int32(np.floor(x))
            cy = np.int32(np.floor(y))
            cz = np.int32(np.floor(z))
            inside = (
                np.uint32(cx) < np.uint32(grid[0])
                and np.uint32(cy) < np.uint32(grid[1])
                and np.uint32(cz) < np.uint32(grid[2])
            )
            if inside and t <= exits[ray]:
                brick = np.int32(((cx >> 2) * grid[3] + (cy >> 2)) * grid[4] + (cz >> 2))
                if (coarse[brick >> 5] >> np.uint32(brick & 31)) & np.uint32(1):
                    if found < len(candidates):
                        candidates[found] = (ray << 16) | step
                    found = np.int32(found + 1)
    if found > len(candidates):
        return found
    kept = np.int32(0)
    for number in range(found):
        item = candidates[number]
        ray = item >> 16
        t = entries[ray] + (np.float32(item & 0xFFFF) + HALF) * geometry[14]
        x = (geometry[0] + t * directions[ray, 0] - geometry[3]) * geometry[9]
        y = (geometry[1] + t * directions[ray, 1] - geometry[4]) * geometry[10]
        z = (geometry[2] + t * directions[ray, 2] - geometry[5]) * geometry[11]
        cx = np.int32(np.floor(x))
        cy = np.int32(np.floor(y))
        cz = np.int32(np.floor(z))
        brick = np.int32(((cx >> 2) * grid[3] + (cy >> 2)) * grid[4] + (cz >> 2))
        below = np.uint32(
            coarse[brick >> 5] & ((np.uint32(1) << np.uint32(brick & 31)) - np.uint32(1))
        )
        below -= (below >> np.uint32(1)) & np.uint32(0x55555555)
        below = (below & np.uint32(0x33333333)) + ((below >> np.uint32(2)) & np.uint32(0x33333333))
        below = (below + (below >> np.uint32(4))) & np.uint32(0x0F0F0F0F)
        below = np.uint32(below * np.uint32(0x01010101)) >> np.uint32(24)
        place = np.int32(2 * (ranks[brick >> 5] + np.int32(below)))
        cell = np.int32(((cx & 3) << 4) | ((cy & 3) << 2) | (cz & 3))
        if (bricks[place + (cell >> 5)] >> np.uint32(cell & 31)) & np.uint32(1):
            if kept < len(items):
                items[kept] = item
            kept = np.int32(kept + 1)
    return kept


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], int32[::1], int32, float32[:, ::1],"
    " int32[::1])"
)
def sample_points(directions, entries, geometry, items, first_ray, points, rays):
    """Place in the world, and ray of the picture, of each sample of a block."""
    for sample in range(len(items)):
        ray = items[sample] >> 16
        t = entries[ray] + (np.float32(items[sample] & 0xFFFF) + HALF) * geometry[14]
        points[sample, 0] = geometry[0] + t * directions[ray, 0]
        points[sample, 1] = geometry[1] + t * directions[ray, 1]
        points[sample, 2] = geometry[2] + t * directions[ray, 2]
        rays[sample] = first_ray + ray


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
            kept[listed] = first_sample + sample
            kept_rays[listed] = ray
            weights[listed] = weight if counts else ZERO
            listed = np.int32(listed + 1)
        light = light * (ONE - alpha)
        left[ray - first_ray] = light
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
    last = np.int32(-1)
    red = ZERO
    green = ZERO
    blue = ZERO
    for sample in range(len(weights)):
        ray = np.int32(rays[sample] - first_ray)
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

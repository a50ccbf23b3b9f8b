"""The ray-marching pipeline, block by block of 8x8 pixels: rays, samples in occupied cells, the
light that reaches them and which of them count, and the picture.

The samples of a block are listed by step, counted from where its set bricks begin, and then by ray,
so that neighbours in the list are neighbours in the scene. An item of such a list is ray << 16 |
step; in a list of those that survive, with the place of the sample in its launch << 22. `geometry`
holds the camera's place (0 to 2), the box's lowest corner (3 to 5) and highest (6 to 8), cells a
unit (9 to 11), near, far and the step (12 to 14), and steps a unit (15). Occupancy is a grid of
bricks of 4x4x4 cells: one bit a brick in `coarse`, how many bricks are set before each of its words
in `ranks`, and two words of cells for each brick that is set; `grid` is the cells of each axis (0
to 2) and the bricks (3 to 5).
"""

import math

import numba
import numpy as np
from numba import prange

import vividc
from vividc import lang

ZERO = np.float32(0.0)
QUARTER = np.float32(0.25)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
MOST = np.float32(65534.0)
LOW = np.uint32(0xFFFF)
HIGH = np.uint32(16)
PLACE = np.uint32(22)
NOT_LANE = np.uint32(0xFFFFFFF0)
"""All of a number of a sample but its place in a block of 16."""
LARGE = np.float32(20.0)
LARGEST = np.float32(80.0)
CHORD = np.uint32(0x7EF311C7)
UPPER = np.uint32(0x3C000000)
"""0 and 1 as float16: the products with a word of finite numbers add up to the upper one."""


@numba.njit
def slab(along, origin, low, high):
    """Where a ray meets the two planes of the box across an axis, the nearer first."""
    inverse = ONE / (TINY if math.fabs(along) < TINY else along)
    one = (low - origin) * inverse
    other = (high - origin) * inverse
    return min(one, other), max(one, other)


@numba.njit
def whole_steps(distance, geometry):
    """Whole steps in a distance: at least 0, at most what sixteen bits hold with one more."""
    return np.uint32(np.int32(min(max(distance * geometry[15], ZERO), MOST)))


@vividc.kernel(
    "void(float32[:, ::1], float32[::1], float32[::1], int32, int32[:, ::1], float32[:, ::1],"
    " float32[:, :, ::1], float32[:, ::1], uint32[:, ::1])"
)
def camera_rays(pose, lens, geometry, most, corners, depths, directions, entries, steps):
    """Rays of blocks of 8x8 pixels, row by row: unit directions, (0, 0, 0) outside the picture;
    where they enter the box (slabs; Kay and Kajiya 1986); and their steps, the first and, << 16,
    the one behind the last.

    `pose` is the camera's rotation, [3, 3]; `lens` is width, height, focal length and its inverse;
    `corners` is the first column and row of each block, `depths` the distances between which its
    set bricks are. A ray has at most `most` steps.
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
        for ray in range(64):
            x, y, z = (
                directions[block, ray, 0],
                directions[block, ray, 1],
                directions[block, ray, 2],
            )
            inside = math.fabs(x) + math.fabs(y) + math.fabs(z) > HALF
            enter_x, leave_x = slab(x, geometry[0], geometry[3], geometry[6])
            enter_y, leave_y = slab(y, geometry[1], geometry[4], geometry[7])
            enter_z, leave_z = slab(z, geometry[2], geometry[5], geometry[8])
            entry = min(max(enter_x, enter_y, enter_z, geometry[12]), geometry[13])
            leave = min(leave_x, leave_y, leave_z)
            last = whole_steps(leave - entry, geometry)
            is_in = entry + (np.float32(np.int32(last)) + HALF) * geometry[14] <= leave
            end = min(np.uint32(most), last + np.uint32(1) if is_in else last)
            far = whole_steps(depths[block, 1] - entry, geometry) + np.uint32(1)
            clipped = min(end, far) if inside and leave > entry else np.uint32(0)
            entries[block, ray] = entry
            steps[block, ray] = (clipped << HIGH) | whole_steps(depths[block, 0] - entry, geometry)


@numba.njit
def along_box(origin, along, t, low, scale):
    """Where in the box a ray is along an axis at distance `t`, in cells or in bricks."""
    return (origin + t * along - low) * scale


@numba.njit
def coarse_samples(
    first, pairs, directions, entries, steps, geometry, grid, coarse, candidates, bricks_of
):
    """List the samples in set bricks, and these, among some steps of all rays; returns how many."""
    origin_x, origin_y, origin_z = geometry[0], geometry[1], geometry[2]
    low_x, low_y, low_z = geometry[3], geometry[4], geometry[5]
    scale_x, scale_y, scale_z = (
        QUARTER * geometry[9],
        QUARTER * geometry[10],
        QUARTER * geometry[11],
    )
    pitch = geometry[14]
    layers, columns, rows = np.uint32(grid[3]), np.uint32(grid[4]), np.uint32(grid[5])
    found = np.int32(0)
    for pair in range(pairs):
        ray = np.uint32(pair & 63)
        span = steps[ray]
        step = np.uint32((span & LOW) + np.uint32(first + np.int32(pair >> 6)))
        t = entries[ray] + (np.float32(np.int32(step)) + HALF) * pitch
        x = along_box(origin_x, directions[ray, 0], t, low_x, scale_x)
        y = along_box(origin_y, directions[ray, 1], t, low_y, scale_y)
        z = along_box(origin_z, directions[ray, 2], t, low_z, scale_z)
        layer, column, row = np.uint32(np.int32(x)), np.uint32(np.int32(y)), np.uint32(np.int32(z))
        inside = (layer < layers) & (column < columns) & (row < rows)
        if inside & (min(x, y, z) >= ZERO) & (step < (span >> HIGH)):
            brick = np.uint32(np.uint32(np.uint32(layer * columns + column) * rows) + row)
            word = coarse[brick >> np.uint32(5)]
            if (word >> (brick & np.uint32(31))) & np.uint32(1):
                candidates[np.uint32(found)] = np.int32((ray << HIGH) | step)
                bricks_of[np.uint32(found)] = brick
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
    directions, geometry, coarse, ranks, bricks, entries, candidates, bricks_of, found, kept, items
):
    """List those of the first `found` candidates that are in occupied cells behind the `kept` that
    are listed, as far as there is room; returns how many there are then.
    """
    origin_x, origin_y, origin_z = geometry[0], geometry[1], geometry[2]
    low_x, low_y, low_z = geometry[3], geometry[4], geometry[5]
    cells_x, cells_y, cells_z = geometry[9], geometry[10], geometry[11]
    pitch = geometry[14]
    for number in range(found):
        item = candidates[number]
        ray = np.uint32(item >> 16)
        t = entries[ray] + (np.float32(item & 0xFFFF) + HALF) * pitch
        x = np.int32(along_box(origin_x, directions[ray, 0], t, low_x, cells_x))
        y = np.int32(along_box(origin_y, directions[ray, 1], t, low_y, cells_y))
        z = np.int32(along_box(origin_z, directions[ray, 2], t, low_z, cells_z))
        brick = bricks_of[number]
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
    "int32(float32[:, ::1], float32[::1], uint32[::1], float32[::1], int32[::1], uint32[::1],"
    " int32[::1], uint32[::1], int32, int32, int32, int32[::1], uint32[::1], int32[::1],"
    " int32[::1])"
)
def march_rays(
    directions,
    entries,
    steps,
    geometry,
    grid,
    coarse,
    ranks,
    bricks,
    start,
    end,
    at_once,
    candidates,
    bricks_of,
    items,
    count,
):
    """Samples of a block's rays in occupied cells.

    The steps of each ray are cut into parts of `at_once`; parts `start` to `end` (excluded) are
    looked at. `candidates` and `bricks_of` have room for all samples of a part, and `items` for
    no fewer. `count` gets how many samples there are. Returns that << 16 | the part at which to go
    on if there was no room for all, or 0.
    """
    kept = np.int32(0)
    for part in range(start, end):
        found = coarse_samples(
            *(np.int32(part * at_once), np.int32(64 * at_once)),
            *(directions, entries, steps, geometry, grid, coarse, candidates, bricks_of),
        )
        after = occupied_samples(
            *(directions, geometry, coarse, ranks, bricks),
            *(entries, candidates, bricks_of, found, kept, items),
        )
        if after > len(items):
            count[0] = kept
            return np.int32((kept << 16) | part)
        kept = after
    count[0] = kept
    return np.int32(kept << 16)


@numba.njit
def ray_of(item):
    """The ray of a sample, among the block's."""
    return np.uint32((np.uint32(item) >> HIGH) & np.uint32(63))


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1], int32[::1], float32[:, ::1])")
def sample_points(directions, entries, geometry, items, out):
    """Place in the world of each sample of a block."""
    for sample in range(len(items)):
        ray = ray_of(items[sample])
        t = entries[ray] + (np.float32(items[sample] & 0xFFFF) + HALF) * geometry[14]
        out[sample, 0] = geometry[0] + t * directions[ray, 0]
        out[sample, 1] = geometry[1] + t * directions[ray, 1]
        out[sample, 2] = geometry[2] + t * directions[ray, 2]


@vividc.kernel("void(float32[:, ::1], int32[::1], float32[:, ::1])")
def sample_directions(directions, items, out):
    """Direction of the ray of each sample of a block."""
    for sample in range(len(items)):
        ray = ray_of(items[sample])
        out[sample, 0] = directions[ray, 0]
        out[sample, 1] = directions[ray, 1]
        out[sample, 2] = directions[ray, 2]


@numba.njit
def begin(left, goes_on):
    """Let all light pass before the first samples of a block."""
    if goes_on == 0:
        for ray in range(len(left)):
            left[ray] = ONE


@numba.njit
def list_sample(sample, thickness, items, limits, keep_all, left, kept_items, weights, listed):
    """List a sample of some optical thickness of a step if it counts; returns how many are listed
    then.

    A sample counts if the light before it is at least `limits[0]`, and its weight above
    `limits[1]`: Lookahead Culling I. Those, or with `keep_all` all, are listed: item and weight,
    which is 0 where a sample does not count; there are at most 1024. `left` is what passes all
    samples of a ray; where a kernel `goes_on`, it holds what passes those before.
    """
    ray = ray_of(items[sample])
    light = left[ray]
    alpha = ONE - math.exp(-thickness)
    weight = light * alpha
    counts = light >= limits[0] and weight > limits[1]
    if counts or keep_all != 0:
        place = np.uint32(listed)
        kept_items[place] = items[sample] | np.int32(np.uint32(sample) << PLACE)
        weights[place] = weight if counts else ZERO
        listed = np.int32(listed + 1)
    left[ray] = light * (ONE - alpha)
    return listed


@numba.njit
def survivors(listed, kept_items, count):
    """Leave in `count` how many samples are listed, and return that << 20 | the place of the first
    in its launch << 10 | the last's, or 0.
    """
    count[0] = listed
    if listed == 0:
        return np.int32(0)
    first = np.uint32(kept_items[0]) >> PLACE
    last = np.uint32(kept_items[np.uint32(listed - 1)]) >> PLACE
    return np.int32(np.uint32(listed) << np.uint32(20) | first << np.uint32(10) | last)


@vividc.kernel(
    "int32(float32[::1], int32[::1], int32[::1], int32, float32[::1], int32, float32[::1],"
    " int32[::1], float32[::1], int32[::1])"
)
def transmittance_in_groups(
    thickness, places, items, goes_on, limits, keep_all, left, kept_items, weights, count
):
    """Light that reaches each sample of a block, whose thickness is at `places`, and the samples
    that are listed (`list_sample`); returns which (`survivors`).
    """
    begin(left, goes_on)
    listed = np.int32(0)
    for sample in range(len(items)):
        listed = list_sample(
            *(sample, thickness[np.uint32(places[sample])], items, limits, keep_all),
            *(left, kept_items, weights, listed),
        )
    return survivors(listed, kept_items, count)


@vividc.kernel(
    "int32(float32[::1], int32, float32, float32, int32[::1], int32, float32[::1], int32,"
    " float32[::1], int32[::1], float32[::1], int32[::1])"
)
def transmittance_of_exponents(
    x, first, most, step, items, goes_on, limits, keep_all, left, kept_items, weights, count
):
    """As `transmittance_in_groups`, of samples whose density is exp of `x`, of at most `most`, from
    number `first` on.
    """
    begin(left, goes_on)
    listed = np.int32(0)
    for sample in range(len(items)):
        thickness = math.exp(min(x[np.uint32(first + sample)], most)) * step
        listed = list_sample(
            sample, thickness, items, limits, keep_all, left, kept_items, weights, listed
        )
    return survivors(listed, kept_items, count)


@vividc.kernel(
    "int32(uint32[::1], int32, float32, float32, int32[::1], int32, float32[::1], int32,"
    " float32[::1], int32[::1], float32[::1], int32[::1])"
)
def transmittance_of_exponents_fp8(
    x, first, most, step, items, goes_on, limits, keep_all, left, kept_items, weights, count
):
    """As `transmittance_of_exponents`, of the lower float16 of words."""
    begin(left, goes_on)
    listed = np.int32(0)
    for sample in range(len(items)):
        exponent = np.float32(lang.fp16_from_bits(x[np.uint32(first + sample)]))
        thickness = math.exp(min(exponent, most)) * step
        listed = list_sample(
            sample, thickness, items, limits, keep_all, left, kept_items, weights, listed
        )
    return survivors(listed, kept_items, count)


@vividc.kernel(
    "int32(float32[:, ::1], float32, float32, int32[::1], int32, float32[::1], int32,"
    " float32[::1], int32[::1], float32[::1], int32[::1])"
)
def transmittance_of_sums(
    sums, shift, step, items, goes_on, limits, keep_all, left, kept_items, weights, count
):
    """As `transmittance_in_groups`, of samples whose density is log(1 + exp(x)), which is x where
    that is large: x is `shift` and a number of each row of `sums`, the first of which is worked in.
    """
    begin(left, goes_on)
    for k in range(sums.shape[0]):
        for sample in range(len(items)):
            sums[0, sample] = (shift if k == 0 else sums[0, sample]) + sums[k, sample]
    listed = np.int32(0)
    for sample in range(len(items)):
        x = sums[0, sample]
        small = math.log1p(math.exp(min(x, LARGE)))
        thickness = (x if x > LARGE else small) * step
        listed = list_sample(
            sample, thickness, items, limits, keep_all, left, kept_items, weights, listed
        )
    return survivors(listed, kept_items, count)


@numba.njit
def begin_sums(left, goes_on, out):
    """Zeros, and the light behind all samples."""
    if goes_on == 0:
        for ray in range(len(left)):
            at = np.uint32(ray << 2)
            out[at] = ZERO
            out[at + np.uint32(1)] = ZERO
            out[at + np.uint32(2)] = ZERO
            out[at + np.uint32(3)] = left[ray]


@numba.njit
def add_colour(item, weight, colour, out):
    """Add what a sample emits to its ray's sums, which are read before one of them is written."""
    at = ray_of(item) << np.uint32(2)
    red, green, blue = out[at], out[at + np.uint32(1)], out[at + np.uint32(2)]
    out[at] = red + weight * colour[0]
    out[at + np.uint32(1)] = green + weight * colour[1]
    out[at + np.uint32(2)] = blue + weight * colour[2]


@numba.njit
def put_over_white(left, is_last, out):
    """Add the light of a white background, behind a block's last samples."""
    if is_last != 0:
        for ray in range(len(left)):
            at = np.uint32(ray << 2)
            light = left[ray]
            out[at] += light
            out[at + np.uint32(1)] += light
            out[at + np.uint32(2)] += light


@vividc.kernel(
    "void(float32[::1], int32[::1], int32[::1], float32[:, ::1], float32[::1], int32, int32,"
    " float32[::1])"
)
def accumulate_in_groups(weights, items, places, colours, left, goes_on, is_last, out):
    """Emission along the rays of a block, front to back (Max 1995), of samples whose colours are at
    `places`: r, g, b and transmittance of each ray.

    With `goes_on`, `out` holds the sums of the samples before; with `is_last` it is put over white.
    """
    begin_sums(left, goes_on, out)
    for sample in range(len(weights)):
        place = np.uint32(places[sample])
        colour = (colours[place, 0], colours[place, 1], colours[place, 2])
        add_colour(items[sample], weights[sample], colour, out)
    put_over_white(left, is_last, out)


@numba.njit
def inverse(d):
    """1 / d, correctly rounded, of d from 1 to 2^125: of a chord of 1 / d in its bits, a product of
    a geometric series and two corrections by exact residuals.
    """
    y = lang.bitcast_f32(CHORD - np.uint32(lang.bitcast_i32(d)))
    error = lang.fma(-d, y, ONE)
    y = lang.fma(y, error, y)
    y = lang.fma(y, error * error, y)
    error = lang.fma(-d, y, ONE)
    y = lang.fma(y, lang.fma(error, error, error), y)
    return lang.fma(y, lang.fma(-d, y, ONE), y)


@numba.njit
def sigmoid(x):
    return inverse(ONE + math.exp(min(-x, LARGEST)))


@vividc.kernel(
    "void(float32[::1], int32[::1], float32[::1], int32, float32[::1], int32, int32, float32[::1])"
)
def accumulate_sigmoids(weights, items, x, first, left, goes_on, is_last, out):
    """As `accumulate_in_groups`, of colours that are sigmoids of a network's three outputs: blocks
    [block, output, 16] of samples, the first of which is the first block's `first`.
    """
    begin_sums(left, goes_on, out)
    for sample in range(len(weights)):
        place = np.uint32(first + sample)
        at = place + np.uint32(2) * (place & NOT_LANE)
        colour = (
            sigmoid(x[at]),
            sigmoid(x[at + np.uint32(16)]),
            sigmoid(x[at + np.uint32(32)]),
        )
        add_colour(items[sample], weights[sample], colour, out)
    put_over_white(left, is_last, out)


@vividc.kernel(
    "void(float32[::1], int32[::1], uint32[::1], int32, float32[::1], int32, int32, float32[::1])"
)
def accumulate_sigmoids_fp8(weights, items, x, first, left, goes_on, is_last, out):
    """As `accumulate_sigmoids`, of words of two float16, [block, 2, 16]."""
    begin_sums(left, goes_on, out)
    for sample in range(len(weights)):
        place = np.uint32(first + sample)
        at = place + (place & NOT_LANE)
        word = x[at]
        colour = (
            sigmoid(np.float32(lang.fp16_from_bits(word))),
            sigmoid(lang.dot_fp16(word, UPPER, ZERO)),
            sigmoid(np.float32(lang.fp16_from_bits(x[at + np.uint32(16)]))),
        )
        add_colour(items[sample], weights[sample], colour, out)
    put_over_white(left, is_last, out)

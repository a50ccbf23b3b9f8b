"""Blending of 3D Gaussian Splatting (Kerbl et al. 2023) for one screen tile of 16x16 pixels: with
the late test of alpha (`blend_late`), and with Lookahead Culling II, which decides on the exponent
before exp: for blocks of 4x4 pixels (`blend_blocks`), and then for each pixel (`blend_lookahead`).

A run takes a part of the tile's depth-sorted list, already in the scratchpad, and carries colour
and transmittance on: lists of any length are blended part by part. All three give the same picture
to the last bit.

A row of `splats` is centre x, y; conic a, b, c; opacity; the least exponent that counts; r, g, b;
half the width and height of the box in which it may be seen, with half a block. A row of `pixels`
is r, g, b, transmittance, which is negative once the pixel is done.
"""

import math

import numba
import numpy as np

import vividc
from vividc.lang import bitcast_f32, bitcast_i32

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
ALPHA_MAX = np.float32(0.99)
ALPHA_MIN = np.float32(1.0 / 255.0)
TRANSMITTANCE_MIN = np.float32(1e-4)
BLOCK_REACH = np.float32(3.0)
HALF_REACH = np.float32(1.5)
# What float32 may err in an exponent: absolute (thresholds, exp), and relative to its terms.
MARGIN = np.float32(1e-4)
ROUNDING = np.float32(4e-6)

# Minus the exponent's bits of a first guess of 1 / x.
RECIPROCAL = 0x7EF311C3

SPLAT_WORDS = 12
SIDE = 4
BLOCK = 16
SEGMENT = 48
LIST_PART = 160
SURVIVORS = 768
# Masks that change nothing: they tell the compiler that an index is small and not negative.
PLACES = 2047
IN_LIST = 255
IN_SURVIVORS = 1023
IN_BLOCK = 15
IN_TWO_BLOCKS = 31
IN_PIXELS = 1023


@numba.njit
def clear_pixels(pixels):
    """Black, and nothing in the way."""
    for p in range(256):
        pixels[4 * p] = ZERO
        pixels[4 * p + 1] = ZERO
        pixels[4 * p + 2] = ZERO
        pixels[4 * p + 3] = ONE


@numba.njit
def over_white(pixels):
    """Adds what is left of a white background."""
    for p in range(256):
        left = abs(pixels[4 * p + 3])
        pixels[4 * p] += left
        pixels[4 * p + 1] += left
        pixels[4 * p + 2] += left
        pixels[4 * p + 3] = left


@numba.njit
def nearly_inverse(x):
    """1 / x to one part in 10^4, of a positive normal x: two steps of Newton's."""
    guess = bitcast_f32(RECIPROCAL - bitcast_i32(x))
    guess = guess * (TWO - x * guess)
    return guess * (TWO - x * guess)


@numba.njit
def near(splats, n, x, y, near_by):
    """Places of the splats whose box meets the block of 4x4 pixels from (x, y); how many."""
    middle_x = x + HALF_REACH
    middle_y = y + HALF_REACH
    count = np.int32(0)
    for k in range(n):
        o = (SPLAT_WORDS * k) & PLACES
        across = abs(splats[o] - middle_x)
        down = abs(splats[o + 1] - middle_y)
        if across <= splats[o + 10] and down <= splats[o + 11]:
            near_by[count & IN_LIST] = o
            count = np.int32(count + 1)
    return count & IN_LIST


@numba.njit
def cull(splats, near_by, n, x, y, kept):
    """Of those, the splats that may be seen in the block; how many.

    The quadratic form is least at the mean, or on an edge of the block that faces it.
    """
    count = np.int32(0)
    for k in range(n):
        o = near_by[k] & PLACES
        right = splats[o] - x
        left = right - BLOCK_REACH
        bottom = splats[o + 1] - y
        top = bottom - BLOCK_REACH
        a = splats[o + 2]
        b = splats[o + 3]
        c = splats[o + 4]
        near_x = min(max(ZERO, left), right)
        near_y = min(max(ZERO, top), bottom)
        v = min(max(-b * near_x * nearly_inverse(c), top), bottom)
        u = min(max(-b * near_y * nearly_inverse(a), left), right)
        b = TWO * b
        least = min(
            (a * near_x + b * v) * near_x + c * v * v, (c * near_y + b * u) * near_y + a * u * u
        )
        far_x = abs(right) + BLOCK_REACH
        far_y = abs(bottom) + BLOCK_REACH
        terms = (a * far_x + abs(b) * far_y) * far_x + c * far_y * far_y
        # So that it is kept where something is no number.
        if not HALF * least > MARGIN + ROUNDING * terms - splats[o + 6]:
            kept[count & IN_LIST] = o
            count = np.int32(count + 1)
    return count & IN_LIST


@numba.njit
def load_block(pixels, here, new):
    """Takes the pixels of a block of 4x4."""
    for p in range(BLOCK):
        o = here + 64 * (p >> 2) + 4 * (p & 3)
        new[4 * p] = pixels[o]
        new[4 * p + 1] = pixels[o + 1]
        new[4 * p + 2] = pixels[o + 2]
        new[4 * p + 3] = pixels[o + 3]


@numba.njit
def store_block(new, pixels, here):
    """Puts the pixels of a block of 4x4 back."""
    for p in range(BLOCK):
        o = here + 64 * (p >> 2) + 4 * (p & 3)
        pixels[o] = new[4 * p]
        pixels[o + 1] = new[4 * p + 1]
        pixels[o + 2] = new[4 * p + 2]
        pixels[o + 3] = new[4 * p + 3]


@numba.njit
def list_live(new, x, y, state, live_x, live_y, live_pixel):
    """The pixels that are not done, after the block from (x, y) was copied; how many."""
    live = 0
    for p in range(BLOCK):
        t = new[4 * p + 3]
        state[4 * p] = new[4 * p]
        state[4 * p + 1] = new[4 * p + 1]
        state[4 * p + 2] = new[4 * p + 2]
        state[4 * p + 3] = t
        if t > ZERO:
            live_x[live] = x + np.float32(np.int32(p & 3))
            live_y[live] = y + np.float32(np.int32(p >> 2))
            live_pixel[live] = p
            live = (live + 1) & IN_TWO_BLOCKS
    return live


@numba.njit
def find_survivors(splats, kept, first, last, live_x, live_y, live_pixel, steps, powers, survivors):
    """Exponents of splats kept[first] to kept[last] at each live pixel that may count; how many.

    A survivor is 16 times the splat's place, and the pixel.
    """
    count = np.int32(0)
    q = np.int32(0)
    j = first
    for _ in range(steps):
        o = kept[j & IN_LIST] & PLACES
        k = q & IN_BLOCK
        dx = splats[o] - live_x[k]
        dy = splats[o + 1] - live_y[k]
        power = (
            -HALF * (splats[o + 2] * dx * dx + splats[o + 4] * dy * dy) - splats[o + 3] * dx * dy
        )
        if power >= splats[o + 6] and power <= ZERO:
            powers[count & IN_SURVIVORS] = power
            survivors[count & IN_SURVIVORS] = 16 * o + live_pixel[k]
            count = np.int32(count + 1)
        if j == last:
            j = first
            q = np.int32(q + 1)
        else:
            j = np.int32(j + 1)
    return count & IN_SURVIVORS


@numba.njit
def blend_survivors(splats, powers, survivors, count, state, new):
    """Takes exp of the survivors, and blends them: pixels from `state` to `new`."""
    before = -1
    t = ZERO
    left = ZERO
    r = ZERO
    g = ZERO
    b = ZERO
    for s in range(count):
        code = survivors[s]
        p = code & IN_BLOCK
        o = (code >> 4) & PLACES
        if p != before:
            r = state[4 * p]
            g = state[4 * p + 1]
            b = state[4 * p + 2]
            t = state[4 * p + 3]
            left = t
        before = p
        alpha = min(ALPHA_MAX, splats[o + 5] * math.exp(powers[s]))
        if alpha < ALPHA_MIN:
            alpha = ZERO
        weight = alpha * t
        t *= ONE - alpha
        # Once below it stays below: what has become of t then no longer counts.
        if t >= TRANSMITTANCE_MIN:
            r += splats[o + 7] * weight
            g += splats[o + 8] * weight
            b += splats[o + 9] * weight
            left = t
        else:
            left = -abs(left)
        new[4 * p] = r
        new[4 * p + 1] = g
        new[4 * p + 2] = b
        new[4 * p + 3] = left


@vividc.kernel(
    "void(float32[::1], float32[::1], int32[::1], int32, float32, float32, int32, int32, int32)"
)
def blend_lookahead(splats, pixels, counts, n, x0, y0, height, first, last):
    """`counts` gains tests of blocks, exponents, and exps; `first` and `last` parts of a list."""
    near_by = np.empty(LIST_PART, np.int32)
    kept = np.empty(LIST_PART, np.int32)
    live_x = np.empty(BLOCK, np.float32)
    live_y = np.empty(BLOCK, np.float32)
    live_pixel = np.empty(BLOCK, np.int32)
    state = np.empty(4 * BLOCK, np.float32)
    new = np.empty(4 * BLOCK, np.float32)
    powers = np.empty(SURVIVORS, np.float32)
    survivors = np.empty(SURVIVORS, np.int32)
    if first != 0:
        clear_pixels(pixels)
    for block in range(4 * (height + 3 >> 2)):
        x = x0 + np.float32(np.int32(SIDE * (block & 3)))
        y = y0 + np.float32(np.int32(SIDE * (block >> 2)))
        here = 256 * (block >> 2) + 16 * (block & 3)
        boxed = near(splats, n, x, y, near_by)
        found = cull(splats, near_by, boxed, x, y, kept)
        counts[0] += n
        load_block(pixels, here, new)
        for start in range(0, found, SEGMENT):
            end = min(start + SEGMENT, found)
            live = list_live(new, x, y, state, live_x, live_y, live_pixel)
            if live == 0:
                break
            steps = (live * (end - start)) & IN_SURVIVORS
            one = np.int32(start)
            other = np.int32(end - 1)
            count = find_survivors(
                splats, kept, one, other, live_x, live_y, live_pixel, steps, powers, survivors
            )
            counts[1] += steps
            counts[2] += count
            blend_survivors(splats, powers, survivors, count, state, new)
        store_block(new, pixels, here)
    if last != 0:
        over_white(pixels)


@numba.njit
def blend_all(splats, kept, first, last, live_x, live_y, live_pixel, steps, state, new):
    """Takes exp of splats kept[first] to kept[last] at each live pixel, and blends what counts:
    pixels from `state` to `new`.
    """
    t = ZERO
    left = ZERO
    r = ZERO
    g = ZERO
    b = ZERO
    q = np.int32(0)
    j = first
    for _ in range(steps):
        o = kept[j & IN_LIST] & PLACES
        k = q & IN_BLOCK
        p = live_pixel[k] & IN_BLOCK
        dx = splats[o] - live_x[k]
        dy = splats[o + 1] - live_y[k]
        power = (
            -HALF * (splats[o + 2] * dx * dx + splats[o + 4] * dy * dy) - splats[o + 3] * dx * dy
        )
        if j == first:
            r = state[4 * p]
            g = state[4 * p + 1]
            b = state[4 * p + 2]
            t = state[4 * p + 3]
            left = t
        alpha = min(ALPHA_MAX, splats[o + 5] * math.exp(power))
        if power > ZERO or alpha < ALPHA_MIN:
            alpha = ZERO
        weight = alpha * t
        t *= ONE - alpha
        # Once below it stays below: what has become of t then no longer counts.
        if t >= TRANSMITTANCE_MIN:
            r += splats[o + 7] * weight
            g += splats[o + 8] * weight
            b += splats[o + 9] * weight
            left = t
        else:
            left = -abs(left)
        new[4 * p] = r
        new[4 * p + 1] = g
        new[4 * p + 2] = b
        new[4 * p + 3] = left
        if j == last:
            j = first
            q = np.int32(q + 1)
        else:
            j = np.int32(j + 1)


@vividc.kernel(
    "void(float32[::1], float32[::1], int32[::1], int32, float32, float32, int32, int32, int32)"
)
def blend_blocks(splats, pixels, counts, n, x0, y0, height, first, last):
    """As `blend_lookahead`, but only blocks are culled: exp is taken of every exponent."""
    near_by = np.empty(LIST_PART, np.int32)
    kept = np.empty(LIST_PART, np.int32)
    live_x = np.empty(BLOCK, np.float32)
    live_y = np.empty(BLOCK, np.float32)
    live_pixel = np.empty(BLOCK, np.int32)
    state = np.empty(4 * BLOCK, np.float32)
    new = np.empty(4 * BLOCK, np.float32)
    if first != 0:
        clear_pixels(pixels)
    for block in range(4 * (height + 3 >> 2)):
        x = x0 + np.float32(np.int32(SIDE * (block & 3)))
        y = y0 + np.float32(np.int32(SIDE * (block >> 2)))
        here = 256 * (block >> 2) + 16 * (block & 3)
        boxed = near(splats, n, x, y, near_by)
        found = cull(splats, near_by, boxed, x, y, kept)
        counts[0] += n
        load_block(pixels, here, new)
        for start in range(0, found, SEGMENT):
            end = min(start + SEGMENT, found)
            live = list_live(new, x, y, state, live_x, live_y, live_pixel)
            if live == 0:
                break
            steps = (live * (end - start)) & IN_SURVIVORS
            one = np.int32(start)
            other = np.int32(end - 1)
            blend_all(splats, kept, one, other, live_x, live_y, live_pixel, steps, state, new)
            counts[1] += steps
        store_block(new, pixels, here)
    if last != 0:
        over_white(pixels)


@numba.njit
def blend_pixel(splats, n, px, py, pixels, place):
    """Blends splats over one pixel; how many were looked at."""
    r = pixels[place]
    g = pixels[place + 1]
    b = pixels[place + 2]
    t = pixels[place + 3]
    if t < ZERO:
        return np.int32(0)
    done = ONE
    looked = np.int32(0)
    for k in range(n):
        o = (SPLAT_WORDS * k) & PLACES
        looked = np.int32(looked + 1)
        dx = splats[o] - px
        dy = splats[o + 1] - py
        power = (
            -HALF * (splats[o + 2] * dx * dx + splats[o + 4] * dy * dy) - splats[o + 3] * dx * dy
        )
        if power > ZERO:
            continue
        alpha = min(ALPHA_MAX, splats[o + 5] * math.exp(power))
        if alpha < ALPHA_MIN:
            continue
        left = t * (ONE - alpha)
        if left < TRANSMITTANCE_MIN:
            done = -ONE
            break
        weight = alpha * t
        r += splats[o + 7] * weight
        g += splats[o + 8] * weight
        b += splats[o + 9] * weight
        t = left
    pixels[place] = r
    pixels[place + 1] = g
    pixels[place + 2] = b
    pixels[place + 3] = t * done
    return looked


@vividc.kernel(
    "void(float32[::1], float32[::1], int32[::1], int32, float32, float32, int32, int32, int32)"
)
def blend_late(splats, pixels, counts, n, x0, y0, height, first, last):
    """As `blend_lookahead`, but nothing is culled: every pixel tests alpha, as in the original."""
    if first != 0:
        clear_pixels(pixels)
    for p in range(16 * height):
        px = x0 + np.float32(np.int32(p & 15))
        py = y0 + np.float32(np.int32(p >> 4))
        counts[1] += blend_pixel(splats, n, px, py, pixels, 4 * p & IN_PIXELS)
    if last != 0:
        over_white(pixels)

"""Blending of 3D Gaussian Splatting (Kerbl et al. 2023) for one screen tile of 16x16 pixels: with
the late test of alpha (`blend_late`), and with Lookahead Culling II, which decides on the exponent
before exp: for blocks of 4x4 pixels (`blend_blocks`), and then for each pixel (`blend_lookahead`).

A run takes a part of the tile's depth-sorted list, already in the scratchpad, and carries colour
and transmittance on: lists of any length are blended part by part. All three give the same picture
to the last bit.

A row of `splats` is centre x, y; conic a, b, c; opacity; the least exponent that counts; r, g, b;
half the width and height of the box around all blocks in which it may be seen, and how far from the
middle of such a block it may be, in its own norm, squared. A row of `pixels` is r, g, b,
transmittance, which is negative once the pixel is done; blocks of 4x4 pixels lie one behind the
other.
"""

import math

import numba
import numpy as np

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
ALPHA_MAX = np.float32(0.99)
ALPHA_MIN = np.float32(1.0 / 255.0)
TRANSMITTANCE_MIN = np.float32(1e-4)
HALF_REACH = np.float32(1.5)

SPLAT_WORDS = 13
SIDE = 4
BLOCK = 16
SEGMENT = 48
LIST_PART = 160
SURVIVORS = 768
# Masks that change nothing: they tell the compiler that an index is small and not negative.
PLACES = 4095
IN_LIST = 255
IN_SURVIVORS = 1023
IN_BLOCK = 15
IN_TWO_BLOCKS = 31
IN_PIXELS = 1023


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
def cull(splats, n, x, y, kept):
    """Places of the splats that may be seen in the block of 4x4 pixels from (x, y); how many.

    A pixel is at most half a block's reach from the middle, in the norm of the conic: by the
    triangle inequality the middle of a block with a visible pixel is not far from the mean.
    """
    middle_x = x + HALF_REACH
    middle_y = y + HALF_REACH
    count = np.int32(0)
    for k in range(n):
        o = (SPLAT_WORDS * k) & PLACES
        dx = splats[o] - middle_x
        dy = splats[o + 1] - middle_y
        b = splats[o + 3] * dy
        form = (splats[o + 2] * dx + TWO * b) * dx + splats[o + 4] * dy * dy
        if (
            abs(dx) <= splats[o + 10]
            and abs(dy) <= splats[o + 11]
            # So that it is kept where something is no number.
            and not form > splats[o + 12]
        ):
            kept[count & IN_LIST] = o
            count = np.int32(count + 1)
    return count & IN_LIST


@numba.njit
def list_live(pixels, here, x, y, state, live_x, live_y, live_pixel):
    """The pixels that are not done of the block from (x, y), which is copied; how many."""
    live = 0
    for p in range(BLOCK):
        o = here + 4 * p
        t = pixels[o + 3]
        state[4 * p] = pixels[o]
        state[4 * p + 1] = pixels[o + 1]
        state[4 * p + 2] = pixels[o + 2]
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

    A survivor is 16 times the splat's place, and the pixel. A pixel is read once for all splats:
    what is not read meets no other access in a bank.
    """
    count = np.int32(0)
    q = np.int32(0)
    j = first
    x = ZERO
    y = ZERO
    p = 0
    for _ in range(steps):
        o = kept[j & IN_LIST] & PLACES
        if j == first:
            k = q & IN_BLOCK
            x = live_x[k]
            y = live_y[k]
            p = live_pixel[k]
        dx = splats[o] - x
        dy = splats[o + 1] - y
        power = (
            -HALF * (splats[o + 2] * dx * dx + splats[o + 4] * dy * dy) - splats[o + 3] * dx * dy
        )
        if power >= splats[o + 6] and power <= ZERO:
            powers[count & IN_SURVIVORS] = power
            survivors[count & IN_SURVIVORS] = 16 * o + p
            count = np.int32(count + 1)
        if j == last:
            j = first
            q = np.int32(q + 1)
        else:
            j = np.int32(j + 1)
    return count & IN_SURVIVORS


@numba.njit
def blend_survivors(splats, powers, survivors, count, state, pixels, here):
    """Takes exp of the survivors, and blends them: pixels of a block from `state` on."""
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
            if before >= 0:
                done = here + 4 * (before & IN_BLOCK)
                pixels[done] = r
                pixels[done + 1] = g
                pixels[done + 2] = b
                pixels[done + 3] = left
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
    if before >= 0:
        done = here + 4 * (before & IN_BLOCK)
        pixels[done] = r
        pixels[done + 1] = g
        pixels[done + 2] = b
        pixels[done + 3] = left


@vividc.kernel(
    "void(float32[::1], float32[::1], int32[::1], int32, float32, float32, int32, int32)"
)
def blend_lookahead(splats, pixels, counts, n, x0, y0, height, last):
    """`counts` gains tests of blocks, exponents, and exps; `last` is not 0 for
    the last part of a list."""
    kept = np.empty(LIST_PART, np.int32)
    live_x = np.empty(BLOCK, np.float32)
    live_y = np.empty(BLOCK, np.float32)
    live_pixel = np.empty(BLOCK, np.int32)
    state = np.empty(4 * BLOCK, np.float32)
    powers = np.empty(SURVIVORS, np.float32)
    survivors = np.empty(SURVIVORS, np.int32)
    for block in range(4 * (height + 3 >> 2)):
        x = x0 + np.float32(np.int32(SIDE * (block & 3)))
        y = y0 + np.float32(np.int32(SIDE * (block >> 2)))
        here = (4 * BLOCK * block) & IN_PIXELS
        found = cull(splats, n, x, y, kept)
        counts[0] += n
        for start in range(0, found, SEGMENT):
            end = min(start + SEGMENT, found)
            live = list_live(pixels, here, x, y, state, live_x, live_y, live_pixel)
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
            blend_survivors(splats, powers, survivors, count, state, pixels, here)
    if last != 0:
        over_white(pixels)


@numba.njit
def blend_all(splats, kept, first, last, live_x, live_y, live_pixel, steps, state, pixels, here):
    """Takes exp of splats kept[first] to kept[last] at each live pixel, and blends what counts:
    pixels of a block from `state` on.
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
        o = here + 4 * p
        pixels[o] = r
        pixels[o + 1] = g
        pixels[o + 2] = b
        pixels[o + 3] = left
        if j == last:
            j = first
            q = np.int32(q + 1)
        else:
            j = np.int32(j + 1)


@vividc.kernel(
    "void(float32[::1], float32[::1], int32[::1], int32, float32, float32, int32, int32)"
)
def blend_blocks(splats, pixels, counts, n, x0, y0, height, last):
    """As `blend_lookahead`, but only blocks are culled: exp is taken of every exponent."""
    kept = np.empty(LIST_PART, np.int32)
    live_x = np.empty(BLOCK, np.float32)
    live_y = np.empty(BLOCK, np.float32)
    live_pixel = np.empty(BLOCK, np.int32)
    state = np.empty(4 * BLOCK, np.float32)
    for block in range(4 * (height + 3 >> 2)):
        x = x0 + np.float32(np.int32(SIDE * (block & 3)))
        y = y0 + np.float32(np.int32(SIDE * (block >> 2)))
        here = (4 * BLOCK * block) & IN_PIXELS
        found = cull(splats, n, x, y, kept)
        counts[0] += n
        for start in range(0, found, SEGMENT):
            end = min(start + SEGMENT, found)
            live = list_live(pixels, here, x, y, state, live_x, live_y, live_pixel)
            if live == 0:
                break
            steps = (live * (end - start)) & IN_SURVIVORS
            one = np.int32(start)
            other = np.int32(end - 1)
            blend_all(
                splats, kept, one, other, live_x, live_y, live_pixel, steps, state, pixels, here
            )
            counts[1] += steps
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
    "void(float32[::1], float32[::1], int32[::1], int32, float32, float32, int32, int32)"
)
def blend_late(splats, pixels, counts, n, x0, y0, height, last):
    """As `blend_lookahead`, but nothing is culled: every pixel tests alpha, as in the original."""
    for p in range(4 * BLOCK * (height + 3 >> 2)):
        px = x0 + np.float32(np.int32(((p >> 2) & 12) + (p & 3)))
        py = y0 + np.float32(np.int32(((p >> 4) & 12) + ((p >> 2) & 3)))
        counts[1] += blend_pixel(splats, n, px, py, pixels, 4 * p & IN_PIXELS)
    if last != 0:
        over_white(pixels)

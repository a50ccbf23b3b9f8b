"""Which blocks of 8x8 pixels see a brick of the occupancy, and between which distances: every brick
is projected as its box, made larger by more than rounding may move a sample.

`view` holds the camera's place (0 to 2), the place of brick (0, 0, 0)'s middle (3 to 5), a brick's
sides (6 to 8) and half of these with slack (9 to 11); the rows of the inverse of the camera's
matrix (12 to 20), and half the sides of a brick's box in the camera's axes, with slack (21 to 23);
pixels a unit of slope (24), the column and row of pixels on the axis (25, 26), the slopes at which
the picture ends (27, 28), and pixels of slack (29).
"""

import math

import numba
import numpy as np

import vividc

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
EIGHTH = np.float32(0.125)
SEVEN = np.float32(7.0)
NEARER = np.float32(1 - 2.0**-18)
FARTHER = np.float32(1 + 2.0**-18)
NOWHERE = np.float32(3e38)
LOW = np.uint32(0xFFFF)
HIGH = np.uint32(16)
AT_ONCE = 128


@numba.njit
def first_block(pixel, blocks):
    """The first block with a pixel at or behind a place, at most `blocks`."""
    place = (pixel - SEVEN) * EIGHTH
    whole = np.int32(min(max(place, ZERO), np.float32(blocks)))
    return whole + 1 if np.float32(whole) < place and whole < blocks else whole


@numba.njit
def last_block(pixel, blocks):
    """The last block with a pixel at or before a place, -1 if there is none."""
    place = min(pixel * EIGHTH, np.float32(blocks - 1))
    return np.int32(place) if place >= ZERO else np.int32(-1)


@numba.njit
def side(low, high, near, far, is_around, scale, middle, slack):
    """The pixels between which a box is that is `low` to `high` aside, and ahead by the inverses of
    `near` to `far`.
    """
    begin = low * (near if low < ZERO else far) * scale + (middle - slack)
    end = high * (near if high > ZERO else far) * scale + (middle + slack)
    return -NOWHERE if is_around else begin, NOWHERE if is_around else end


@numba.njit
def project(view, bricks, begin, end, columns, first_row, rows, spans, depths):
    """List the bricks of a part that some of the rows of blocks see, each with the first and last
    column and row and the least and greatest distance; returns how many.
    """
    found = np.int32(0)
    for number in range(begin, end):
        packed = bricks[number]
        x = view[3] + np.float32(np.int32(packed & np.uint32(2047))) * view[6] - view[0]
        y = view[4] + np.float32(np.int32((packed >> np.uint32(11)) & np.uint32(2047))) * view[7]
        y -= view[1]
        z = view[5] + np.float32(np.int32(packed >> np.uint32(22))) * view[8] - view[2]
        across = view[12] * x + view[13] * y + view[14] * z
        down = ZERO - (view[15] * x + view[16] * y + view[17] * z)
        ahead = ZERO - (view[18] * x + view[19] * y + view[20] * z)
        near, far = ahead - view[23], ahead + view[23]
        # A box that the camera's plane cuts, or all but cuts, is seen by all blocks or none.
        is_around = near < view[23] * EIGHTH
        nearest, farthest = ONE / (view[23] if is_around else near), ONE / max(far, view[23])
        left, right = side(
            *(across - view[21], across + view[21], nearest, farthest, is_around),
            *(view[24], view[25], view[29]),
        )
        top, bottom = side(
            *(down - view[22], down + view[22], nearest, farthest, is_around),
            *(view[24], view[26], view[29]),
        )
        first_column, last_column = first_block(left, columns), last_block(right, columns)
        total = first_row + rows
        first, last = first_block(top, total), last_block(bottom, total)
        first = max(first, first_row)
        is_seen = (far > ZERO) & (first_column <= last_column) & (first <= last)
        in_front = (math.fabs(across) - view[21] <= far * view[27]) & (
            math.fabs(down) - view[22] <= far * view[28]
        )
        if is_seen & in_front:
            away_x, away_y, away_z = math.fabs(x), math.fabs(y), math.fabs(z)
            short_x = max(away_x - view[9], ZERO)
            short_y = max(away_y - view[10], ZERO)
            short_z = max(away_z - view[11], ZERO)
            long_x, long_y, long_z = away_x + view[9], away_y + view[10], away_z + view[11]
            least = math.sqrt(short_x * short_x + short_y * short_y + short_z * short_z)
            most = math.sqrt(long_x * long_x + long_y * long_y + long_z * long_z)
            place = np.uint32(2 * found)
            spans[place] = np.uint32(first_column) | (np.uint32(last_column) << HIGH)
            spans[place + np.uint32(1)] = np.uint32(first - first_row) | (
                np.uint32(last - first_row) << HIGH
            )
            depths[place] = least * NEARER
            depths[place + np.uint32(1)] = most * FARTHER
            found = np.int32(found + 1)
    return found


@numba.njit
def cover(columns, found, spans, depths, nearest, farthest):
    """Widen the distances of all blocks that the listed bricks cover."""
    for number in range(found):
        across, down = spans[2 * number], spans[2 * number + 1]
        least, most = depths[2 * number], depths[2 * number + 1]
        first, width = np.int32(across & LOW), np.int32((across >> HIGH) - (across & LOW)) + 1
        row, height = np.int32(down & LOW), np.int32((down >> HIGH) - (down & LOW)) + 1
        place = np.int32(row * columns + first)
        column = np.int32(0)
        for _ in range(np.int32(width * height)):
            at = np.uint32(place + column)
            nearest[at] = min(nearest[at], least)
            farthest[at] = max(farthest[at], most)
            column += np.int32(1)
            if column == width:
                column = np.int32(0)
                place += columns


@vividc.kernel(
    "void(float32[::1], uint32[::1], int32, int32, int32, uint32[::1], float32[::1], float32[::1],"
    " float32[::1])"
)
def block_depths(view, bricks, columns, first_row, rows, spans, depths, nearest, farthest):
    """Distances between which some rows of blocks, `columns` each, see bricks: `nearest` and
    `farthest`, which is below 0 where they see none.

    `bricks` is x | y << 11 | z << 22 of each; `spans` and `depths` are room for two words of each
    of 128 bricks.
    """
    for block in range(len(nearest)):
        nearest[block] = NOWHERE
        farthest[block] = -ONE
    for part in range(np.int32((len(bricks) + AT_ONCE - 1) // AT_ONCE)):
        begin = np.int32(AT_ONCE * part)
        end = np.int32(min(begin + AT_ONCE, len(bricks)))
        found = project(view, bricks, begin, end, columns, first_row, rows, spans, depths)
        cover(columns, found, spans, depths, nearest, farthest)

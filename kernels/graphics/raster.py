"""Triangles, light on surfaces, and contour lines."""

import math

import numba
import numpy as np
from numba import prange

import vividc

f32 = np.float32

FAR = f32(1e9)
BACKGROUND = (f32(0.10), f32(0.12), f32(0.18))

SEGMENTS = np.array(
    [
        [-1, -1, -1, -1],
        [3, 0, -1, -1],
        [0, 1, -1, -1],
        [3, 1, -1, -1],
        [1, 2, -1, -1],
        [3, 0, 1, 2],
        [0, 2, -1, -1],
        [3, 2, -1, -1],
        [2, 3, -1, -1],
        [2, 0, -1, -1],
        [0, 1, 2, 3],
        [2, 1, -1, -1],
        [1, 3, -1, -1],
        [1, 0, -1, -1],
        [0, 3, -1, -1],
        [-1, -1, -1, -1],
    ],
    np.int32,
)
"""Edges of a cell that a contour joins, by which corners are above it: up to two pairs."""
ALL_ABOVE = 15
TOP, RIGHT, BOTTOM = 0, 1, 2


@numba.njit
def edge(ax, ay, bx, by, px, py):
    """Twice the area of a triangle; above 0 if p is on the right of a to b, y being down."""
    return (bx - ax) * (py - ay) - (by - ay) * (px - ax)


@vividc.kernel(
    "void(float32[:, ::1], float32[:, ::1], int32[:, ::1], float32[:, ::1], float32[:, :, ::1])"
)
def rasterize(vertices, colours, faces, depth, image):
    """Triangles with a depth buffer, their colours interpolated, row by row.

    `vertices` are x and y in pixels and a depth; faces that turn their back are left out.
    """
    height, width = depth.shape
    for y in prange(height):
        for x in range(width):
            depth[y, x] = FAR
            image[y, x, 0] = BACKGROUND[0]
            image[y, x, 1] = BACKGROUND[1]
            image[y, x, 2] = BACKGROUND[2]
        py = f32(y) + f32(0.5)
        for face in range(faces.shape[0]):
            a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
            ax, ay = vertices[a, 0], vertices[a, 1]
            bx, by = vertices[b, 0], vertices[b, 1]
            cx, cy = vertices[c, 0], vertices[c, 1]
            if py < min(ay, by, cy) or py > max(ay, by, cy):
                continue
            area = edge(ax, ay, bx, by, cx, cy)
            if area <= f32(0.0):
                continue
            inverse = f32(1.0) / area
            left = max(np.int32(min(ax, bx, cx)), 0)
            right = min(np.int32(max(ax, bx, cx)), width - 1)
            for x in range(left, right + 1):
                px = f32(x) + f32(0.5)
                u = edge(bx, by, cx, cy, px, py) * inverse
                v = edge(cx, cy, ax, ay, px, py) * inverse
                w = f32(1.0) - u - v
                if u < f32(0.0) or v < f32(0.0) or w < f32(0.0):
                    continue
                z = u * vertices[a, 2] + v * vertices[b, 2] + w * vertices[c, 2]
                if z >= depth[y, x]:
                    continue
                depth[y, x] = z
                for k in range(3):
                    image[y, x, k] = u * colours[a, k] + v * colours[b, k] + w * colours[c, k]


@numba.njit
def normalize(x, y, z):
    inverse = f32(1.0) / math.sqrt(x * x + y * y + z * z)
    return x * inverse, y * inverse, z * inverse


@vividc.kernel("void(float32[:, ::1], float32, float32[:, ::1], float32[::1], float32[:, :, ::1])")
def shade_relief(heights, steepness, tints, light, image):
    """A map: Lambert's light on heights (-1 to 1), which choose a tint; `light` points to it."""
    rows, columns = heights.shape
    last = tints.shape[0] - 1
    for y in prange(rows):
        for x in range(columns):
            east = heights[y, min(x + 1, columns - 1)] - heights[y, max(x - 1, 0)]
            south = heights[min(y + 1, rows - 1), x] - heights[max(y - 1, 0), x]
            nx, ny, nz = normalize(-steepness * east, -steepness * south, f32(1.0))
            lambert = max(nx * light[0] + ny * light[1] + nz * light[2], f32(0.0))
            band = np.int32((heights[y, x] * f32(0.5) + f32(0.5)) * f32(last + 1))
            tint = min(max(band, 0), last)
            for k in range(3):
                image[y, x, k] = tints[tint, k] * (f32(0.25) + f32(0.75) * lambert)


@vividc.kernel("void(float32[:, :, ::1], float32[::1], float32[::1], float32, float32[:, :, ::1])")
def shade_normals(normals, light, colour, shininess, image):
    """Lambert's and Phong's light on a normal map, seen from straight above (Phong 1975)."""
    height, width, _ = normals.shape
    for y in prange(height):
        for x in range(width):
            nx, ny, nz = normals[y, x, 0], normals[y, x, 1], normals[y, x, 2]
            facing = nx * light[0] + ny * light[1] + nz * light[2]
            diffuse = max(facing, f32(0.0))
            highlight = f32(0.0)
            if facing > f32(0.0):
                mirrored = f32(2.0) * facing * nz - light[2]
                if mirrored > f32(0.0):
                    highlight = mirrored**shininess
            for k in range(3):
                shade = colour[k] * (f32(0.15) + f32(0.85) * diffuse) + f32(0.6) * highlight
                image[y, x, k] = min(shade, f32(1.0))


@numba.njit
def crossing(side, corners, level):
    """Where a contour crosses an edge of a cell (0: top, then clockwise): x and y, 0 to 1."""
    a = corners[side]
    t = (level - a) / (corners[(side + 1) & 3] - a)
    if side == TOP:
        return t, f32(0.0)
    if side == RIGHT:
        return f32(1.0), t
    if side == BOTTOM:
        return f32(1.0) - t, f32(1.0)
    return f32(0.0), f32(1.0) - t


@vividc.kernel("int32(float32[:, ::1], float32, float32[:, ::1])")
def marching_squares(field, level, segments):
    """Contour lines of a field: x0, y0, x1, y1 of each piece; how many there are."""
    found = 0
    corners = np.empty(4, np.float32)
    for y in range(field.shape[0] - 1):
        for x in range(field.shape[1] - 1):
            corners[0] = field[y, x]
            corners[1] = field[y, x + 1]
            corners[2] = field[y + 1, x + 1]
            corners[3] = field[y + 1, x]
            case = 0
            for k in range(4):
                if corners[k] > level:
                    case |= 1 << k
            if case in (0, ALL_ABOVE):
                continue
            for k in range(0, 4, 2):
                side = SEGMENTS[case, k]
                if side < 0:
                    break
                x0, y0 = crossing(side, corners, level)
                x1, y1 = crossing(SEGMENTS[case, k + 1], corners, level)
                segments[found, 0] = f32(x) + x0
                segments[found, 1] = f32(y) + y0
                segments[found, 2] = f32(x) + x1
                segments[found, 3] = f32(y) + y1
                found += 1
    return np.int32(found)


@vividc.kernel("void(float32[:, ::1], int32, float32, uint8, uint8[:, ::1])")
def draw_segments(segments, count, scale, tone, image):
    """Lines drawn in steps of a pixel at most along the longer axis."""
    height, width = image.shape
    for i in range(count):
        x = segments[i, 0] * scale
        y = segments[i, 1] * scale
        dx = segments[i, 2] * scale - x
        dy = segments[i, 3] * scale - y
        steps = np.int32(max(abs(dx), abs(dy))) + 1
        inverse = f32(1.0) / f32(steps)
        for k in range(steps + 1):
            t = f32(k) * inverse
            column = np.int32(x + t * dx + f32(0.5))
            row = np.int32(y + t * dy + f32(0.5))
            if 0 <= row < height and 0 <= column < width:
                image[row, column] = tone

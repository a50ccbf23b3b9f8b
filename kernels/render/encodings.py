"""What networks are fed with: sines (NeRF), a hash grid (Instant-NGP), factors (TensoRF)."""

import math

import numpy as np

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
LARGEST_ANGLE = np.float32(65536.0)

PRIME_Y = np.uint32(2654435761)
PRIME_Z = np.uint32(805459861)

# Degree 4 (16 values) in the order and signs of tiny-cuda-nn.
Y0 = np.float32(0.28209479177387814)
Y1 = np.float32(0.48860251190291987)
Y2_XY = np.float32(1.0925484305920792)
Y2_ZZ = np.float32(0.94617469575755997)
Y2_Z0 = np.float32(0.31539156525251999)
Y2_XX = np.float32(0.54627421529603959)
Y3_XXY = np.float32(0.59004358992664352)
Y3_XYZ = np.float32(2.8906114426405538)
Y3_YZZ = np.float32(0.45704579946446572)
Y3_ZZZ = np.float32(0.3731763325901154)
Y3_XXZ = np.float32(1.4453057213202769)
THREE = np.float32(3.0)
FIVE = np.float32(5.0)


@vividc.kernel("void(float32[:, ::1], int32, float32[:, ::1])")
def positional_encoding(points, frequencies, out):
    """x, sin x, cos x, sin 2x, cos 2x, ... of 3-vectors (Mildenhall et al. 2020), by threes.

    Angles are clamped to 2**16 radians, where a float32 has no phase left worth encoding; a
    bounded angle needs no long reduction.
    """
    for i in range(points.shape[0]):
        for axis in range(3):
            out[i, axis] = points[i, axis]
        scale = ONE
        for level in range(frequencies):
            for axis in range(3):
                angle = scale * points[i, axis]
                angle = min(max(angle, -LARGEST_ANGLE), LARGEST_ANGLE)
                out[i, 3 + 6 * level + axis] = math.sin(angle)
                out[i, 6 + 6 * level + axis] = math.cos(angle)
            scale *= TWO


@vividc.kernel("void(float32[:, ::1], float32, uint32, float32[:, ::1], float32[:, ::1])")
def hash_level(points, scale, mask, table, out):
    """Two features of one hashed level of a grid (Mueller et al. 2022), trilinear; the table has
    `mask` + 1 rows.
    """
    for i in range(points.shape[0]):
        x = points[i, 0] * scale + HALF
        y = points[i, 1] * scale + HALF
        z = points[i, 2] * scale + HALF
        cell_x = np.uint32(x)
        cell_y = np.uint32(y)
        cell_z = np.uint32(z)
        fx = x - np.float32(cell_x)
        fy = y - np.float32(cell_y)
        fz = z - np.float32(cell_z)
        first = ZERO
        second = ZERO
        for corner in range(8):
            dx = np.uint32(corner & 1)
            dy = np.uint32((corner >> 1) & 1)
            dz = np.uint32(corner >> 2)
            hashed = (cell_x + dx) ^ ((cell_y + dy) * PRIME_Y) ^ ((cell_z + dz) * PRIME_Z)
            row = np.int32(hashed & mask)
            weight = (fx if dx else ONE - fx) * (fy if dy else ONE - fy) * (fz if dz else ONE - fz)
            first += weight * table[row, 0]
            second += weight * table[row, 1]
        out[i, 0] = first
        out[i, 1] = second


@vividc.kernel("void(float32[:, ::1], float32, int32, float32[:, ::1], float32[:, ::1])")
def dense_level(points, scale, resolution, table, out):
    """Two features of one dense level of a grid, trilinear; row x + y res + z res^2."""
    for i in range(points.shape[0]):
        x = points[i, 0] * scale + HALF
        y = points[i, 1] * scale + HALF
        z = points[i, 2] * scale + HALF
        cell_x = np.int32(x)
        cell_y = np.int32(y)
        cell_z = np.int32(z)
        fx = x - np.float32(cell_x)
        fy = y - np.float32(cell_y)
        fz = z - np.float32(cell_z)
        base = cell_x + resolution * (cell_y + resolution * cell_z)
        rows = table.shape[0]
        for feature in range(2):
            total = ZERO
            for corner in range(8):
                dx = corner & 1
                dy = (corner >> 1) & 1
                dz = corner >> 2
                row = np.int32(base + dx + resolution * (dy + resolution * dz))
                if row >= rows:
                    row = np.int32(row - rows)
                weight_x = fx if dx else ONE - fx
                weight_y = fy if dy else ONE - fy
                weight_z = fz if dz else ONE - fz
                total += weight_x * weight_y * weight_z * table[row, feature]
            out[i, feature] = total


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def sh_direction(directions, out):
    """16 spherical harmonics of unit directions, as Instant-NGP's colour network takes them."""
    for i in range(directions.shape[0]):
        x = directions[i, 0]
        y = directions[i, 1]
        z = directions[i, 2]
        xy = x * y
        xx = x * x
        yy = y * y
        zz = z * z
        out[i, 0] = Y0
        out[i, 1] = -Y1 * y
        out[i, 2] = Y1 * z
        out[i, 3] = -Y1 * x
        out[i, 4] = Y2_XY * xy
        out[i, 5] = -Y2_XY * (y * z)
        out[i, 6] = Y2_ZZ * zz - Y2_Z0
        out[i, 7] = -Y2_XY * (x * z)
        out[i, 8] = Y2_XX * (xx - yy)
        out[i, 9] = Y3_XXY * y * (yy - THREE * xx)
        out[i, 10] = Y3_XYZ * xy * z
        out[i, 11] = Y3_YZZ * y * (ONE - FIVE * zz)
        out[i, 12] = Y3_ZZZ * z * (FIVE * zz - THREE)
        out[i, 13] = Y3_YZZ * x * (ONE - FIVE * zz)
        out[i, 14] = Y3_XXZ * z * (xx - yy)
        out[i, 15] = Y3_XXY * x * (THREE * yy - xx)


@vividc.kernel("void(float32[:, ::1], float32[:, :, ::1], float32[:, ::1], float32[::1])")
def vm_density(points, plane, line, out):
    """Sum over the components of one plane (bilinear) times its line (linear) of a vector-matrix
    decomposition (Chen et al. 2022); points are in grid units, within the grid.
    """
    for i in range(points.shape[0]):
        u = points[i, 0]
        v = points[i, 1]
        w = points[i, 2]
        column = min(np.int32(u), plane.shape[2] - 2)
        row = min(np.int32(v), plane.shape[1] - 2)
        node = min(np.int32(w), line.shape[1] - 2)
        fu = u - np.float32(np.int32(column))
        fv = v - np.float32(np.int32(row))
        fw = w - np.float32(np.int32(node))
        total = ZERO
        for c in range(plane.shape[0]):
            top = plane[c, row, column] * (ONE - fu) + plane[c, row, column + 1] * fu
            bottom = plane[c, row + 1, column] * (ONE - fu) + plane[c, row + 1, column + 1] * fu
            along = line[c, node] * (ONE - fw) + line[c, node + 1] * fw
            total += (top * (ONE - fv) + bottom * fv) * along
        out[i] += total

"""3D Gaussian Splatting before blending (Kerbl et al. 2023): projection, colour, tiles and sorting.

The projection is that of Zwicker et al., EWA Volume Splatting (2001). Cameras look along +z, y
down; pixel (0, 0) has its centre at 0.
"""

import math

import numpy as np

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE = np.float32(3.0)
FOUR = np.float32(4.0)

NEAR_DEPTH = np.float32(0.2)
LOW_PASS = np.float32(0.3)
MIN_SPREAD = np.float32(0.1)
TILE_SHIFT = 4
LAST_IN_TILE = 15

# Real spherical harmonics (Sloan 2008, appendix A2).
Y0 = np.float32(0.28209479177387814)
Y1 = np.float32(0.4886025119029199)
Y2_XY = np.float32(1.0925484305920792)
Y2_ZZ = np.float32(0.31539156525252005)
Y2_XX = np.float32(0.5462742152960396)
Y3_XXY = np.float32(0.5900435899266435)
Y3_XYZ = np.float32(2.890611442640554)
Y3_YZZ = np.float32(0.4570457994644658)
Y3_ZZZ = np.float32(0.3731763325901154)
Y3_XXZ = np.float32(1.445305721320277)


@vividc.kernel(
    "void(float32[:, ::1], float32[:, ::1], float32, float32, float32, float32[:, ::1],"
    " float32[::1])"
)
def project_means(means, view, focal, centre_x, centre_y, pixel, depth):
    """Centres in pixels and their depths; `view` is [3, 4], world to camera."""
    for i in range(means.shape[0]):
        x = means[i, 0]
        y = means[i, 1]
        z = means[i, 2]
        view_x = view[0, 0] * x + view[0, 1] * y + view[0, 2] * z + view[0, 3]
        view_y = view[1, 0] * x + view[1, 1] * y + view[1, 2] * z + view[1, 3]
        view_z = view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3]
        depth[i] = view_z
        if view_z <= NEAR_DEPTH:
            continue
        inverse = ONE / view_z
        pixel[i, 0] = focal * (view_x * inverse) + centre_x
        pixel[i, 1] = focal * (view_y * inverse) + centre_y


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def covariance_3d(scales, rotations, covariance):
    """R S S^T R^T as xx, xy, xz, yy, yz, zz; `rotations` are unit quaternions w, x, y, z."""
    for i in range(scales.shape[0]):
        w = rotations[i, 0]
        x = rotations[i, 1]
        y = rotations[i, 2]
        z = rotations[i, 3]
        a = scales[i, 0]
        b = scales[i, 1]
        c = scales[i, 2]
        m00 = a * (ONE - TWO * (y * y + z * z))
        m01 = b * (TWO * (x * y - w * z))
        m02 = c * (TWO * (x * z + w * y))
        m10 = a * (TWO * (x * y + w * z))
        m11 = b * (ONE - TWO * (x * x + z * z))
        m12 = c * (TWO * (y * z - w * x))
        m20 = a * (TWO * (x * z - w * y))
        m21 = b * (TWO * (y * z + w * x))
        m22 = c * (ONE - TWO * (x * x + y * y))
        covariance[i, 0] = m00 * m00 + m01 * m01 + m02 * m02
        covariance[i, 1] = m00 * m10 + m01 * m11 + m02 * m12
        covariance[i, 2] = m00 * m20 + m01 * m21 + m02 * m22
        covariance[i, 3] = m10 * m10 + m11 * m11 + m12 * m12
        covariance[i, 4] = m10 * m20 + m11 * m21 + m12 * m22
        covariance[i, 5] = m20 * m20 + m21 * m21 + m22 * m22


@vividc.kernel(
    "void(float32[:, ::1], float32[:, ::1], float32[:, ::1], float32, float32, float32,"
    " float32[:, ::1])"
)
def covariance_2d(means, covariance, view, focal, limit_x, limit_y, out):
    """J W Sigma W^T J^T with the low-pass, as xx, xy, yy in pixel^2; the limits clamp x/z, y/z."""
    for i in range(means.shape[0]):
        x = means[i, 0]
        y = means[i, 1]
        z = means[i, 2]
        view_z = view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3]
        inverse = ONE / max(view_z, NEAR_DEPTH)
        slope_x = (view[0, 0] * x + view[0, 1] * y + view[0, 2] * z + view[0, 3]) * inverse
        slope_y = (view[1, 0] * x + view[1, 1] * y + view[1, 2] * z + view[1, 3]) * inverse
        slope_x = min(max(slope_x, -limit_x), limit_x)
        slope_y = min(max(slope_y, -limit_y), limit_y)
        scale = focal * inverse
        # The rows of J W.
        u0 = scale * (view[0, 0] - slope_x * view[2, 0])
        u1 = scale * (view[0, 1] - slope_x * view[2, 1])
        u2 = scale * (view[0, 2] - slope_x * view[2, 2])
        v0 = scale * (view[1, 0] - slope_y * view[2, 0])
        v1 = scale * (view[1, 1] - slope_y * view[2, 1])
        v2 = scale * (view[1, 2] - slope_y * view[2, 2])
        xx = covariance[i, 0]
        xy = covariance[i, 1]
        xz = covariance[i, 2]
        yy = covariance[i, 3]
        yz = covariance[i, 4]
        zz = covariance[i, 5]
        p0 = xx * u0 + xy * u1 + xz * u2
        p1 = xy * u0 + yy * u1 + yz * u2
        p2 = xz * u0 + yz * u1 + zz * u2
        q0 = xx * v0 + xy * v1 + xz * v2
        q1 = xy * v0 + yy * v1 + yz * v2
        q2 = xz * v0 + yz * v1 + zz * v2
        out[i, 0] = u0 * p0 + u1 * p1 + u2 * p2 + LOW_PASS
        out[i, 1] = v0 * p0 + v1 * p1 + v2 * p2
        out[i, 2] = v0 * q0 + v1 * q1 + v2 * q2 + LOW_PASS


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[::1])")
def conic_and_radius(covariance, conic, radius):
    """The inverse of each 2D covariance, and three standard deviations in whole pixels."""
    for i in range(covariance.shape[0]):
        xx = covariance[i, 0]
        xy = covariance[i, 1]
        yy = covariance[i, 2]
        determinant = xx * yy - xy * xy
        if determinant <= ZERO:
            radius[i] = ZERO
            continue
        inverse = ONE / determinant
        conic[i, 0] = yy * inverse
        conic[i, 1] = -xy * inverse
        conic[i, 2] = xx * inverse
        middle = HALF * (xx + yy)
        spread = math.sqrt(max(MIN_SPREAD, middle * middle - determinant))
        radius[i] = np.ceil(THREE * math.sqrt(middle + spread))


@vividc.kernel("void(float32[:, ::1], float32[:, :, ::1], float32[:, ::1])")
def sh_colour(directions, sh, colour):
    """Colour of spherical harmonics of degree 3, [n, 16, 3], seen along unit directions."""
    for i in range(directions.shape[0]):
        x = directions[i, 0]
        y = directions[i, 1]
        z = directions[i, 2]
        xx = x * x
        yy = y * y
        zz = z * z
        y1 = -Y1 * y
        y2 = Y1 * z
        y3 = -Y1 * x
        y4 = Y2_XY * (x * y)
        y5 = -Y2_XY * (y * z)
        y6 = Y2_ZZ * (TWO * zz - xx - yy)
        y7 = -Y2_XY * (x * z)
        y8 = Y2_XX * (xx - yy)
        y9 = -Y3_XXY * y * (THREE * xx - yy)
        y10 = Y3_XYZ * (x * y) * z
        y11 = -Y3_YZZ * y * (FOUR * zz - xx - yy)
        y12 = Y3_ZZZ * z * (TWO * zz - THREE * xx - THREE * yy)
        y13 = -Y3_YZZ * x * (FOUR * zz - xx - yy)
        y14 = Y3_XXZ * z * (xx - yy)
        y15 = -Y3_XXY * x * (xx - THREE * yy)
        for c in range(3):
            low = Y0 * sh[i, 0, c] + y1 * sh[i, 1, c] + y2 * sh[i, 2, c] + y3 * sh[i, 3, c]
            middle = y4 * sh[i, 4, c] + y5 * sh[i, 5, c] + y6 * sh[i, 6, c] + y7 * sh[i, 7, c]
            middle += y8 * sh[i, 8, c]
            high = y9 * sh[i, 9, c] + y10 * sh[i, 10, c] + y11 * sh[i, 11, c]
            high += y12 * sh[i, 12, c] + y13 * sh[i, 13, c] + y14 * sh[i, 14, c]
            high += y15 * sh[i, 15, c]
            colour[i, c] = max(ZERO, low + middle + high + HALF)


@vividc.kernel("void(float32[:, ::1], float32[::1], int32, int32, int32[:, ::1], int32[::1])")
def tile_bounds(pixel, radius, columns, rows, bounds, copies):
    """First column and row of screen tiles that a square footprint meets, one past the last, and
    how many tiles that is. The far edge, centre + radius, is not part of the footprint.
    """
    for i in range(pixel.shape[0]):
        reach = np.int32(radius[i])
        x = np.int32(np.floor(pixel[i, 0]))
        y = np.int32(np.floor(pixel[i, 1]))
        first_x = min(max((x - reach) >> TILE_SHIFT, 0), columns)
        first_y = min(max((y - reach) >> TILE_SHIFT, 0), rows)
        last_x = min(max((x + reach + LAST_IN_TILE) >> TILE_SHIFT, 0), columns)
        last_y = min(max((y + reach + LAST_IN_TILE) >> TILE_SHIFT, 0), rows)
        bounds[i, 0] = first_x
        bounds[i, 1] = first_y
        bounds[i, 2] = last_x
        bounds[i, 3] = last_y
        area = (last_x - first_x) * (last_y - first_y)
        copies[i] = area if reach > 0 else 0


@vividc.kernel(
    "int32(int32[:, ::1], int32[::1], uint32[::1], int32, uint32[::1], uint32[::1], int32[::1])"
)
def tile_entries(bounds, copies, depth_bits, columns, tiles, depths, splats):
    """One entry for each tile a splat meets: tile, bits of the depth, splat. Returns how many."""
    count = 0
    for i in range(bounds.shape[0]):
        if copies[i] == 0:
            continue
        for y in range(bounds[i, 1], bounds[i, 3]):
            for x in range(bounds[i, 0], bounds[i, 2]):
                tiles[count] = np.uint32(y * columns + x)
                depths[count] = depth_bits[i]
                splats[count] = i
                count += 1
    return count


@vividc.kernel("void(uint32[::1], int32, int32[::1])")
def radix_histogram(keys, shift, counts):
    """How often each digit of 4 bits occurs."""
    for digit in range(16):
        counts[digit] = 0
    for i in range(len(keys)):
        counts[(keys[i] >> np.uint32(shift)) & np.uint32(15)] += 1


@vividc.kernel("void(int32[::1])")
def radix_offsets(counts):
    """Exclusive prefix sum in place: where the entries of each digit begin."""
    total = 0
    for digit in range(len(counts)):
        count = counts[digit]
        counts[digit] = total
        total += count


@vividc.kernel("void(uint32[::1], int32[::1], int32, int32[::1], uint32[::1], int32[::1])")
def radix_scatter(keys, values, shift, offsets, sorted_keys, sorted_values):
    """One stable pass of a radix sort; `offsets` are used up."""
    for i in range(len(keys)):
        digit = (keys[i] >> np.uint32(shift)) & np.uint32(15)
        position = offsets[digit]
        offsets[digit] = position + 1
        sorted_keys[position] = keys[i]
        sorted_values[position] = values[i]


@vividc.kernel("void(uint32[::1], int32[:, ::1])")
def tile_ranges(tiles, ranges):
    """First entry of each tile and one past its last, from the sorted tiles."""
    last = len(tiles) - 1
    for i in range(len(tiles)):
        tile = tiles[i]
        if i == 0 or tiles[i - 1] != tile:
            ranges[tile, 0] = i
        if i == last or tiles[i + 1] != tile:
            ranges[tile, 1] = i + 1

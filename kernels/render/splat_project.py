"""What 3D Gaussian Splatting (Kerbl et al. 2023) does before sorting: EWA projection (Zwicker et
al. 2001), footprints and bounds in screen tiles of 16x16 pixels, and colour of what is seen.

Cameras look along +z, y down; pixel (0, 0) has its centre at 0.
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
THREE = np.float32(3.0)
FOUR = np.float32(4.0)

NEAR_DEPTH = np.float32(0.2)
LOW_PASS = np.float32(0.3)
MIN_SPREAD = np.float32(0.1)
A_TILE = np.float32(1.0 / 16.0)
LAST_IN_TILE = np.float32(15.0)
OPACITY_MIN = np.float32(1.0 / 255.0)
LOG_OPACITY_MIN = np.float32(-5.541263545158426)
NEVER = np.float32(1e30)
LARGEST = np.float32(3e38)
# Minus half the exponent's bits of a first guess of 1 / sqrt(x).
INVERSE_ROOT = 0x5F3759DF
ONE_AND_HALF = np.float32(1.5)
# Twice the exponent, and a little more; what the conic's rounding adds; half a block of 4x4 pixels.
BOX_SLACK = np.float32(2.002)
BOX_SKEW = np.float32(1e-5)
LARGEST_SKEW = np.float32(1e4)
BLOCK_MARGIN = np.float32(1.51)
SMALLEST = np.float32(1e-6)

ROW_WORDS = 13
ENTRY_WORDS = 3
SMALL_ROW = 16383
SMALL_ENTRY = 4095

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


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[:, ::1])")
def splat_covariance(geometry, camera, placed):
    """Centres in front of the camera and 2D covariances, with the low-pass, in pixel^2.

    A row of `geometry` is centre x, y, z; standard deviations along the axes; unit quaternion w, x,
    y, z. `camera` is world to view [3, 4], focal length, the limits of x/z and y/z, and the
    image's centre. A row of `placed` is pixel x, y, depth and covariance xx, xy, yy.
    """
    focal = camera[12]
    limit_x = camera[13]
    limit_y = camera[14]
    for i in range(geometry.shape[0]):
        x = geometry[i, 0]
        y = geometry[i, 1]
        z = geometry[i, 2]
        view_x = camera[0] * x + camera[1] * y + camera[2] * z + camera[3]
        view_y = camera[4] * x + camera[5] * y + camera[6] * z + camera[7]
        view_z = camera[8] * x + camera[9] * y + camera[10] * z + camera[11]
        inverse = ONE / max(view_z, NEAR_DEPTH)
        slope_x = view_x * inverse
        slope_y = view_y * inverse
        placed[i, 0] = focal * slope_x + camera[15]
        placed[i, 1] = focal * slope_y + camera[16]
        placed[i, 2] = view_z
        slope_x = min(max(slope_x, -limit_x), limit_x)
        slope_y = min(max(slope_y, -limit_y), limit_y)
        scale = focal * inverse
        # The rows of J W.
        u0 = scale * (camera[0] - slope_x * camera[8])
        u1 = scale * (camera[1] - slope_x * camera[9])
        u2 = scale * (camera[2] - slope_x * camera[10])
        v0 = scale * (camera[4] - slope_y * camera[8])
        v1 = scale * (camera[5] - slope_y * camera[9])
        v2 = scale * (camera[6] - slope_y * camera[10])
        # The columns of R S.
        qw = geometry[i, 6]
        qx = geometry[i, 7]
        qy = geometry[i, 8]
        qz = geometry[i, 9]
        a = geometry[i, 3]
        b = geometry[i, 4]
        c = geometry[i, 5]
        m00 = a * (ONE - TWO * (qy * qy + qz * qz))
        m01 = b * (TWO * (qx * qy - qw * qz))
        m02 = c * (TWO * (qx * qz + qw * qy))
        m10 = a * (TWO * (qx * qy + qw * qz))
        m11 = b * (ONE - TWO * (qx * qx + qz * qz))
        m12 = c * (TWO * (qy * qz - qw * qx))
        m20 = a * (TWO * (qx * qz - qw * qy))
        m21 = b * (TWO * (qy * qz + qw * qx))
        m22 = c * (ONE - TWO * (qx * qx + qy * qy))
        across0 = u0 * m00 + u1 * m10 + u2 * m20
        across1 = u0 * m01 + u1 * m11 + u2 * m21
        across2 = u0 * m02 + u1 * m12 + u2 * m22
        down0 = v0 * m00 + v1 * m10 + v2 * m20
        down1 = v0 * m01 + v1 * m11 + v2 * m21
        down2 = v0 * m02 + v1 * m12 + v2 * m22
        placed[i, 3] = across0 * across0 + across1 * across1 + across2 * across2 + LOW_PASS
        placed[i, 4] = across0 * down0 + across1 * down1 + across2 * down2
        placed[i, 5] = down0 * down0 + down1 * down1 + down2 * down2 + LOW_PASS


@numba.njit
def nearly_root(x):
    """The square root of a positive x to one part in 10^5: Newton's method for its inverse."""
    guess = bitcast_f32(INVERSE_ROOT - (bitcast_i32(x) >> 1))
    half = HALF * x
    guess = guess * (ONE_AND_HALF - half * guess * guess)
    return x * (guess * (ONE_AND_HALF - half * guess * guess))


@numba.njit
def squared(x):
    """x times x."""
    return x * x


@numba.njit
def three_deviations(xx, yy, determinant):
    """Of a covariance along its longer axis, in whole pixels."""
    middle = HALF * (xx + yy)
    spread = math.sqrt(max(MIN_SPREAD, middle * middle - determinant))
    return np.ceil(THREE * math.sqrt(middle + spread))


@numba.njit
def write_splat(splats, o, x, y, a, b, c, peak, least, across, down, far):
    """A row but for its colour."""
    splats[o] = x
    splats[o + 1] = y
    splats[o + 2] = a
    splats[o + 3] = b
    splats[o + 4] = c
    splats[o + 5] = peak
    splats[o + 6] = least
    splats[o + 10] = across
    splats[o + 11] = down
    splats[o + 12] = far


@numba.njit
def write_entry(entries, e, bounds, slot, bits):
    """What is sorted."""
    entries[e] = bounds
    entries[e + 1] = slot
    entries[e + 2] = bits


@vividc.kernel(
    "int32(float32[:, ::1], float32[:, ::1], float32, int32, int32, int32,"
    " float32[::1], int32[::1], int32[::1], int32[::1])"
)
def splat_footprints(
    placed, opacity, margin, columns, rows, first, splats, entries, sources, depths
):
    """The splats whose footprint meets the image, one behind the other; how many.

    A row of `splats` is as in `splat_blend`, its colour still to come; of `entries` the bounds in
    screen tiles (first row, last, first column, last, a byte each, lasts excluded), number of the
    row of `splats` if the first is `first`, bits of the depth. `sources` are rows of `placed`,
    `depths` the least and largest bits.
    """
    wide = np.float32(columns)
    high = np.float32(rows)
    count = np.int32(0)
    nearest = np.int32(0x7FFFFFFF)
    farthest = np.int32(0)
    for i in range(placed.shape[0]):
        x = placed[i, 0]
        y = placed[i, 1]
        depth = placed[i, 2]
        xx = placed[i, 3]
        xy = placed[i, 4]
        yy = placed[i, 5]
        determinant = xx * yy - xy * xy
        usable = depth > NEAR_DEPTH and determinant > ZERO and determinant < LARGEST
        inverse = ONE / determinant
        radius = three_deviations(xx, yy, determinant)
        first_x = np.int32(min(max((x - radius) * A_TILE, ZERO), wide))
        first_y = np.int32(min(max((y - radius) * A_TILE, ZERO), high))
        last_x = np.int32(min(max((x + radius + LAST_IN_TILE) * A_TILE, ZERO), wide))
        last_y = np.int32(min(max((y + radius + LAST_IN_TILE) * A_TILE, ZERO), high))
        seen = last_x > first_x and last_y > first_y
        if usable and seen and radius < LARGEST:
            a = yy * inverse
            b = -xy * inverse
            c = xx * inverse
            peak = opacity[i, 0]
            least = LOG_OPACITY_MIN - math.log(max(peak, OPACITY_MIN)) - margin
            # A box around all that may be seen, and by how much the conic's rounding may move it.
            skew = xx * yy * inverse
            reach = max(-least, ZERO) * (BOX_SLACK + BOX_SKEW * skew) + SMALLEST
            across = nearly_root(reach * xx) + BLOCK_MARGIN
            down = nearly_root(reach * yy) + BLOCK_MARGIN
            far = squared(nearly_root(reach) + BLOCK_MARGIN * nearly_root(a + c + TWO * abs(b)))
            if not (a * c > b * b and skew < LARGEST_SKEW):
                least = -NEVER
                across = down = far = NEVER
            if peak < OPACITY_MIN:
                least = ONE
                across = -ONE
            o = (ROW_WORDS * count) & SMALL_ROW
            write_splat(splats, o, x, y, a, b, c, peak, least, across, down, far)
            bits = bitcast_i32(depth)
            e = (ENTRY_WORDS * count) & SMALL_ENTRY
            bounds = first_y | (last_y << 8) | (first_x << 16) | (last_x << 24)
            write_entry(entries, e, bounds, np.int32(first + count), bits)
            sources[count & SMALL_ENTRY] = i
            nearest = min(nearest, bits)
            farthest = max(farthest, bits)
            count = np.int32(count + 1)
    depths[0] = nearest
    depths[1] = farthest
    return count


@numba.njit
def shown(value):
    """A colour of a sum of harmonics, which is around zero."""
    return max(ZERO, value + HALF)


@numba.njit
def degree_1(sh, i, c, x, y, z):
    """Coefficients 0 to 3 of channel c."""
    low = Y0 * sh[i, 3 + c] - Y1 * y * sh[i, 6 + c]
    return low + Y1 * z * sh[i, 9 + c] - Y1 * x * sh[i, 12 + c]


@numba.njit
def degree_2(sh, i, c, x, y, z):
    """Coefficients 4 to 8 of channel c."""
    xx = x * x
    yy = y * y
    high = Y2_XY * (x * y) * sh[i, 15 + c] - Y2_XY * (y * z) * sh[i, 18 + c]
    high += Y2_ZZ * (TWO * (z * z) - xx - yy) * sh[i, 21 + c]
    return high - Y2_XY * (x * z) * sh[i, 24 + c] + Y2_XX * (xx - yy) * sh[i, 27 + c]


@numba.njit
def degree_3(sh, i, c, x, y, z):
    """Coefficients 9 to 15 of channel c."""
    xx = x * x
    yy = y * y
    zz = z * z
    high = Y3_XYZ * (x * y) * z * sh[i, 33 + c] - Y3_XXY * y * (THREE * xx - yy) * sh[i, 30 + c]
    high -= Y3_YZZ * y * (FOUR * zz - xx - yy) * sh[i, 36 + c]
    high += Y3_ZZZ * z * (TWO * zz - THREE * xx - THREE * yy) * sh[i, 39 + c]
    high -= Y3_YZZ * x * (FOUR * zz - xx - yy) * sh[i, 42 + c]
    high += Y3_XXZ * z * (xx - yy) * sh[i, 45 + c]
    return high - Y3_XXY * x * (xx - THREE * yy) * sh[i, 48 + c]


@vividc.kernel("void(float32[:, ::1], float32, float32, float32, float32[:, ::1])")
def splat_colours_0(appearance, eye_x, eye_y, eye_z, splats):
    """As `splat_colours_3`, of the one coefficient that is the same from everywhere."""
    for i in range(appearance.shape[0]):
        splats[i, 7] = shown(Y0 * appearance[i, 3])
        splats[i, 8] = shown(Y0 * appearance[i, 4])
        splats[i, 9] = shown(Y0 * appearance[i, 5])


@vividc.kernel("void(float32[:, ::1], float32, float32, float32, float32[:, ::1])")
def splat_colours_1(appearance, eye_x, eye_y, eye_z, splats):
    """As `splat_colours_3`, of degree 1: 4 coefficients."""
    for i in range(appearance.shape[0]):
        x = appearance[i, 0] - eye_x
        y = appearance[i, 1] - eye_y
        z = appearance[i, 2] - eye_z
        inverse = ONE / math.sqrt(x * x + y * y + z * z)
        x *= inverse
        y *= inverse
        z *= inverse
        splats[i, 7] = shown(degree_1(appearance, i, 0, x, y, z))
        splats[i, 8] = shown(degree_1(appearance, i, 1, x, y, z))
        splats[i, 9] = shown(degree_1(appearance, i, 2, x, y, z))


@vividc.kernel("void(float32[:, ::1], float32, float32, float32, float32[:, ::1])")
def splat_colours_2(appearance, eye_x, eye_y, eye_z, splats):
    """As `splat_colours_3`, of degree 2: 9 coefficients."""
    for i in range(appearance.shape[0]):
        x = appearance[i, 0] - eye_x
        y = appearance[i, 1] - eye_y
        z = appearance[i, 2] - eye_z
        inverse = ONE / math.sqrt(x * x + y * y + z * z)
        x *= inverse
        y *= inverse
        z *= inverse
        splats[i, 7] = shown(
            degree_1(appearance, i, 0, x, y, z) + degree_2(appearance, i, 0, x, y, z)
        )
        splats[i, 8] = shown(
            degree_1(appearance, i, 1, x, y, z) + degree_2(appearance, i, 1, x, y, z)
        )
        splats[i, 9] = shown(
            degree_1(appearance, i, 2, x, y, z) + degree_2(appearance, i, 2, x, y, z)
        )


@vividc.kernel("void(float32[:, ::1], float32, float32, float32, float32[:, ::1])")
def splat_colours_3(appearance, eye_x, eye_y, eye_z, splats):
    """Colours seen from the eye, of spherical harmonics of degree 3, into rows of `splats`.

    A row of `appearance` is centre x, y, z and the coefficients [16, 3].
    """
    for i in range(appearance.shape[0]):
        x = appearance[i, 0] - eye_x
        y = appearance[i, 1] - eye_y
        z = appearance[i, 2] - eye_z
        inverse = ONE / math.sqrt(x * x + y * y + z * z)
        x *= inverse
        y *= inverse
        z *= inverse
        splats[i, 7] = shown(
            degree_1(appearance, i, 0, x, y, z)
            + degree_2(appearance, i, 0, x, y, z)
            + degree_3(appearance, i, 0, x, y, z)
        )
        splats[i, 8] = shown(
            degree_1(appearance, i, 1, x, y, z)
            + degree_2(appearance, i, 1, x, y, z)
            + degree_3(appearance, i, 1, x, y, z)
        )
        splats[i, 9] = shown(
            degree_1(appearance, i, 2, x, y, z)
            + degree_2(appearance, i, 2, x, y, z)
            + degree_3(appearance, i, 2, x, y, z)
        )

"""What the ray-marched methods share: rays into a box, occupied samples, blending along a ray."""

import math

import numpy as np

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
STOP = np.float32(1e-4)


@vividc.kernel("void(float32[:, ::1], float32[::1], float32, int32, int32, float32[:, ::1])")
def pixel_rays(pose, centre, inverse_focal, row, columns, directions):
    """Unit directions of one row of pixels; `pose` is the camera's rotation, [3, 3]."""
    v = -(np.float32(row) + HALF - centre[1]) * inverse_focal
    for column in range(columns):
        u = (np.float32(np.int32(column)) + HALF - centre[0]) * inverse_focal
        x = pose[0, 0] * u + pose[0, 1] * v - pose[0, 2]
        y = pose[1, 0] * u + pose[1, 1] * v - pose[1, 2]
        z = pose[2, 0] * u + pose[2, 1] * v - pose[2, 2]
        scale = ONE / math.sqrt(x * x + y * y + z * z)
        directions[column, 0] = x * scale
        directions[column, 1] = y * scale
        directions[column, 2] = z * scale


@vividc.kernel(
    "void(float32[:, ::1], float32[:, ::1], float32[:, ::1], float32, float32, float32[:, ::1])"
)
def ray_box(origins, directions, box, near, far, spans):
    """Entry and exit distance of each ray and a box (slabs; Kay and Kajiya 1986); a ray misses if
    the exit comes first.
    """
    for i in range(origins.shape[0]):
        entry = near
        leave = far
        for axis in range(3):
            inverse = ONE / directions[i, axis]
            t0 = (box[0, axis] - origins[i, axis]) * inverse
            t1 = (box[1, axis] - origins[i, axis]) * inverse
            entry = max(entry, min(t0, t1))
            leave = min(leave, max(t0, t1))
        spans[i, 0] = entry
        spans[i, 1] = leave


@vividc.kernel(
    "int32(float32[::1], float32[::1], float32, float32, float32, uint32[::1], int32[::1],"
    " float32[::1])"
)
def march_occupancy(origin, direction, entry, leave, step, occupied, shape, samples):
    """Distances of a ray's samples in occupied cells; returns how many there are.

    Positions are in cells; cell (x, y, z) is bit (x * shape[1] + y) * shape[2] + z, the lowest bit
    of a word first.
    """
    count = 0
    t = entry + HALF * step
    while t <= leave and count < len(samples):
        x = np.int32(np.floor(origin[0] + t * direction[0]))
        y = np.int32(np.floor(origin[1] + t * direction[1]))
        z = np.int32(np.floor(origin[2] + t * direction[2]))
        inside = x >= 0 and y >= 0 and z >= 0 and x < shape[0] and y < shape[1] and z < shape[2]
        if inside:
            cell = np.int32((x * shape[1] + y) * shape[2] + z)
            if (occupied[cell >> 5] >> np.uint32(cell & 31)) & np.uint32(1):
                samples[count] = t
                count += 1
        t += step
    return count


@vividc.kernel("int32(float32[::1], float32[:, ::1], float32, float32[::1])")
def volume_blend(density, colour, step, out):
    """Emission and absorption along a ray (Max 1995), front to back; stops where nothing shines
    through. `out` is r, g, b, transmittance; returns how many samples counted.
    """
    transmittance = ONE
    r = ZERO
    g = ZERO
    b = ZERO
    used = 0
    for k in range(len(density)):
        alpha = ONE - math.exp(-density[k] * step)
        weight = transmittance * alpha
        r += weight * colour[k, 0]
        g += weight * colour[k, 1]
        b += weight * colour[k, 2]
        transmittance *= ONE - alpha
        used += 1
        if transmittance < STOP:
            break
    out[0] = r
    out[1] = g
    out[2] = b
    out[3] = transmittance
    return used

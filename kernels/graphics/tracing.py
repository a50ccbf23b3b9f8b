"""Two small ray tracers: mirroring spheres over a checkered floor, and distance fields.

Rays are (origin, direction), each three floats; directions have length 1, y is up.
"""

import math

import numba
import numpy as np
from numba import prange

import vividc

f32 = np.float32

FAR = f32(1e6)
NEAR = f32(1e-3)
FAINT = f32(0.02)
FLOOR = -1
NOTHING = -2

HORIZON = (f32(0.85), f32(0.90), f32(1.00))
ZENITH = (f32(0.25), f32(0.45), f32(0.85))
DARK = (f32(0.10), f32(0.12), f32(0.16))
PALE = (f32(0.92), f32(0.90), f32(0.84))
CLAY = (f32(0.92), f32(0.48), f32(0.25))
GRASS = (f32(0.42), f32(0.55), f32(0.35))

EYE = (f32(0.0), f32(1.3), f32(-4.0))
CLOSE = f32(2e-3)
EPSILON = f32(2e-3)
MARCH_STEPS = 64
MARCH_END = f32(14.0)
SHADOW_STEPS = 24
SHADOW_END = f32(6.0)


@numba.njit
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit
def along(a, t, b):
    """a + t * b"""
    return a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]


@numba.njit
def mix(a, b, t):
    """From a (t = 0) to b (t = 1)."""
    return a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])


@numba.njit
def normalize(v):
    inverse = f32(1.0) / math.sqrt(dot(v, v))
    return v[0] * inverse, v[1] * inverse, v[2] * inverse


@numba.njit
def reflect(direction, normal):
    return along(direction, f32(-2.0) * dot(direction, normal), normal)


@numba.njit
def camera_ray(x, y, width, height, tilt, zoom):
    """Through the centre of a pixel; the camera looks along z, `tilt` (its slope) up or down."""
    scale = f32(1.0) / f32(height)
    u = (f32(2.0) * f32(x) + f32(1.0) - f32(width)) * scale
    v = (f32(height) - f32(2.0) * f32(y) - f32(1.0)) * scale
    return normalize((u, v + tilt, zoom))


@numba.njit
def sky(direction):
    return mix(HORIZON, ZENITH, math.sqrt(max(direction[1], f32(0.0))))


@numba.njit
def hit_sphere(origin, direction, spheres, i):
    """How far it is to the near side of sphere i; FAR where the ray misses it."""
    centre = (spheres[i, 0], spheres[i, 1], spheres[i, 2])
    offset = along(origin, f32(-1.0), centre)
    b = dot(offset, direction)
    discriminant = b * b - dot(offset, offset) + spheres[i, 3] * spheres[i, 3]
    if discriminant < f32(0.0):
        return FAR
    t = -b - math.sqrt(discriminant)
    return t if t > NEAR else FAR


@numba.njit
def closest_hit(origin, direction, spheres):
    """Distance, and the number of the sphere, FLOOR or NOTHING."""
    distance = FAR
    index = NOTHING
    if direction[1] < f32(0.0):
        distance = -origin[1] / direction[1]
        index = FLOOR
    for i in range(spheres.shape[0]):
        t = hit_sphere(origin, direction, spheres, i)
        if t < distance:
            distance = t
            index = i
    return distance, index


@numba.njit
def in_shadow(point, light, spheres):
    for i in range(spheres.shape[0]):
        if hit_sphere(point, light, spheres, i) < FAR:
            return True
    return False


@numba.njit
def surface(point, distance, index, spheres):
    """Normal, colour and how much is mirrored."""
    if index == FLOOR:
        squares = np.floor(point[0]) + np.floor(point[2])
        even = squares - f32(2.0) * np.floor(f32(0.5) * squares) < f32(0.5)
        haze = min(distance * f32(0.04), f32(1.0))
        paint = mix(DARK if even else PALE, HORIZON, haze * haze)
        return (f32(0.0), f32(1.0), f32(0.0)), paint, f32(0.2)
    inverse = f32(1.0) / spheres[index, 3]
    normal = (
        (point[0] - spheres[index, 0]) * inverse,
        (point[1] - spheres[index, 1]) * inverse,
        (point[2] - spheres[index, 2]) * inverse,
    )
    paint = (spheres[index, 4], spheres[index, 5], spheres[index, 6])
    return normal, paint, spheres[index, 7]


@numba.njit
def trace(origin, direction, spheres, light, bounces):
    """The colour that a ray sees, mirrored `bounces` times at most."""
    colour = (f32(0.0), f32(0.0), f32(0.0))
    weight = f32(1.0)
    for _ in range(bounces + 1):
        distance, index = closest_hit(origin, direction, spheres)
        if index == NOTHING:
            colour = along(colour, weight, sky(direction))
            break
        point = along(origin, distance, direction)
        normal, paint, mirror = surface(point, distance, index, spheres)
        origin = along(point, NEAR, normal)
        lit = dot(normal, light)
        if lit < f32(0.0) or in_shadow(origin, light, spheres):
            lit = f32(0.0)
        colour = along(colour, weight * (f32(1.0) - mirror) * (f32(0.3) + f32(0.7) * lit), paint)
        weight *= mirror
        if weight < FAINT:
            break
        direction = reflect(direction, normal)
    return colour


@vividc.kernel("void(float32[:, ::1], float32[::1], int32, float32[:, :, ::1])")
def trace_spheres(spheres, light, bounces, image):
    """Spheres over a checkered floor, with hard shadows and mirrored rays (Whitted 1980).

    `spheres` has rows of centre, radius, colour, and the share of light that is mirrored; `light`
    is the direction to the sun.
    """
    height, width, _ = image.shape
    sun = (light[0], light[1], light[2])
    for y in prange(height):
        for x in range(width):
            eye = (f32(0.1), f32(1.45), f32(-5.0))
            ray = camera_ray(x, y, width, height, f32(-0.25), f32(1.8))
            red, green, blue = trace(eye, ray, spheres, sun, bounces)
            image[y, x, 0] = math.sqrt(min(red, f32(1.0)))
            image[y, x, 1] = math.sqrt(min(green, f32(1.0)))
            image[y, x, 2] = math.sqrt(min(blue, f32(1.0)))


@numba.njit
def smooth_union(a, b, reach):
    """The smaller of two distances, rounded where they differ by less (Quilez 2013)."""
    h = max(f32(1.0) - abs(a - b) / reach, f32(0.0))
    return min(a, b) - f32(0.25) * reach * h * h


@numba.njit
def ball_distance(p, x, y, z, radius):
    v = (p[0] - x, p[1] - y, p[2] - z)
    return math.sqrt(dot(v, v)) - radius


@numba.njit
def body_distance(p):
    """Two balls that melt into each other."""
    left = ball_distance(p, f32(-0.5), f32(0.7), f32(0.0), f32(0.7))
    right = ball_distance(p, f32(0.55), f32(0.5), f32(-0.3), f32(0.5))
    return smooth_union(left, right, f32(0.5))


@numba.njit
def scene_distance(p):
    """To the balls or the ground."""
    return min(body_distance(p), p[1])


@numba.njit
def scene_normal(p):
    """The gradient of the distance, from the corners of a tetrahedron."""
    x = y = z = f32(0.0)
    for k in range(4):
        u = f32(1.0) if k & 1 else f32(-1.0)
        v = f32(1.0) if k & 2 else f32(-1.0)
        w = u * v
        d = scene_distance((p[0] + u * EPSILON, p[1] + v * EPSILON, p[2] + w * EPSILON))
        x += u * d
        y += v * d
        z += w * d
    return normalize((x, y, z))


@numba.njit
def march(origin, direction):
    """Distance to the scene; MARCH_END or more where there is nothing (Hart 1996)."""
    t = f32(0.0)
    for _ in range(MARCH_STEPS):
        step = scene_distance(along(origin, t, direction))
        t += step
        if step < CLOSE or t > MARCH_END:
            break
    return t


@numba.njit
def soft_shadow(point, light):
    """0 in full shadow, 1 in light; between, how near the ray came to the balls (Quilez 2010)."""
    share = f32(1.0)
    t = f32(0.03)
    for _ in range(SHADOW_STEPS):
        step = body_distance(along(point, t, light))
        if step < CLOSE:
            return f32(0.0)
        share = min(share, f32(7.0) * step / t)
        t += min(max(step, f32(0.04)), f32(0.4))
        if t > SHADOW_END:
            break
    return share


@vividc.kernel("void(float32[:, :, ::1])")
def march_scene(hits):
    """What each pixel sees of a scene of melting balls: the place, and how far it is.

    One kernel with `shade_scene` would need more contexts than a tile has, since a function becomes
    part of its kernel wherever it is called.
    """
    height, width, _ = hits.shape
    for y in prange(height):
        for x in range(width):
            ray = camera_ray(x, y, width, height, f32(-0.22), f32(2.0))
            distance = march(EYE, ray)
            place = along(EYE, distance, ray)
            hits[y, x, 0] = place[0]
            hits[y, x, 1] = place[1]
            hits[y, x, 2] = place[2]
            hits[y, x, 3] = distance


@numba.njit
def shade(point, distance, light):
    """Sun with soft shadow, light from the sky, and haze."""
    normal = scene_normal(point)
    sun = max(dot(normal, light), f32(0.0))
    if sun > f32(0.0):
        sun *= soft_shadow(along(point, f32(0.01), normal), light)
    brightness = f32(0.25) + f32(0.1) * normal[1] + f32(0.8) * sun
    paint = GRASS if point[1] < f32(2.0) * CLOSE else CLAY
    lit = (paint[0] * brightness, paint[1] * brightness, paint[2] * brightness)
    far = distance / MARCH_END
    return mix(lit, HORIZON, far * far)


@vividc.kernel("void(float32[:, :, ::1], float32[::1], float32[:, :, ::1])")
def shade_scene(hits, light, image):
    """The scene's colours, from what `march_scene` found."""
    height, width, _ = hits.shape
    sun = (light[0], light[1], light[2])
    for y in prange(height):
        for x in range(width):
            place = (hits[y, x, 0], hits[y, x, 1], hits[y, x, 2])
            distance = hits[y, x, 3]
            if distance > MARCH_END:
                up = max(place[1] - EYE[1], f32(0.0)) / distance
                colour = mix(HORIZON, ZENITH, math.sqrt(up))
            else:
                colour = shade(place, distance, sun)
            image[y, x, 0] = math.sqrt(min(colour[0], f32(1.0)))
            image[y, x, 1] = math.sqrt(min(colour[1], f32(1.0)))
            image[y, x, 2] = math.sqrt(min(colour[2], f32(1.0)))

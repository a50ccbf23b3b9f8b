"""Marching and blending of a made-up field, against a scalar loop along each ray."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.render.arrays import frozen_float32
from vividc.render.radiance.layers import BLOCK, in_blocks, linear, sigmoid
from vividc.render.radiance.occupancy import March, box_span, occupied_samples
from vividc.render.radiance.volume import render_rays

F = np.float32


class Fog:
    """Density and colour in closed form; half of the cells are occupied."""

    def __init__(self, thickness: float, weight_min: float, transmittance_min: float) -> None:
        occupied = np.indices((4, 5, 6)).sum(axis=0) % 2 == 0
        box = frozen_float32([[-1, -1, -1], [1, 1, 1]])
        self.march = March(box, 0.5, 6.0, 0.05, 60, occupied)
        self.thickness = F(thickness)
        self.weight_min, self.transmittance_min = weight_min, transmittance_min

    def density(self, points, layer):
        return self.thickness * np.abs(points[:, 0]), points[:, :2]

    def colour(self, points, features, directions, layer):
        return np.abs(points) + F(0.5) * np.abs(directions) * features[:, :1] ** 2


def one_ray(field: Fog, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, int, int]:
    """Return r, g, b, T of one ray in float64, how many samples were dense, and how many count."""
    march = field.march
    origin, direction = origin.astype(float), direction.astype(float)
    low, high = (march.box[0] - origin) / direction, (march.box[1] - origin) / direction
    entry, leave = np.minimum(low, high).max(), np.maximum(low, high).min()
    entry = min(max(entry, march.near), march.far)
    total, left, dense, counted = np.zeros(3), 1.0, 0, 0
    for k in range(march.samples):
        t = entry + march.step * (k + 0.5)
        point = origin + t * direction
        cell = np.floor((point + 1) / 2 * march.occupied.shape).astype(int)
        if t > leave or not march.occupied[tuple(np.clip(cell, 0, (3, 4, 5)))]:
            continue
        dense += 1
        alpha = 1 - np.exp(-float(field.thickness) * abs(point[0]))
        if left >= field.transmittance_min and left * alpha > field.weight_min:
            colour = np.abs(point) + 0.5 * np.abs(direction) * point[0] ** 2
            total += left * alpha * colour
            counted += 1
        left *= 1 - alpha
    return np.array([*total, left]), dense, counted


@pytest.mark.parametrize(("own", "asked"), [(0.0, 0.02), (0.02, 0.0), (0.02, 0.01)])
def test_the_greater_of_two_least_weights_counts(own: float, asked: float) -> None:
    rays = np.array([[0.1, 0.2, -1.0], [0.3, -0.1, -1.0]], np.float32)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    origin = np.array([0.2, 0.1, 2.0], np.float32)
    expected, counts = render_rays(Fog(2.0, 0.02, 0.0), origin, rays)
    found, same = render_rays(Fog(2.0, own, 0.0), origin, rays, weight_min=asked)
    np.testing.assert_array_equal(found, expected)
    assert same == counts
    assert counts.colour_samples < counts.density_samples


@pytest.mark.parametrize(
    ("thickness", "weight_min", "transmittance_min"),
    [(0.1, 0.0, 0.0), (2.0, 0.01, 0.0), (2.0, 0.0, 0.03)],
)
def test_equals_a_loop_along_each_ray(thickness, weight_min, transmittance_min) -> None:
    field = Fog(thickness, weight_min, transmittance_min)
    rng = np.random.default_rng(5)
    origin = frozen_float32([2.1, 1.3, -1.7])
    aim = rng.uniform(-0.9, 0.9, (60, 3)) - origin
    directions = frozen_float32(aim / np.linalg.norm(aim, axis=1, keepdims=True))
    rgbt, counts = render_rays(field, origin, directions)
    expected = [one_ray(field, origin, direction) for direction in directions]
    # A sample that lies within float32 rounding of a face may fall on the other side.
    close = np.isclose(rgbt, [row[0] for row in expected], rtol=1e-4, atol=1e-5).all(axis=1)
    assert close.sum() >= 58
    assert abs(counts.density_samples - sum(row[1] for row in expected)) <= 2
    assert abs(counts.counted_samples - sum(row[2] for row in expected)) <= 2
    late, _ = render_rays(field, origin, directions, lookahead=False)
    np.testing.assert_array_equal(rgbt, late)


def test_rays_along_the_faces_and_axes() -> None:
    """A component of 0 gives infinite distances, or none where the ray lies in a face."""
    march = Fog(1, 0, 0).march
    origin = frozen_float32([3, 0, 1])
    directions = frozen_float32([[-1, 0, -0.0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    entry, leave = box_span(march, origin, directions)
    assert (entry[0], leave[0]) == (entry[3], leave[3]) == (2, 4)
    assert leave[1] < entry[1]
    assert leave[2] < entry[2]


def test_samples_are_by_ray_and_end_at_the_box() -> None:
    march = Fog(1, 0, 0).march
    directions = frozen_float32([[-1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    samples = occupied_samples(march, frozen_float32([2, 0.1, 0.1]), directions)
    assert sorted(set(samples.ray.tolist())) == [0, 2]
    assert (np.diff(samples.ray) >= 0).all()
    assert (np.abs(samples.points) <= 1).all()
    first = samples.points[samples.ray == 0]
    assert (np.diff(first[:, 0]) < 0).all()


def test_origin_within_the_box_starts_at_near() -> None:
    field = Fog(1, 0, 0)
    entry, _ = box_span(field.march, frozen_float32([0, 0, 0]), frozen_float32([[0, 0, 1]]))
    assert entry.item() == 0.5


@pytest.mark.parametrize("count", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1])
def test_a_row_does_not_depend_on_how_many_there_are(count: int) -> None:
    rng = np.random.default_rng(count)
    inputs = rng.normal(size=(count, 33)).astype(np.float32)
    weights = rng.normal(size=(33, 7)).astype(np.float32)

    def network(rows: np.ndarray) -> tuple[np.ndarray]:
        return (sigmoid(linear("", rows, weights, None)),)

    (whole,) = in_blocks(network, inputs)
    assert whole.shape == (count, 7)
    assert whole.dtype == np.float32
    some = rng.permutation(count)[: count // 2]
    np.testing.assert_array_equal(in_blocks(network, inputs[some])[0], whole[some])
    np.testing.assert_allclose(whole, 1 / (1 + np.exp(-(inputs @ weights))), rtol=1e-4)


@pytest.mark.parametrize("groups", [(), (3,)])
def test_a_layer_sums_in_the_order_of_its_inputs(groups: tuple[int, ...]) -> None:
    """On every processor: nothing is contracted, and no row is summed otherwise than another."""
    rng = np.random.default_rng(1)
    inputs = rng.normal(size=(*groups, 37, 33)).astype(np.float32)
    weights = rng.normal(size=(*groups, 33, 7)).astype(np.float32)
    bias = rng.normal(size=(*groups, 1, 7)).astype(np.float32)
    expected = np.zeros((*groups, 37, 7), dtype=np.float32)
    for column in range(33):
        expected += inputs[..., column, None] * weights[..., column, None, :]
    np.testing.assert_array_equal(linear("", inputs, weights, bias), expected + bias)
    assert linear("", inputs[..., :0, :], weights, bias).shape == (*groups, 0, 7)


def test_sigmoid_of_large_values() -> None:
    values = np.array([-1000, 0, 1000], dtype=np.float32)
    np.testing.assert_allclose(sigmoid(values), [0, 0.5, 1], atol=1e-30)

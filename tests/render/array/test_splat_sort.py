"""Sorting of 3DGS on the array: by depth and into screen tiles, in the reference's order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vividc.render import Projection, SceneError, bin_and_sort
from vividc.render.array import Device
from vividc.render.array.splats.project import DeviceSplats
from vividc.render.array.splats.sort import sort_on_array
from vividc.render.splat.splat import Splats

CHUNK = 170


def projected(x: np.ndarray, y: np.ndarray, radius: np.ndarray, depth: np.ndarray) -> Projection:
    """Splats of which only place, radius and depth matter."""
    some = np.ones(len(x), np.float32)
    columns = (x.astype(np.float32), y.astype(np.float32), *[some] * 7)
    index = np.arange(len(x))
    return Projection(Splats(*columns), depth.astype(np.float32), radius.astype(np.float32), index)


def on_device(projection: Projection, columns: int, rows: int, gap: int) -> DeviceSplats:
    """The same in DRAM, `gap` slots of each chunk empty."""
    held = CHUNK - gap
    n = len(projection.depth)
    chunks = -(-n // held)
    entries = np.full((chunks * CHUNK, 3), -1, np.int32)
    slot = np.arange(n) // held * CHUNK + np.arange(n) % held
    mean = np.stack((projection.splats.mean_x, projection.splats.mean_y), 1)
    reach = projection.radius[:, None]
    most = np.array([columns, rows])
    first = np.clip((mean - reach) / 16, 0, most).astype(np.int64)
    last = np.clip((mean + reach + 15) / 16, 0, most).astype(np.int64)
    bounds = first[:, 1] | last[:, 1] << 8 | first[:, 0] << 16 | last[:, 0] << 24
    bits = projection.depth.view(np.int32)
    entries[slot] = np.stack((bounds.astype(np.uint32).view(np.int32), slot, bits), 1)
    counts = tuple(min(held, n - held * i) for i in range(chunks))
    rows_of = np.zeros((chunks * CHUNK, 13), np.float32)
    sources = np.zeros(chunks * CHUNK, np.int32)
    return DeviceSplats(rows_of, entries, sources, counts, CHUNK, int(bits.min()), int(bits.max()))


def check(device: Device, projection: Projection, width: int, height: int, gap: int = 0) -> None:
    columns, rows = -(-width // 16), -(-height // 16)
    splats = on_device(projection, columns, rows, gap)
    lists = sort_on_array(device, splats, columns, rows)
    expected = bin_and_sort(projection, width, height)
    held = CHUNK - gap
    slots = expected.order // held * CHUNK + expected.order % held
    np.testing.assert_array_equal(lists.start, expected.start)
    np.testing.assert_array_equal(lists.slots, slots)
    assert set(device.settle().stages) == {"sorting", "binning"}


def test_more_splats_than_can_be_sorted_are_refused(device: Device) -> None:
    one = on_device(projected(*np.ones((4, 1))), 1, 1, 0)
    many = replace(one, counts=(4_194_305,))
    with pytest.raises(SceneError, match="4194305 splats are seen, and the array sorts 4194304"):
        sort_on_array(device, many, 1, 1)


def test_lists_and_ties_are_in_the_order_of_the_reference(device: Device) -> None:
    rng = np.random.default_rng(1)
    n = 700
    depth = rng.choice(np.linspace(0.3, 9, 40), n)
    projection = projected(
        rng.uniform(0, 150, n), rng.uniform(0, 90, n), rng.integers(1, 30, n), depth
    )
    check(device, projection, 150, 90, gap=40)


def test_lists_longer_than_a_scratchpad(device: Device) -> None:
    """Three thousand splats, each in all four screen tiles."""
    rng = np.random.default_rng(2)
    n = 3000
    everywhere = np.full(n, 16.0)
    check(device, projected(everywhere, everywhere, everywhere * 4, rng.random(n) + 1), 32, 32)


def test_one_splat_and_equal_depths(device: Device) -> None:
    one = np.ones(1)
    check(device, projected(20 * one, 40 * one, 3 * one, one), 64, 64)
    same = np.ones(50)
    check(device, projected(20 * same, 40 * same, 9 * same, same), 64, 64)
    edge = np.full(20, 4070.0)
    check(device, projected(edge, 8 * edge / edge, edge / edge, edge), 4080, 16)

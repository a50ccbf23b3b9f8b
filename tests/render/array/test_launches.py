"""Launches dealt out to tiles, arrays that stay, and transfers behind runs."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from vividc.render import SceneError
from vividc.render.array import Device
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.device.launch import Launch, Move
from vividc.render.array.device.launches import Phase, dealt, in_turn
from vividc.render.array.device.places import Places

KERNEL = "saxpy:saxpy"


def launch(x: np.ndarray, y: np.ndarray, *, shared: bool = False) -> Launch:
    return Launch(
        shapes={"x": x.shape, "y": y.shape},
        inputs={"y": (Move(y),)} if shared else {"x": (Move(x),), "y": (Move(y),)},
        outputs={"y": (Move(y),)},
        shared={"x": x} if shared else {},
        scalars={"n": len(x), "a": 2.0},
    )


@pytest.mark.parametrize("shared", [False, True])
def test_every_launch_runs_once(device: Device, shared: bool) -> None:
    rng = np.random.default_rng(3)
    xs = [rng.random(30, dtype=np.float32) for _ in range(3)]
    ys = [rng.random(30, dtype=np.float32) for _ in range(40)]
    expected = [y + np.float32(2) * xs[i * 3 // 40] for i, y in enumerate(ys)]
    launches = [launch(xs[i * 3 // 40], y, shared=shared) for i, y in enumerate(ys)]
    returned = device.run("test", KERNEL, launches)
    np.testing.assert_allclose(ys, expected, rtol=1e-6)
    assert returned == [0] * 40
    stage = device.ledger.stages["test"]
    assert (stage.jobs, stage.runs) == (1, 40)
    moved_in = 40 * 120 if shared else 80 * 120
    assert stage.stats[0]["bytes"]["scratchpad_in"] >= moved_in


def test_arrays_that_all_launches_share_leave_dram_once(device: Device) -> None:
    x = np.arange(900, dtype=np.float32)
    ys = [np.zeros(900, np.float32) for _ in range(20)]
    device.run("test", KERNEL, [launch(x, y, shared=True) for y in ys])
    np.testing.assert_array_equal(ys, [2 * x] * 20)
    moved = device.ledger.stages["test"].stats[0]["bytes"]
    assert moved["dram_wanted"] == 3600 * (1 + 2 * 20)
    assert moved["scratchpad_in"] == 3600 * (16 + 20)


def test_no_launches_are_no_job(device: Device) -> None:
    assert device.run("test", KERNEL, []) == []
    assert not device.ledger.stages


def test_launches_of_one_group_stay_on_a_tile() -> None:
    x = [np.zeros(4, np.float32) for _ in range(3)]
    y = np.zeros(4, np.float32)
    launches = [launch(x[i], y, shared=True) for i in (0, 0, 0, 1, 1, 2)]
    assert dealt(launches, 2) == [[0, 1, 2], [3, 4, 5]]
    same = [launch(x[0], y, shared=True) for _ in range(5)]
    assert dealt(same, 2) == [[0, 2, 4], [1, 3]]
    assert sorted(n for share in dealt(launches, 5) for n in share) == list(range(6))


def test_launches_that_carry_something_on_stay_on_a_tile_in_their_order() -> None:
    y, sums = np.zeros(4, np.float32), [np.zeros(4, np.float32) for _ in range(2)]
    launches = [replace(launch(y, y), carried={"x": sums[i]}) for i in (0, 0, 0, 0, 0, 1)]
    assert dealt(launches, 4) == [[0, 1, 2, 3, 4], [5], [], []]
    assert dealt(launches[:5], 4) == [[0, 1, 2, 3, 4], [], [], []]


def test_sums_are_carried_on_and_leave_after_the_last_launch(device: Device) -> None:
    """Of 20 blocks of 64 rays, up to four launches each: so many that tiles change blocks."""
    rng = np.random.default_rng(8)
    left, out = rng.random((20, 64), dtype=np.float32), np.zeros((20, 64, 4), np.float32)
    expected = np.concatenate((np.zeros((20, 64, 3)), left[:, :, None]), axis=2)
    launches, before = [], list(zip(left, out, strict=True))
    for block, (light, sums) in enumerate(before):
        parts = 1 + block % 4
        for part in range(parts):
            count = int(rng.integers(1, 30))
            rays = rng.integers(0, 64, count).astype(np.int32)
            weights, colours = rng.random(count, np.float32), rng.random((count, 3), np.float32)
            np.add.at(expected[block, :, :3], rays, weights[:, None] * colours)
            launches.append(
                Launch(
                    inputs={
                        "weights": weights,
                        "items": rays << 16,
                        "places": np.arange(count, dtype=np.int32),
                        "colours": colours,
                    },
                    shared={"left": light},
                    carried={"out": sums},
                    scalars={"goes_on": int(part > 0), "is_last": int(part == parts - 1)},
                )
            )
    expected[:, :, :3] += left[:, :, None]
    device.run("test", "render/marching:accumulate_in_groups", launches)
    np.testing.assert_allclose(out, expected, rtol=1e-5)
    moved = device.ledger.stages["test"].stats[0]["bytes"]
    assert moved["scratchpad_out"] == out.nbytes


def test_as_many_rows_leave_as_a_launch_counts(device: Device) -> None:
    """Of the samples of twenty blocks about a half have a weight; of the first block none has."""
    rng = np.random.default_rng(9)
    launches, counts = [], []
    for block in range(20):
        count = int(rng.integers(1, 40))
        has_weight = (rng.random(count) < 0.5) & (block > 0)
        launches.append(
            Launch(
                shapes={"count": (1,)},
                inputs={
                    "thickness": has_weight.astype(np.float32),
                    "places": np.arange(count, dtype=np.int32),
                    "items": np.arange(count, dtype=np.int32) << 16,
                },
                outputs={
                    "kept_items": np.full(count, -1, np.int32),
                    "weights": np.full(count, -1, np.float32),
                },
                shared={"limits": np.array([1e-4, 1e-4], np.float32)},
                carried={"left": np.zeros(64, np.float32)},
                scalars={"goes_on": 0, "keep_all": 0},
                counted={"kept_items": "count", "weights": "count"},
            )
        )
        counts.append(int(has_weight.sum()))
    returned = device.run("test", "render/marching:transmittance_in_groups", launches)
    assert [word >> 20 for word in returned] == counts
    for one, count in zip(launches, counts, strict=True):
        weights, items = one.outputs["weights"], one.outputs["kept_items"]
        np.testing.assert_allclose(weights[:count], 1 - np.exp(-1), rtol=1e-6)
        samples = np.flatnonzero(one.inputs["thickness"])
        np.testing.assert_array_equal(items[:count], (samples << 22) | (samples << 16))
        assert (weights[count:] == -1).all()
        assert (items[count:] == -1).all()
    moved = device.ledger.stages["test"].stats[0]["bytes"]
    assert moved["scratchpad_out"] == sum(4 * 64 + 2 * (4 + 4 * count) for count in counts)


def test_what_does_not_fit_is_told_with_its_sizes(device: Device) -> None:
    x = np.zeros(5000, np.float32)
    with pytest.raises(SceneError, match=r"needs \d+ bytes of a scratchpad of 32768: x 20000"):
        device.run("test", KERNEL, [launch(x, x.copy())])


@pytest.mark.parametrize("banks", [4, 8, 32])
def test_copies_of_arrays_lie_apart_in_the_banks_asked_for(banks: int) -> None:
    wishes = {"x": 3, "y": 0}
    y, same = np.zeros(5, np.float32), np.zeros(7, np.float32)
    share = [launch(np.zeros(9, np.float32), y, shared=True) for _ in range(3)]
    share = [replace(one, shared={**one.shared, "z": same}) for one in share]
    places = Places("saxpy", wishes, banks, share, 2048, first=["z"])
    own = [places.addresses({"y": 20}, start)["y"] for start in places.own]
    at = {**places.held, "y": own}
    assert {name: len(starts) for name, starts in at.items()} == {"z": 1, "x": 2, "y": 2}
    assert places.held["z"] == [0]
    for name, starts in at.items():
        assert {start // 4 % banks for start in starts} == {wishes.get(name, 0)}
    sizes = {"z": 28, "x": 36, "y": 20}
    spans = sorted((start, start + sizes[name]) for name, starts in at.items() for start in starts)
    assert all(end <= start for (_, end), (start, _) in pairwise(spans))
    assert spans[-1][1] <= places.end


def test_rows_are_gathered_in_pieces(device: Device) -> None:
    rng = np.random.default_rng(4)
    table = rng.random((50, 7), dtype=np.float32)
    rows = [rng.integers(0, 50, n).astype(np.int32) for n in (3, 0, 700)]
    np.testing.assert_array_equal(
        gather_rows(device, "test", table, rows), table[np.concatenate(rows)]
    )
    assert gather_rows(device, "other", table, []).shape == (0, 7)
    assert list(device.ledger.stages) == ["test"]


def test_a_phase_reads_what_the_one_before_wrote(device: Device) -> None:
    """40 launches, each of a tile that runs the second phase of another one's part, too."""
    x = np.arange(30, dtype=np.float32)
    ys, zs = (np.ones((40, 30), np.float32) for _ in range(2))
    first = [launch(x, y, shared=True) for y in ys]
    second = [launch(y, z) for y, z in zip(ys[::-1], zs[::-1], strict=True)]
    phases = [Phase(KERNEL, in_turn(some, device.tiles)) for some in (first, second)]
    device.run_phases("test", phases)
    np.testing.assert_array_equal(ys, np.tile(1 + 2 * x, (40, 1)))
    np.testing.assert_array_equal(zs, 1 + 2 * ys)
    assert (device.ledger.stages["test"].jobs, device.ledger.stages["test"].runs) == (1, 80)


def test_what_is_carried_on_may_start_with_something(device: Device) -> None:
    """Four launches add to each of three sums, which come from DRAM and leave once."""
    x, sums = np.ones(50, np.float32), np.arange(150, dtype=np.float32).reshape(3, 50)
    own = list(sums)
    expected = sums + 2 * 4
    launches = [
        Launch(
            shapes={"y": (50,)},
            shared={"x": x},
            carried={"y": one},
            starts={"y": one},
            scalars={"n": 50, "a": 2.0},
        )
        for one in own
        for _ in range(4)
    ]
    device.run("test", KERNEL, launches)
    np.testing.assert_array_equal(sums, expected)
    assert device.ledger.stages["test"].stats[0]["bytes"]["scratchpad_out"] == sums.nbytes

"""Launches dealt out to tiles, arrays that stay, and transfers behind runs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from vividc.render import SceneError
from vividc.render.array import Device, Ledger
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.device.launches import Launch, Move, Places, dealt, run_launches

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
    ledger = Ledger()
    launches = [launch(xs[i * 3 // 40], y, shared=shared) for i, y in enumerate(ys)]
    returned = run_launches(device, ledger, "test", KERNEL, launches)
    np.testing.assert_allclose(ys, expected, rtol=1e-6)
    assert returned == [0] * 40
    stage = ledger.stages["test"]
    assert (stage.jobs, stage.runs) == (1, 40)
    moved_in = 40 * 120 if shared else 80 * 120
    assert stage.stats[0]["bytes"]["scratchpad_in"] >= moved_in


def test_arrays_that_all_launches_share_leave_dram_once(device: Device) -> None:
    x, ledger = np.arange(900, dtype=np.float32), Ledger()
    ys = [np.zeros(900, np.float32) for _ in range(20)]
    run_launches(device, ledger, "test", KERNEL, [launch(x, y, shared=True) for y in ys])
    np.testing.assert_array_equal(ys, [2 * x] * 20)
    moved = ledger.stages["test"].stats[0]["bytes"]
    assert moved["dram_wanted"] == 3600 * (1 + 2 * 20)
    assert moved["scratchpad_in"] == 3600 * (16 + 20)


def test_no_launches_are_no_job(device: Device) -> None:
    ledger = Ledger()
    assert run_launches(device, ledger, "test", KERNEL, []) == []
    assert not ledger.stages


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
                    inputs={"weights": weights, "items": rays << 16, "colours": colours},
                    shared={"left": light},
                    carried={"out": sums},
                    scalars={"goes_on": int(part > 0), "is_last": int(part == parts - 1)},
                )
            )
    expected[:, :, :3] += left[:, :, None]
    ledger = Ledger()
    run_launches(device, ledger, "test", "render/marching:accumulate", launches)
    np.testing.assert_allclose(out, expected, rtol=1e-5)
    moved = ledger.stages["test"].stats[0]["bytes"]
    assert moved["scratchpad_out"] == out.nbytes


def test_what_does_not_fit_is_told_with_its_sizes(device: Device) -> None:
    x = np.zeros(5000, np.float32)
    with pytest.raises(SceneError, match=r"needs \d+ bytes of a scratchpad of 32768: x 20000"):
        run_launches(device, Ledger(), "test", KERNEL, [launch(x, x.copy())])


@pytest.mark.parametrize("banks", [4, 8, 32])
def test_copies_of_arrays_lie_apart_in_the_banks_asked_for(banks: int) -> None:
    fabric = SimpleNamespace(scratchpad=SimpleNamespace(banks=banks))
    wishes = {"x": 3, "y": 0}
    program = SimpleNamespace(name="saxpy", banks=wishes, fabric=fabric)
    y = np.zeros(5, np.float32)
    share = [launch(np.zeros(9, np.float32), y, shared=True) for _ in range(3)]
    places = Places(program, share, 2048)
    ends = [0]
    for starts, sizes in ((places.shared, {"x": 36}), (places.own, {"y": 20})):
        assert len(starts) == 2
        for start in starts:
            for name, address in places.addresses(sizes, start).items():
                assert address // 4 % banks == wishes[name]
                assert address >= ends[-1]
                ends.append(address + sizes[name])


def test_rows_are_gathered_in_pieces(device: Device) -> None:
    rng = np.random.default_rng(4)
    table = rng.random((50, 7), dtype=np.float32)
    rows = [rng.integers(0, 50, n).astype(np.int32) for n in (3, 0, 700)]
    ledger = Ledger()
    np.testing.assert_array_equal(
        gather_rows(device, ledger, "test", table, rows), table[np.concatenate(rows)]
    )
    assert gather_rows(device, ledger, "other", table, []).shape == (0, 7)
    assert list(ledger.stages) == ["test"]

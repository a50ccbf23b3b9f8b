"""Kernels that are larger than a scratchpad run by blocks of their nests, as numba runs them."""

from __future__ import annotations

import functools
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numba import prange

import vividc
from vividc.errors import ArgumentError, BundleError
from vividc.frontend import KernelFunction
from vividc.launch import nests_cycles, nests_job
from vividc.launch.steps import Execute
from vividc.launch.tiles import nests
from vividc.launch.tiles.placed import table_extents
from vividc.machine.params import LocalArray
from vividc.program import Program, from_bytes

M, V, C = "int32[:, ::1]", "int32[::1]", "int32[:, :, ::1]"


@vividc.kernel(f"void({M}, {M})")
def blur(x, y):
    for i in range(1, x.shape[0] - 1):
        for j in range(1, x.shape[1] - 1):
            y[i, j] = x[i - 1, j] + x[i + 1, j] + x[i, j - 1] + 3 * x[i, j + 1]


@vividc.kernel(f"void({M}, {M})")
def parallel_blur(x, y):
    for i in prange(1, x.shape[0] - 1):
        for j in range(1, x.shape[1] - 1):
            y[i, j] = x[i - 1, j] + x[i + 1, j] + x[i, j - 1] + 3 * x[i, j + 1]


@vividc.kernel(f"void({V}, {M}, {M})")
def two_fields(source, x, y):
    """A loop over time around three nests; the first reads where it is."""
    for t in range(1, len(source)):
        for j in range(x.shape[1]):
            x[0, j] = source[t] - t
        for i in range(1, x.shape[0]):
            for j in range(x.shape[1]):
                y[i, j] += x[i, j] - x[i - 1, j]
        for i in range(x.shape[0] - 1):
            for j in range(x.shape[1] - 1):
                x[i, j] -= y[i + 1, j] ^ y[i, j + 1]


@vividc.kernel(f"void(int32, {C}, {C})")
def two_volumes(steps, x, y):
    """Planes of three dimensions, there and back."""
    for _ in range(steps):
        for i in range(1, x.shape[0] - 1):
            for j in range(x.shape[1]):
                for k in range(x.shape[2]):
                    y[i, j, k] = x[i - 1, j, k] - 2 * x[i, j, k] + x[i + 1, j, k]
        for i in range(1, x.shape[0] - 1):
            for j in range(x.shape[1]):
                for k in range(x.shape[2]):
                    x[i, j, k] = y[i - 1, j, k] - 2 * y[i, j, k] + y[i + 1, j, k]


@vividc.kernel(f"void({M}, {V})")
def columns(x, sums):
    for j in range(x.shape[1]):
        sums[j] = 0
        for i in range(x.shape[0]):
            sums[j] += x[i, j]


@vividc.kernel(f"void({M})")
def scan(x):
    """Every row needs the one before."""
    for i in range(1, x.shape[0]):
        for j in range(x.shape[1]):
            x[i, j] += 3 * x[i - 1, j]


@vividc.kernel(f"void({M})")
def diagonals(x):
    """Blocks of columns must keep the order of rows."""
    for i in range(1, x.shape[0]):
        for j in range(x.shape[1] - 2):
            x[i, j] += 3 * x[i - 1, j + 2]


@vividc.kernel(f"void({M}, {M})")
def triangle(x, y):
    for i in range(x.shape[0]):
        for j in range(i + 1):
            y[i, j] = x[i, j] + x[i, 0]


@vividc.kernel("void(int16[:, ::1], int16[:, ::1])")
def halves(x, y):
    for i in range(1, x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] = x[i, j] - x[i - 1, j]


@vividc.kernel(f"void({C}, {C})")
def volume(x, y):
    for i in range(1, x.shape[0] - 1):
        for j in range(1, x.shape[1] - 1):
            for k in range(1, x.shape[2] - 1):
                y[i, j, k] = x[i - 1, j, k] + x[i, j + 1, k] + x[i, j, k - 1]


@vividc.kernel(f"void({M}, {V})")
def by_index(x, at):
    """Where it reads is not known before it runs."""
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            x[i, j] += at[j]
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            x[i, j] -= at[at[j] & 63]


SQUARES = (np.arange(64) ** 2 % 251).astype(np.int32)


@vividc.kernel(f"void({M}, {M})")
def by_table(x, y):
    """A nest that looks up constants, and one that does not."""
    for i in prange(1, x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] = x[i - 1, j] + SQUARES[x[i, j] & 63]
    for i in range(x.shape[0] - 1):
        for j in range(x.shape[1]):
            x[i, j] -= y[i + 1, j]


@vividc.kernel(f"void({M})")
def looked_up(x):
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            x[i, j] = SQUARES[(SQUARES[x[i, j] & 63] + j) & 63]


def test_arrays_of_one_name_share_the_place_of_the_largest() -> None:
    """At the end of a scratchpad, with the words that they have at launch."""
    program = vividc.compile(by_table, fabric="vivid", loops=vividc.LoopOptions(auto=False))
    own = [(LocalArray("a", 2), LocalArray("b", 0, size=("u:n", 2, "*"))), (LocalArray("a", 5),)]
    changed = [replace(n, locals=made) for n, made in zip(program.nests, own, strict=True)]
    end = program.fabric.scratchpad.size_bytes
    placed = table_extents(replace(program, nests=tuple(changed)), {"n": 3})
    assert placed == {"a": (end - 20, end), "b": (end - 44, end - 20)}


@pytest.fixture(autouse=True)
def engine() -> None:
    """The engine is of no account here: the other files of this room run jobs on both."""


@functools.cache
def program(kernel: KernelFunction) -> Program:
    loops = vividc.LoopOptions(auto=False)
    return vividc.compile(kernel, fabric="vivid", loops=loops, effort="fast")


def ints(*shape: int, dtype: type = np.int32) -> Any:
    return np.random.default_rng(5).integers(-1000, 1000, shape).astype(dtype)


ARGUMENTS = [
    (blur, lambda: (ints(61, 300), ints(61, 300))),
    (blur, lambda: (ints(70, 256), ints(70, 256))),
    (blur, lambda: (ints(9000, 3), ints(9000, 3))),
    (parallel_blur, lambda: (ints(20, 5000), ints(20, 5000))),
    (two_fields, lambda: (ints(4), ints(40, 150), ints(40, 150))),
    (columns, lambda: (ints(150, 99), ints(99))),
    (scan, lambda: (ints(50, 301),)),
    (diagonals, lambda: (ints(50, 301),)),
    (triangle, lambda: (ints(130, 130), ints(130, 130))),
    (halves, lambda: (ints(75, 301, dtype=np.int16), ints(75, 301, dtype=np.int16))),
    (volume, lambda: (ints(20, 30, 25), ints(20, 30, 25))),
    (by_index, lambda: (ints(80, 128), ints(128))),
    (by_table, lambda: (ints(61, 300), ints(61, 300))),
    (by_table, lambda: (ints(3, 8100), ints(3, 8100))),
    (looked_up, lambda: (ints(20, 9),)),
]


@pytest.mark.parametrize(
    ("kernel", "made"), ARGUMENTS, ids=[f"{k.name}-{n}" for n, (k, _) in enumerate(ARGUMENTS)]
)
def test_blocks_compute_what_numba_does(kernel: Any, made: Any) -> None:
    compiled = program(kernel)
    mine, numbas = made(), made()
    assert compiled.order is not None
    result = vividc.simulate(compiled, *mine, fabric="vivid")
    kernel(*numbas)
    assert all(np.array_equal(a, b) for a, b in zip(mine, numbas, strict=True))
    assert result.cycles > 0


def test_tiles_share_blocks_of_rows_and_columns() -> None:
    x, y = ints(200, 300), ints(200, 300)
    result = vividc.simulate(program(blur), x, y, fabric="vivid")
    assert {event.index for event in result.events if event.kind == "run"} == set(range(16))


def test_a_kernel_that_fits_a_tile_stays_there() -> None:
    x, y = ints(20, 30), ints(20, 30)
    result = vividc.simulate(program(blur), x, y, fabric="vivid")
    assert {event.index for event in result.events if event.kind == "run"} == {0}


def test_an_iteration_that_fits_no_scratchpad_is_refused() -> None:
    with pytest.raises(ArgumentError, match="one iteration of the loop needs"):
        vividc.simulate(program(columns), ints(9000, 2), ints(2), fabric="vivid")


def test_nests_travel_in_the_bundle() -> None:
    compiled = program(two_fields)
    data = compiled.to_bytes()
    again = from_bytes(data)
    assert again == compiled
    schema = re.search(rb'"vividc.program/(\d)"', data)
    assert schema is not None
    assert int(schema[1]) >= 4  # a reader of before would not know them
    mine, numbas = (ints(3), ints(40, 150), ints(40, 150)), (ints(3), ints(40, 150), ints(40, 150))
    vividc.simulate(again, *mine, fabric="vivid")
    two_fields(*numbas)
    assert all(np.array_equal(a, b) for a, b in zip(mine, numbas, strict=True))


def test_a_nest_in_a_bundle_has_no_nests() -> None:
    """One in another, and so on, would be read without end."""
    made = program(blur)
    inside = replace(made.nests[0], nests=made.nests, order=made.order)
    with pytest.raises(BundleError, match="has nests of its own"):
        from_bytes(replace(made, nests=(inside, *made.nests[1:])).to_bytes())


def test_overlaps_are_moved_to_both_and_nothing_else_twice() -> None:
    x, y = ints(128, 1024), ints(128, 1024)
    job = nests_job(program(blur), (x, y), {}, "vivid")
    assert job.moved < 1.3 * (x.nbytes + y.nbytes)


@vividc.kernel(f"void({V}, {M})")
def steps(count, x):
    for t in range(len(count)):
        for i in range(1, x.shape[0]):
            for j in range(x.shape[1]):
                x[i, j] += 3 * x[i - 1, j] + t


def test_a_launch_of_many_steps_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nests, "MOST_STEPS", 300)
    with pytest.raises(ArgumentError, match="more than 300 transfers and runs"):
        nests_job(program(steps), (ints(99), ints(90, 100)), {}, "vivid")


def test_rows_at_the_end_of_an_array_keep_their_pitch() -> None:
    """A pitch of as many words as there are banks makes all rows meet in one."""
    compiled = program(blur)
    job = nests_job(compiled, (ints(200, 1024), ints(200, 1024)), {}, "vivid")
    wish = compiled.nests[0].pitches.get("x")
    runs = [step for step in job.steps if isinstance(step, Execute)]
    assert wish is None or {step.inputs["x.pitch1"] % 8 for step in runs} == {wish}


def test_rows_of_less_than_words_have_no_pitch_in_blocks() -> None:
    assert not any(nest.pitches for nest in program(halves).nests)


@pytest.mark.parametrize(
    ("kernel", "scalars", "shapes"),
    [
        (blur, (), [(200, 1024)] * 2),
        (two_fields, (), [(9,), (100, 300), (100, 300)]),
        (two_volumes, (5,), [(40, 40, 40)] * 2),
    ],
    ids=["one nest", "nests in time", "blocks that are no multiple of the tiles"],
)
def test_the_prediction_is_near(
    kernel: vividc.KernelFunction, scalars: tuple[int, ...], shapes: list[tuple[int, ...]]
) -> None:
    """The next nest's program and first blocks come while the one before runs, and tiles that are
    done with one begin the next.
    """
    args = (*scalars, *(ints(*shape) for shape in shapes))
    expected = nests_cycles(program(kernel), args, {}, "vivid")
    cycles = vividc.simulate(program(kernel), *args, fabric="vivid").cycles
    assert 0.85 < expected / cycles < 1.15


def test_what_few_iterations_of_fit_a_block_is_not_run_several_at_once() -> None:
    """A plane of a volume or some rows of a matrix fit a scratchpad: eight at once would be mostly
    idle.
    """
    compiled = vividc.compile(two_volumes, fabric="vivid", effort="fast")
    arrays = [ints(40, 40, 40) for _ in range(2)]
    job = nests_job(compiled, (1, *arrays), {}, "vivid")
    assert job.simulate().stats["operations"]["store"] == 2 * 38 * 40**2

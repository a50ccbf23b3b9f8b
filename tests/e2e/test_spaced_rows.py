"""Matrices whose rows lie further apart than they are long, of which no launch can tell."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numba import prange

import vividc
from vividc.launch import At, Job
from vividc.program import Program
from vividc.sim.bind import bind

SHAPES = [(24, 24), (24, 16), (16, 8), (9, 7), (5, 1), (1, 9), (0, 4), (3, 0), (0, 0)]


@vividc.kernel("void(int32[:,::1], int32[:,::1])")
def columns(a, b):
    for j in range(a.shape[1]):
        for i in range(0, a.shape[0] - 3, 4):
            b[i, j] = a[i, j] + a[i + 1, j] * a[i + 2, j] - a[i + 3, j]
            b[i + 2, j] = a[i, j] ^ a[i + 3, j]


@vividc.kernel("void(int32[:,::1], int32[:,::1])")
def in_place(a, b):
    for i in range(1, a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] += a[i - 1, j] * 3
            b[i, j] -= a[i - 1, a.shape[1] - 1 - j]
            b[0, j] += a[i, j]


@vividc.kernel("void(int32[:,::1], int32[:,::1])")
def sizes_in_arithmetic(a, b):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            b[i, j] = a[i, j] + i * a.shape[1] + j + a[i, a.shape[1] - 1] * len(b)


@vividc.kernel("void(int32[:,::1], int32[:,::1])")
def by_rows_of_views(a, b):
    for i in range(a.shape[0]):
        row = a[i]
        for j in range(a.shape[1]):
            b[i, j] = row[j] * 5 + a[i, j]


@vividc.kernel("void(int32[:,::1], int32[:,::1])")
def flat_and_not(a, b):
    flat = a.reshape(-1)
    for k in range(len(flat)):
        flat[k] += k
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            b[i, j] = a[i, j] * 2


@vividc.kernel("void(int32[:,::1], int32[:,::1])")
def from_the_end(a, b):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            b[-1 - i, -1 - j] = a[i, j] - a[i, -1]


@vividc.kernel("void(uint8[:,::1], int16[:,::1])")
def bytes_to_halves(a, b):
    for i in range(1, a.shape[0] - 1):
        for j in range(1, a.shape[1] - 1):
            b[i, j] = a[i - 1, j] + a[i + 1, j] + 2 * a[i, j] - b[i - 1, j - 1] + a[i, j + 1]


@vividc.kernel("void(boolean[:,::1], uint16[:,::1])")
def flags_and_halves(a, b):
    for j in range(a.shape[1]):
        for i in range(a.shape[0] - 1):
            a[i, j] = a[i + 1, j] ^ (b[i, j] > b[i + 1, j])
            b[i, j] += 1


NARROW = (bytes_to_halves, flags_and_halves)
KERNELS = (
    columns,
    in_place,
    sizes_in_arithmetic,
    by_rows_of_views,
    flat_and_not,
    from_the_end,
    *NARROW,
)


@cache
def compiled(kernel: vividc.KernelFunction) -> Program:
    """The program, with pitches as they are chosen."""
    return vividc.compile(
        kernel, loops=vividc.LoopOptions(auto=False), time_limit_s=60.0, effort="fast"
    )


def wishing(kernel: vividc.KernelFunction, pitch: int) -> Program:
    """The program, with rows so many words apart modulo the banks."""
    program = compiled(kernel)
    per_word = {param.name: param.per_word for param in program.params}
    return replace(program, pitches={name: pitch * per_word[name] for name in program.pitches})


@pytest.fixture(autouse=True)
def always_spaced(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every matrix that may be spaced is, whether it pays or not."""
    monkeypatch.setattr("vividc.compiler.planning.spacing.PAYS", -1.0)


@pytest.mark.parametrize("pitch", [0, 1, 6])
@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: kernel.name)
def test_results_are_numbas(kernel: vividc.KernelFunction, pitch: int) -> None:
    program = wishing(kernel, pitch)
    dtypes = [np.dtype(param.dtype.value) for param in program.params]
    for number, shape in enumerate(SHAPES):
        draw = np.random.default_rng(number)
        mine = [draw.integers(-99, 99, shape).astype(dtype) for dtype in dtypes]
        theirs = deepcopy(mine)
        kernel(*theirs)
        for engine in ("reference", "native") if number > 2 else ("native",):
            ours = deepcopy(mine)
            vividc.simulate(program, *ours, engine=engine)
            for got, expected in zip(ours, theirs, strict=True):
                np.testing.assert_array_equal(got, expected)


@vividc.kernel("void(int32[:,::1], int32[:,::1])")
def searching(a, b):
    """Rows of `a` that are searched side by side: a load ahead tests whether it is in the array."""
    for i in prange(a.shape[0]):
        k = 0
        while k < a.shape[1] and a[i, k] > 0:
            k += 1 + (a[i, k] & 3)
        b[i, 0] = k


def test_an_address_that_is_tested_is_of_rows_end_to_end() -> None:
    loops = vividc.LoopOptions(threads=4)
    program = vividc.compile(searching, loops=loops, time_limit_s=60.0, effort="fast")
    assert "threads" in {t.kind for one in program.loops for t in one.transforms if t.chosen}
    program = replace(program, pitches=dict.fromkeys(program.pitches, 7))
    mine = [np.random.default_rng(0).integers(1, 99, (24, 24), dtype=np.int32) for _ in range(2)]
    theirs = deepcopy(mine)
    searching(*theirs)
    vividc.simulate(program, *mine)
    for got, expected in zip(mine, theirs, strict=True):
        np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize(
    ("kernel", "spaced"),
    [
        (columns, {"a", "b"}),
        (in_place, {"b"}),
        (sizes_in_arithmetic, {"b"}),
        (by_rows_of_views, {"b"}),
        (flat_and_not, {"b"}),
        (from_the_end, set()),
        *((kernel, {"a", "b"}) for kernel in NARROW),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_matrices_accessed_by_two_subscripts_only(
    kernel: vividc.KernelFunction, spaced: set[str]
) -> None:
    assert compiled(kernel).pitches.keys() == spaced


def test_rows_lie_as_far_apart_as_the_program_wishes() -> None:
    a = np.arange(24 * 24, dtype=np.int32).reshape(24, 24)
    bound = bind(wishing(columns, 3), (a, a.copy()), {})
    assert bound.pitches == {"a": 27, "b": 27}
    start, end = bound.extents["a"]
    assert end - start == 4 * (23 * 27 + 24)
    words = bound.memory[start // 4 : end // 4]
    assert [int(words[27 * row + 2]) for row in range(24)] == a[:, 2].tolist()
    assert not words[24:27].any()


def test_rows_of_bytes_are_whole_words_apart_if_they_are_spaced() -> None:
    a, b = np.arange(12 * 9, dtype=np.uint8).reshape(12, 9), np.zeros((12, 9), np.int16)
    bound = bind(wishing(bytes_to_halves, 3), (a, b), {})
    assert bound.pitches == {"a": 12, "b": 22}
    start, end = bound.extents["a"]
    assert end - start == 11 * 12 + 9 + 3
    held = bound.memory[start // 4 : end // 4].view(np.uint8)
    assert [int(held[12 * row + 2]) for row in range(12)] == a[:, 2].tolist()


def test_rows_lie_end_to_end_where_there_is_no_room() -> None:
    a, b = np.ones((250, 16), np.int32), np.ones((250, 16), np.int32)
    bound = bind(wishing(columns, 3), (a, b), {})
    assert bound.pitches == {"a": 16, "b": 16}
    vividc.simulate(wishing(columns, 3), a, b)
    assert b[0, 0] == 1


def test_a_job_gives_rows_end_to_end() -> None:
    program = wishing(columns, 3)
    a = np.arange(8 * 6, dtype=np.int32).reshape(8, 6)
    theirs = [a.copy(), a.copy()]
    columns(*theirs)
    job = Job("vivid")
    out = np.zeros_like(a)
    moves = [job.move_in(0, a, 0), job.move_in(0, a, a.nbytes)]
    run = job.run(0, program, a=At(0, a.shape), b=At(a.nbytes, a.shape), after=moves)
    job.move_out(0, a.nbytes, out, after=[run])
    job.simulate()
    np.testing.assert_array_equal(out, theirs[1])


def test_fewer_accesses_meet_in_a_bank() -> None:
    a = np.ones((24, 24), np.int32)
    stalls = [
        vividc.simulate(program, a.copy(), a.copy()).stats["stalls"]["bank_conflict"]
        for program in (wishing(columns, 0), compiled(columns))
    ]
    assert stalls[1] < stalls[0] / 2

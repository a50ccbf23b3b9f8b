"""Launch graphs by hand: what they compute, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numba import prange

import vividc
from tests.launch.kernels import double, program, saxpy, total
from vividc import arch
from vividc.arch import Accelerator, TileGroup
from vividc.errors import ArchError, ArgumentError, CycleLimit, SimulationError
from vividc.launch import At, Job, Listed


def test_strided_pieces_go_in_and_out() -> None:
    image = np.arange(20 * 30, dtype=np.int32).reshape(20, 30)
    out = np.zeros((20, 30), np.int32)
    job = Job("vivid")
    here = job.move_in(5, image[3:7, 10:18], 128)
    run = job.run(5, program(double), x=At(128, (32,)), n=32, after=[here])
    job.move_out(5, 128, out[::5, 2:10], after=[run])
    job.simulate()
    assert (out[::5, 2:10] == 2 * image[3:7, 10:18]).all()
    assert np.count_nonzero(out) == 32


def test_an_array_of_no_dimension_goes_in_and_out() -> None:
    x, y = np.array(5, np.int32), np.array(0, np.int32)
    job = Job("vivid")
    job.move_out(2, 64, y, after=[job.move_in(2, x, 64)])
    job.simulate()
    assert y == 5


def test_a_gather_takes_the_rows_that_earlier_steps_wrote() -> None:
    table = np.arange(40, dtype=np.int32).reshape(10, 4)
    rows = np.array([1, 2, 3], np.int32)
    out = np.zeros((3, 4), np.int32)
    job = Job("vivid")
    first = job.move_in(0, rows, 0)
    run = job.run(0, program(double), x=At(0, (3,)), n=3, after=[first])
    doubled = job.move_out(0, 0, rows, after=[run])
    rows_in = job.gather(1, table, rows, 64, after=[doubled])
    job.move_out(1, 64, out, after=[rows_in])
    job.simulate()
    assert rows.tolist() == [2, 4, 6]
    assert (out == table[rows]).all()


def test_a_gather_takes_the_rows_that_a_run_listed_as_far_as_its_bound() -> None:
    table = np.arange(40, dtype=np.int32).reshape(10, 4)
    halves = np.array([2, 3, 1, 4, 0], np.int32)  # how many, and rows; then doubled
    out = np.full((3, 4), -1, np.int32)
    job = Job("vivid")
    first = job.move_in(0, halves, 32)
    run = job.run(0, program(double), x=At(32, (5,)), n=5, after=[first])
    rows_in = job.gather(0, table, Listed(32, 3), 64, after=[run])
    job.move_out(0, 64, out, after=[rows_in])
    result = job.simulate()
    assert (out == table[[6, 2, 8]]).all()
    assert result.stats["bytes"]["scratchpad_out"] == 4 * 4 + out.nbytes


def test_a_list_is_read_where_it_is_complete() -> None:
    table, rows = np.zeros((10, 4), np.int32), np.array([1, 3], np.int32)
    job = Job("vivid")
    job.move_in(0, rows, 0)
    job.gather(0, table, Listed(0, 1), 64)
    with pytest.raises(ArgumentError, match="their order is not given"):
        job.simulate()
    with pytest.raises(ArgumentError, match="for one tile"):
        job.gather((0, 1), table, Listed(0, 1), 64)


@pytest.mark.parametrize("count", [0, 2, 5])
def test_as_many_rows_move_out_as_a_run_counted(count: int) -> None:
    out = np.full((5, 4), -1, np.int32)
    rows, numbers = np.arange(20, dtype=np.int32), np.array([7, count], np.int32)
    job = Job("vivid")
    moved = [job.move_in(3, rows, 64), job.move_in(3, numbers, 0)]
    run = job.run(3, program(double), x=At(0, (1,)), n=1, after=moved)
    job.move_out(3, 64, out, after=[run, *moved], count_at=4)
    result = job.simulate()
    assert (out[:count] == rows.reshape(5, 4)[:count]).all()
    assert (out[count:] == -1).all()
    moved_out = 16 * count
    assert result.stats["bytes"]["scratchpad_out"] == 4 + moved_out
    assert result.stats["bytes"]["dram_written"] == -(-moved_out // 32) * 32
    assert [e.size_bytes for e in result.events if e.kind == "move out"] == [moved_out]


def test_a_count_of_more_rows_than_there_are_is_refused() -> None:
    out = np.zeros((2, 4), np.int32)
    job = Job("vivid")
    moved = job.move_in(0, np.array([3], np.int32), 0)
    job.move_out(0, 64, out[:1], after=[moved])
    job.move_out(0, 64, out, after=[moved, 1], count_at=0)
    with pytest.raises(ArgumentError, match="told to move 3 rows of an array of 2"):
        job.simulate()
    assert not out.any()


def test_a_count_is_read_where_it_is_complete() -> None:
    job = Job("vivid")
    job.move_in(0, np.zeros(1, np.int32), 4)
    job.move_out(0, 64, np.zeros(4, np.int32), count_at=4)
    with pytest.raises(ArgumentError, match=r"step 1 .move out. and step 0 .*order is not given"):
        job.simulate()


def test_runs_return_values() -> None:
    x = np.arange(100, dtype=np.int32)
    job = Job("vivid")
    here = job.move_in(range(4), x, 0)
    runs = [
        job.run(tile, program(total), x=At(0, (10 * (tile + 1),)), after=[here])
        for tile in range(4)
    ]
    result = job.simulate()
    assert [result.values[run] for run in runs] == [x[: 10 * k].sum() for k in range(1, 5)]


def test_a_tile_changes_programs() -> None:
    x, y = np.arange(8, dtype=np.float32), np.ones(8, np.float32)
    job = Job("vivid")
    moves = [job.move_in(2, x, 0), job.move_in(2, y, 64)]
    arguments = {"x": At(0, (8,)), "y": At(64, (8,)), "n": 8}
    job.run(2, program(saxpy), after=moves, **arguments)
    job.run(2, program(double), x=At(96, (1,)), n=1)
    run = job.run(2, program(saxpy), **arguments)
    job.move_out(2, 64, y, after=[run])
    result = job.simulate()
    assert (y == 1 + 4 * x).all()
    assert result.stats["steps"]["configure"] == 3


def test_the_result_does_not_depend_on_threads() -> None:
    events = []
    for threads in (1, 3):
        x = np.arange(16 * 64, dtype=np.int32)
        job = Job("vivid")
        for tile in range(16):
            part = x[64 * tile : 64 * tile + 64]
            here = job.move_in(tile, part, 0)
            run = job.run(tile, program(double), x=At(0, (64,)), n=64, after=[here])
            job.move_out(tile, 0, part, after=[run])
        events.append(job.simulate(threads=threads).events)
        assert (x == 2 * np.arange(16 * 64)).all()
    assert events[0] == events[1]


def grouped() -> Accelerator:
    """A tile that is also a group, with one configuration memory."""
    text = "configuration: {entries_per_cycle: 16, double_buffered: false}"
    one = f"extends: vivid\nname: test\ntiles: {{rows: 1, cols: 1}}\n{text}\n"
    machine = arch.load_accelerator_text(one)
    return replace(machine, groups=(TileGroup(machine.fabric, (0,)),))


def test_a_tile_is_configured_again_after_its_group() -> None:
    job = Job(grouped())
    for unit in (0, 1, 0):
        job.run(unit, program(double), x=At(0, (8,)), n=8)
    assert job.simulate().stats["steps"]["configure"] == 3


def test_a_step_for_two_forms_of_a_tile_is_refused() -> None:
    with pytest.raises(ArgumentError, match="another form"):
        Job(grouped()).move_in((0, 1), np.zeros(8, np.int32), 0)


def unordered_moves() -> Job:
    x = np.zeros(8, np.int32)
    job = Job("vivid")
    job.move_in(0, x, 0)
    job.move_in(0, x + 1, 16)
    return job


def unordered_run() -> Job:
    job = Job("vivid")
    job.move_in(0, np.zeros(8, np.int32), 0)
    job.run(0, program(double), x=At(0, (8,)), n=8)
    return job


def unordered_dram() -> Job:
    x = np.zeros(8, np.int32)
    job = Job("vivid")
    job.move_out(0, 0, x[:5])
    job.move_in(1, x[4:], 0)
    return job


@pytest.mark.parametrize("make", [unordered_moves, unordered_run, unordered_dram])
def test_a_race_is_refused(make) -> None:
    with pytest.raises(ArgumentError, match="their order is not given") as error:
        make().simulate()
    assert "after=[" in str(error.value)


def test_steps_that_only_read_need_no_order() -> None:
    x = np.arange(8, dtype=np.int32)
    job = Job("vivid")
    job.move_in(0, x, 0)
    job.move_in(1, x, 0)
    job.move_in(0, x, 64)
    assert job.simulate().cycles > 0


def test_a_failing_run_changes_no_array() -> None:
    x, y = np.arange(8, dtype=np.int32), np.zeros(8, np.int32)
    job = Job("vivid")
    here = job.move_in(0, x, 0)
    done = job.move_out(0, 0, y, after=[here])
    job.run(0, program(double), x=At(0, (4,)), n=8, after=[done])
    with pytest.raises(SimulationError, match=r"outside|array"):
        job.simulate()
    assert not y.any()


def test_of_runs_that_fail_the_first_is_told() -> None:
    told = set()
    for threads in (1, 2, 5):
        job = Job("vivid")
        for tile in range(8):
            words = 4 + tile if tile > 2 else 20
            job.run(tile, program(double), x=At(0, (words,)), n=20)
        with pytest.raises(SimulationError) as error:
            job.simulate(threads=threads)
        told.add(str(error.value))
    assert len(told) == 1
    assert "28" in told.pop()  # the byte behind the seven words of tile 3


def test_a_run_has_a_cycle_limit() -> None:
    job = Job("vivid")
    job.run(0, program(double), x=At(0, (1000,)), n=1000)
    with pytest.raises(CycleLimit):
        job.simulate(cycle_limit=100)


def test_a_gather_outside_its_array_is_refused() -> None:
    table = np.arange(8, dtype=np.int32)
    job = Job("vivid")
    job.gather(0, table, np.array([1, 8], np.int32), 0)
    with pytest.raises(
        ArgumentError, match=r"step 0 .gather. is told row 8 .* 8 rows, by number 1"
    ):
        job.simulate()


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda job, x: job.move_in(16, x, 0), "no tile 16"),
        (lambda job, x: job.move_in([1, 1], x, 0), "once each"),
        (lambda job, x: job.move_in(0, x, 32760), "bytes 32760 to 32792"),
        (lambda job, x: job.move_in(0, x.astype(np.float64), 0), "float64"),
        (lambda job, x: job.move_in(0, [1, 2], 0), "expected a numpy array"),
        (lambda job, x: job.move_in(0, x, 0, after=[0]), "no step 0"),
        (lambda job, x: job.gather(0, x, x.astype(np.float32), 0), "int32 or uint32"),
        (lambda job, x: job.move_out(0, 0, x, count_at=32768), "the count would lie at"),
        (lambda job, x: job.move_out(0, 0, x, count_at=2), "the count starts at 2"),
        (lambda job, x: job.move_out(0, 0, x, count_at="n"), "count_at"),
        (lambda job, x: job.move_out(0, 0, x[0, ...], count_at=64), "no rows to count"),
        (lambda job, x: job.gather(0, x, Listed(2, 1), 0), "list of indices starts at 2"),
        (lambda job, x: job.gather(0, x, Listed(0, -1), 0), "of at most -1 indices"),
        (lambda job, x: job.gather(0, x, Listed("n", 1), 0), "the address of a list"),
        (lambda job, x: job.gather(0, x[::2], x, 0), "array of a gather is not C-contiguous"),
        (lambda job, x: job.scatter(0, 0, x[::2], x), "array of a scatter is not C-contiguous"),
        (lambda job, x: job.scatter(0, 0, x, x.reshape(2, 4)), "scatter's indices must be one-dim"),
        (lambda job, x: job.scatter(0, 0, x, x.astype(np.int16)), "int32 or uint32"),
        (lambda job, x: job.scatter(0, 32740, x, x), "bytes 32740 to 32772"),
        (lambda job, x: job.scatter(0, 0, x, Listed(32768, 0)), "list of indices would lie at"),
        (lambda job, x: job.scatter(0, 0, x, Listed(0, 8192)), "list of indices would lie at"),
        (lambda job, x: job.scatter(0, 0, x, Listed(0, 1.5)), "the length of a list"),
        (lambda job, x: job.scatter((0, 1), 0, x, x), "a tile"),
        (lambda job, x: job.move_out((0, 1), 0, x), "a tile"),
        (lambda job, x: job.run(0, program(double), n=3), "At\\(address, shape\\)"),
        (lambda job, x: job.run(0, program(double), x=At(0, (3,))), "misses n"),
        (lambda job, x: job.run(0, program(double), x=At(2, (3,)), n=3), "multiple of 4"),
        (lambda job, x: job.run(0, program(double), x=At(0, (9000,)), n=3), "array x"),
    ],
)
def test_steps_that_make_no_sense_are_refused(call, says: str) -> None:
    with pytest.raises(ArgumentError, match=says):
        call(Job("vivid"), np.arange(8, dtype=np.int32))


def test_a_program_for_another_tile_is_refused() -> None:
    with pytest.raises(ArgumentError, match="was compiled for vivid-tile"):
        Job("vivid-unit").configure(0, program(double))


def test_a_read_only_target_is_refused() -> None:
    x = np.arange(8, dtype=np.int32)
    x.flags.writeable = False
    with pytest.raises(ArgumentError, match="target of a move out is read-only"):
        Job("vivid").move_out(0, 0, x)
    with pytest.raises(ArgumentError, match="target of a scatter is read-only"):
        Job("vivid").scatter(0, 0, x, x)


def test_a_job_needs_an_accelerator() -> None:
    with pytest.raises(ArchError, match="single tile"):
        Job("vivid-tile")


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def spreads(x, y, n):
    s = np.int32(3)
    for i in prange(n // 2):
        y[i] = 3 * x[i]
        s += x[i]
    return s


def test_a_run_by_hand_takes_all_iterations_of_a_parallel_loop() -> None:
    x, y = np.arange(40, dtype=np.int32), np.zeros(40, np.int32)
    job = Job("vivid")
    moves = [job.move_in(6, x, 0), job.move_in(6, y, 160)]
    run = job.run(6, program(spreads), x=At(0, (40,)), y=At(160, (40,)), n=41, after=moves)
    job.move_out(6, 160, y, after=[run])
    result = job.simulate()
    expected = np.zeros(40, np.int32)
    assert result.values[run] == spreads(x, expected, 41)
    assert (y == expected).all()


@pytest.mark.parametrize("start", [0, 64, 156])
def test_arrays_of_a_run_that_overlap_are_refused(start: int) -> None:
    job = Job("vivid")
    with pytest.raises(ArgumentError, match="x and y of spreads overlap") as error:
        job.run(0, program(spreads), x=At(0, (40,)), y=At(start, (40,)), n=40)
    assert error.value.hint


def test_arrays_over_one_buffer_are_one_memory() -> None:
    held = bytearray(4 * 8)
    whole, part = np.frombuffer(held, np.int32), np.frombuffer(held, np.int32, 4, 16)
    whole[:] = np.arange(8)
    job = Job("vivid")
    first = job.run(0, program(double), x=At(0, (8,)), n=8, after=[job.move_in(0, whole, 0)])
    out = job.move_out(0, 0, whole, after=[first])
    job.move_in(1, part, 0)
    with pytest.raises(ArgumentError, match="same bytes of one array"):
        job.simulate()
    job = Job("vivid")
    first = job.run(0, program(double), x=At(0, (8,)), n=8, after=[job.move_in(0, whole, 0)])
    out = job.move_out(0, 0, whole, after=[first])
    second = job.run(
        1, program(double), x=At(0, (4,)), n=4, after=[job.move_in(1, part, 0, after=[out])]
    )
    job.move_out(1, 0, part, after=[second])
    job.simulate()
    assert whole.tolist() == [0, 2, 4, 6, 16, 20, 24, 28]


def test_arrays_that_share_a_part_of_a_buffer_are_refused() -> None:
    held = bytearray(4 * 8)
    job = Job("vivid")
    job.move_in(0, np.frombuffer(held, np.int32, 6, 0), 0)
    with pytest.raises(ArgumentError, match="share memory") as error:
        job.move_in(0, np.frombuffer(held, np.int32, 6, 8), 64)
    assert error.value.hint


@vividc.kernel("int32(int32[::1])")
def turned(x):
    t = np.zeros(8, np.int32)
    for i in range(len(x)):
        t[i] = x[len(x) - 1 - i]
    return t[0] - t[7]


def test_an_array_that_a_kernel_makes_leaves_what_lies_behind_the_arguments() -> None:
    x, behind = np.arange(8, dtype=np.int32), np.full(8, 77, np.int32)
    job = Job("vivid")
    moves = [job.move_in(0, x, 0), job.move_in(0, behind, 32)]
    run = job.run(0, program(turned), x=At(0, (8,)), after=moves)
    job.move_out(0, 32, behind, after=[run])
    assert job.simulate().values[run] == 7
    assert behind.tolist() == [77] * 8


def test_an_array_that_a_kernel_makes_leaves_what_a_run_wrote() -> None:
    x, y = np.arange(8, dtype=np.int32), np.zeros(8, np.int32)
    job = Job("vivid")
    moved = job.move_in(0, x, 32)
    first = job.run(0, program(double), x=At(32, (8,)), n=8, after=[moved])
    again = job.move_in(0, x, 0, after=[moved])
    second = job.run(0, program(turned), x=At(0, (8,)), after=[first, again])
    job.move_out(0, 32, y, after=[second])
    job.simulate()
    assert y.tolist() == (2 * x).tolist()


def test_what_a_kernels_own_array_overwrote_cannot_be_read() -> None:
    x, rest = np.arange(8, dtype=np.int32), np.full(8184, 77, np.int32)
    job = Job("vivid")
    moves = [job.move_in(0, x, 0), job.move_in(0, rest, 32)]
    run = job.run(0, program(turned), x=At(0, (8,)), after=moves)
    with pytest.raises(ArgumentError, match="bytes 32 to 64 of tile 0, where arrays that turned"):
        job.move_out(0, 32, rest, after=[run])
    with pytest.raises(ArgumentError, match="x of turned reads bytes 32 to 64"):
        job.run(0, program(turned), x=At(32, (8,)), after=[run])
    job.move_out(0, 64, rest[8:], after=[run])
    anew = job.move_in(0, x, 32, after=[run])
    job.move_out(0, 32, rest[:8], after=[anew])
    assert job.simulate().values[run] == 7
    assert rest.tolist() == [*range(8), *[77] * 8176]


def test_a_kernel_without_arrays_of_its_own_overwrites_nothing() -> None:
    x, out = np.arange(16, dtype=np.int32), np.zeros(16, np.int32)
    job = Job("vivid")
    moved = job.move_in(0, x, 0)
    run = job.run(0, program(total), x=At(0, (8,)), after=[moved])
    job.move_out(0, 0, out, after=[run])
    assert job.simulate().values[run] == 28
    assert out.tolist() == x.tolist()


def test_arrays_that_a_kernel_makes_lie_where_they_are_told_to() -> None:
    x, rest = np.arange(8, dtype=np.int32), np.full(8, 77, np.int32)
    job = Job("vivid")
    moves = [job.move_in(0, x, 0), job.move_in(0, rest, 1024)]
    run = job.run(0, program(turned), own_at=1024, x=At(0, (8,)), after=moves)
    with pytest.raises(ArgumentError, match="bytes 1052 to 1056 of tile 0, where arrays that turn"):
        job.move_out(0, 0, x, after=[run], count_at=1052)
    with pytest.raises(ArgumentError, match="bytes 1024 to 1056 of tile 0, where arrays that turn"):
        job.move_out(0, 1024, rest, after=[run])
    assert job.simulate().values[run] == 7


def test_the_words_of_each_corner_do_what_those_they_mirror_do() -> None:
    """The reference engine runs the words of each tile, the native one those that were compiled."""
    results = []
    for engine in ("reference", "native"):
        rng = np.random.default_rng(4)
        out = np.zeros((16, 40), np.float32)
        job = Job("vivid")
        for tile in range(16):
            x, y = rng.standard_normal((2, 40)).astype(np.float32)
            moved = [job.move_in(tile, x, 0), job.move_in(tile, y, 200)]
            places = {"x": At(0, (40,)), "y": At(200, (40,))}
            run = job.run(tile, program(saxpy), n=40, **places, after=moved)
            job.move_out(tile, 200, out[tile], after=[run])
        result = job.simulate(engine=engine)
        stats = {name: value for name, value in result.stats.items() if name != "engine"}
        results.append((out.tobytes(), result.cycles, stats))
    assert results[0] == results[1]

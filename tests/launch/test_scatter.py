"""Rows that leave a scratchpad for places that a list says, and their order with other steps."""

from __future__ import annotations

import numpy as np
import pytest

from tests.launch.kernels import double, program
from tests.launch.test_job import turned
from vividc.errors import ArgumentError
from vividc.launch import At, Job, Listed


def moved_in(job: Job, tile: int, rows: np.ndarray) -> int:
    """The step that brings rows to byte 64, without an order with others."""
    return job.move_in(tile, rows, 64)


@pytest.mark.parametrize("dtype", [np.int32, np.float32, np.uint8, np.float16, np.bool_])
def test_rows_go_where_a_list_in_dram_says(dtype: type) -> None:
    rows = (np.arange(15) % 4).astype(dtype).reshape(5, 3)
    table = np.ones((9, 3), dtype)
    expected = table.copy()
    places = np.array([7, 0, 8, 2, 3], np.uint32)
    expected[places] = rows
    job = Job("vivid")
    job.scatter(5, 64, table, places, after=[moved_in(job, 5, rows)])
    job.simulate()
    assert (table == expected).all()


def test_other_words_than_0_and_1_leave_as_true() -> None:
    flags = np.zeros(4, np.bool_)
    job = Job("vivid")
    job.scatter(
        0, 64, flags, np.array([2, 0], np.int32), after=[moved_in(job, 0, np.uint8([4, 0]))]
    )
    job.simulate()
    assert flags.view(np.uint8).tolist() == [0, 0, 1, 0]


def test_rows_go_where_a_list_that_earlier_steps_wrote_says() -> None:
    rows, places = np.arange(6, dtype=np.int32).reshape(3, 2), np.array([1, 0, 3], np.int32)
    table = np.full((8, 2), -1, np.int32)
    job = Job("vivid")
    first = job.move_in(0, places, 0)
    run = job.run(0, program(double), x=At(0, (3,)), n=3, after=[first])
    doubled = job.move_out(0, 0, places, after=[run])
    job.scatter(1, 64, table[1:], places, after=[doubled, moved_in(job, 1, rows)])
    job.simulate()
    assert table[[3, 1, 7]].tolist() == rows.tolist()
    assert (table[[0, 2, 4, 5, 6]] == -1).all()


def test_rows_go_where_a_run_listed_as_far_as_its_bound() -> None:
    rows, table = np.arange(12, dtype=np.int32).reshape(3, 4), np.full((10, 4), -1, np.int32)
    halves = np.array([2, 3, 1, 4, 0], np.int32)  # how many, and rows; then doubled
    job = Job("vivid")
    first = job.move_in(0, halves, 32)
    run = job.run(0, program(double), x=At(32, (5,)), n=5, after=[first])
    job.scatter(0, 64, table, Listed(32, 3), after=[run, moved_in(job, 0, rows)])
    result = job.simulate()
    assert table[[6, 2, 8]].tolist() == rows.tolist()
    assert (np.delete(table, [6, 2, 8], axis=0) == -1).all()
    assert result.stats["bytes"]["scratchpad_out"] == 4 * 4 + rows.nbytes
    assert result.stats["steps"]["scatter"] == 1
    assert [e.size_bytes for e in result.events if e.kind == "scatter"] == [rows.nbytes]


@pytest.mark.parametrize("width", [1, 4, 20])
def test_of_a_row_that_is_listed_twice_the_last_stays(width: int) -> None:
    """Whether or not both lie in one granule."""
    rng = np.random.default_rng(width)
    rows = rng.integers(0, 99, (40, width), dtype=np.int32)
    places = rng.integers(0, 6, 40, dtype=np.int32)
    table = np.zeros((6, width), np.int32)
    expected = table.copy()
    for place, row in zip(places, rows, strict=True):
        expected[place] = row
    job = Job("vivid")
    job.scatter(0, 64, table, places, after=[moved_in(job, 0, rows)])
    job.simulate()
    assert (table == expected).all()


@pytest.mark.parametrize("shape", [(0, 4), (5, 0), (5, 4)])
def test_no_rows_change_nothing(shape: tuple[int, int]) -> None:
    table = np.full(shape, 3, np.int32)
    job = Job("vivid")
    zero = job.move_in(0, np.zeros(1, np.int32), 0)
    last = job.scatter(0, 64, table, Listed(0, 9), after=[zero])
    last = job.scatter(0, 64, table, Listed(0, 0), after=[last])
    job.scatter(0, 64, table, np.zeros(0, np.int32), after=[last])
    assert job.simulate().stats["bytes"]["dram_written"] == 0
    assert (table == 3).all()


@pytest.mark.parametrize("wrong", [8, -1])
def test_a_row_outside_of_the_array_is_refused(wrong: int) -> None:
    table, other = np.zeros(8, np.int32), np.zeros(4, np.int32)
    numbers = np.array([3, 4, wrong, 5], np.int32)
    says = r"step 2 .scatter. is told row {} of an array of 8 rows, by number 1 of its list"
    for indices, row in ((numbers[1:], wrong), (Listed(64, 3), wrong % 2**32)):
        job = Job("vivid")
        done = job.move_out(0, 64, other, after=[moved_in(job, 0, numbers)])
        job.scatter(0, 0, table, indices, after=[done])
        with pytest.raises(ArgumentError, match=says.format(row)):
            job.simulate()
        assert not table.any()
        assert not other.any()


def side_by_side(first: list[int], second: list[int], **more: object) -> Job:
    """Two tiles that write rows of one table, by lists in one array."""
    table, lists = np.zeros((10, 2), np.int32), np.array([*first, *second], np.int32)
    job = Job("vivid")
    moves = [moved_in(job, tile, np.ones((8, 2), np.int32)) for tile in (0, 1)]
    job.scatter(0, 64, table, lists[: len(first)], after=[moves[0]])
    job.scatter(1, 64, table, lists[len(first) :], after=[moves[1]])
    if "writes_a_list" in more:
        job.move_out(2, 0, lists[-1:], after=[2, 3])
    return job


def test_scatters_of_different_rows_need_no_order() -> None:
    assert side_by_side([1, 9, 4, 1], [0, 2, 3, 8]).simulate().cycles > 0
    with pytest.raises(ArgumentError, match=r"step 3 .scatter. and step 2 .scatter. use the same"):
        side_by_side([1, 9, 4, 1], [0, 2, 4, 8]).simulate()


def test_scatters_by_one_list_need_no_order() -> None:
    first, second = np.zeros((2, 4), np.int32), np.zeros(4, np.int32)
    places, job = np.array([1, 0], np.int32), Job("vivid")
    job.scatter(0, 64, first, places)
    job.scatter(0, 64, second, places)
    assert job.simulate().cycles > 0


def test_a_row_outside_of_a_part_is_none_of_the_whole() -> None:
    table, job = np.zeros(8, np.int32), Job("vivid")
    job.scatter(0, 64, table[:4], np.array([5], np.int32))
    job.move_out(0, 0, table[5:])
    with pytest.raises(ArgumentError, match="is told row 5 of an array of 4 rows"):
        job.simulate()


def test_a_list_that_a_step_writes_may_have_any_row() -> None:
    with pytest.raises(ArgumentError, match=r"step 3 .scatter. and step 2 .scatter. use the same"):
        side_by_side([1, 9, 4, 1], [0, 2, 3, 8], writes_a_list=True).simulate()


def test_a_list_in_a_scratchpad_may_have_any_row() -> None:
    table = np.zeros((10, 2), np.int32)
    job = Job("vivid")
    job.scatter(0, 64, table, Listed(0, 2))
    job.move_out(1, 64, table[9:])
    with pytest.raises(ArgumentError, match=r"step 1 .move out. and step 0 .scatter. use the same"):
        job.simulate()


def test_a_gather_may_read_the_rows_that_a_scatter_leaves() -> None:
    table, out = np.arange(10, dtype=np.int32), np.zeros(3, np.int32)
    for read, races in ((np.array([1, 8, 9], np.int32), False), (np.array([1, 8, 7]), True)):
        job = Job("vivid")
        job.scatter(0, 64, table, np.array([7, 0], np.int32))
        rows = job.gather(1, table, read.astype(np.int32), 0)
        job.move_out(1, 0, out, after=[rows])
        if races:
            with pytest.raises(ArgumentError, match=r"step 1 .gather. and step 0 .scatter. use"):
                job.simulate()
        else:
            job.simulate()
            assert out.tolist() == [1, 8, 9]


@pytest.mark.parametrize(("address", "at"), [(0, 32), (32, 0)])
def test_rows_and_their_list_leave_when_they_are_complete(address: int, at: int) -> None:
    """What is moved to byte 32 is the list, or the rows."""
    job = Job("vivid")
    job.move_in(0, np.zeros(4, np.int32), 32)
    job.scatter(0, address, np.zeros(9, np.int32), Listed(at, 3))
    with pytest.raises(ArgumentError, match=r"step 1 .scatter. and step 0 .move in. use the same"):
        job.simulate()


def test_a_list_by_which_a_scatter_is_overwritten_is_read_before() -> None:
    places, rows = np.array([3, 2, 0, 1], np.int32), np.array([0, 1, 2, 3], np.int32)
    job = Job("vivid")
    job.scatter(0, 64, places, places, after=[moved_in(job, 0, rows)])
    job.simulate()
    assert places.tolist() == [2, 3, 1, 0]


def test_what_a_kernels_own_array_overwrote_cannot_leave() -> None:
    x, table = np.arange(8, dtype=np.int32), np.zeros(8, np.int32)
    job = Job("vivid")
    moves = [job.move_in(0, x, 0), job.move_in(0, x, 1024)]
    run = job.run(0, program(turned), own_at=1024, x=At(0, (8,)), after=moves)
    with pytest.raises(ArgumentError, match="a scatter reads bytes 1024 to 1056 of tile 0"):
        job.scatter(0, 1024, table, x, after=[run])
    with pytest.raises(ArgumentError, match="a scatter reads bytes 1024 to 1036 of tile 0"):
        job.scatter(0, 0, table, Listed(1024, 2), after=[run])

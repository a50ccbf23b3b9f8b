"""Recordings show what the engine did, in the cycles in which it did it."""

import numpy as np
import pytest

from tests.sim.native.agreement import launch
from vividc.errors import ArgumentError
from vividc.sim import NativeEngine, ReferenceEngine
from vividc.sim.run import simulate
from vividc.sim.view import Timeline, heat_map, record, utilization

X = np.arange(40, dtype=np.int32)


def strided_arguments(n=4):
    return np.arange(256, dtype=np.int32), np.zeros(n, np.int32), 8, 16, n


@pytest.mark.parametrize("name", ["total", "strided", "find"])
def test_spans_are_the_same_from_both_engines_and_add_up(programs, name):
    program = programs[name]
    arguments = {"total": (X, 40), "strided": strided_arguments(), "find": (X, 17)}[name]
    found = []
    for engine in (ReferenceEngine, NativeEngine):
        line = Timeline()
        given = launch(program, *arguments)
        given = type(given)(given.memory, given.inputs, 10**6, given.extents, observer=line.add)
        run = engine(program).run(given)
        spans = line.spans
        found.append(spans)
        assert sum(span.end - span.start for span in spans) + run.switch_cycles == run.cycles
        assert spans[0].start == 0
        assert spans[-1].end == run.cycles
        for index, region in enumerate(run.regions):
            own = [span for span in spans if span.region == index]
            assert len(own) == region.entries
            assert sum(span.iterations for span in own) == region.iterations
            assert sum(span.bank_stalls for span in own) == region.bank_stalls
    assert found[0] == found[1]


def test_a_whole_run_is_recorded(programs):
    result = simulate(programs["total"], X, 40)
    recording = record(programs["total"], (X, 40), {})
    assert (recording.first, recording.end, recording.stopped) == (0, result.cycles, None)
    counted: dict[str, int] = {}
    for issued in recording.issued:
        for one in issued:
            counted[one.op] = counted.get(one.op, 0) + 1
    assert counted == result.stats["operations"]
    assert not recording.stalled().any()
    assert len(recording.cycles) == result.cycles - result.stats["switch_cycles"]


def test_stalls_are_the_cycles_in_which_nothing_happens_inside_a_region(programs):
    arguments = strided_arguments()
    stalls = simulate(programs["strided"], *arguments).stats["stalls"]["bank_conflict"]
    assert stalls > 0
    recording = record(programs["strided"], strided_arguments(), {})
    assert recording.stalled().sum() == stalls
    for first, end in ((0, 9), (3, 11), (8, 10)):
        part = record(programs["strided"], strided_arguments(), {}, window=(first, end))
        np.testing.assert_array_equal(part.stalled(), recording.stalled()[first:end])


def test_a_window_is_a_part_of_the_whole(programs):
    whole = record(programs["total"], (X, 40), {})
    part = record(programs["total"], (X, 40), {}, window=(10, 20))
    assert (part.first, part.end) == (10, 20)
    inside = (whole.cycles >= 10) & (whole.cycles < 20)
    np.testing.assert_array_equal(part.cycles, whole.cycles[inside])
    np.testing.assert_array_equal(part.words, whole.words[inside])
    assert part.issued == tuple(i for i, keep in zip(whole.issued, inside, strict=True) if keep)


def test_a_window_behind_the_end_is_empty(programs):
    recording = record(programs["total"], (X, 3), {}, window=(5000, 5100))
    assert recording.end == recording.first == 5000
    assert recording.issued == ()
    assert utilization(recording).sum() == 0
    assert heat_map(recording).shapes


def test_arrays_are_left_alone(programs):
    x, y, a, b, n = strided_arguments()
    record(programs["strided"], (x, y, a, b, n), {})
    assert not y.any()


def test_a_run_that_goes_wrong_is_recorded_up_to_there(programs):
    recording = record(programs["find"], (X, 99), {})
    assert "out-of-bounds" in str(recording.stopped)
    assert recording.end == recording.cycles[-1] + 1


@pytest.mark.parametrize("window", [(5, 5), (7, 3), (-1, 4)])
def test_an_empty_window_is_refused(programs, window):
    with pytest.raises(ArgumentError, match="is empty"):
        record(programs["total"], (X, 40), {}, window=window)


def test_utilization_in_bins(programs):
    recording = record(programs["total"], (X, 40), {})
    fine, coarse = utilization(recording, 10**6), utilization(recording, 7)
    size = recording.end
    assert fine.shape == (16, size)
    assert set(np.unique(fine)) <= {0.0, 1.0}
    width = -(-size // 7)
    lengths = [min(width, size - k * width) for k in range(coarse.shape[1])]
    np.testing.assert_allclose((coarse * lengths).sum(axis=1), fine.sum(axis=1))
    issues = sum(simulate(programs["total"], X, 40).stats["operations"].values())
    assert fine.sum() == issues

"""The reference interpreter on small graphs whose results are worked out by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from vividc.dfg.forms.text import parse
from vividc.dfg.interpret.interpreter import RegionRun, interpret, interpret_region
from vividc.dfg.ir import DFG
from vividc.dfg.regions import RETURN_VARIABLE, Kernel, Region
from vividc.errors import ArgumentError, DFGError, SimulationError

MINUS_ONE = 0xFFFFFFFF


def loop(
    text: str,
    memory: np.ndarray | bytearray | None = None,
    trip: int | None = 4,
    env: Mapping[str, int] | None = None,
    limit: int = 1000,
) -> RegionRun:
    scratchpad = np.zeros(8, np.uint32) if memory is None else memory
    dfg = parse(text, file="test.dfg")
    return interpret_region(dfg, "loop", trip, env or {}, scratchpad, iteration_limit=limit)


SUM = """dfg "sum"
%0 = iv
%1 = const 0x00000064
%2 = add %0, %2@1(init=%1)
%3 = live_out "%s" %2
"""


def test_a_recurrence_starts_from_its_init() -> None:
    run = loop(SUM)
    assert run.written == {"%s": 100 + 0 + 1 + 2 + 3}
    assert run.iterations == 4


@pytest.mark.parametrize("trip", [0, MINUS_ONE, 0x80000000])
def test_no_iteration_for_a_trip_count_of_zero_or_less(trip: int) -> None:
    assert loop(SUM, trip=trip) == RegionRun(iterations=0, written={})


def test_a_longer_distance_reads_the_init_that_often() -> None:
    run = loop(
        """dfg "delay"
%0 = iv
%1 = const 0x00000009
%2 = mov %0
%3 = add %2@3(init=%1), %2@1(init=%1)
%4 = live_out "%now" %3
%5 = mov %3
%6 = mov %5@1(init=%1)
%7 = live_out "%before" %6
""",
        trip=4,
    )
    assert run.written == {"%now": 0 + 2, "%before": 9 + 1}


def test_carried_values_move_together() -> None:
    """a, b = b, a must not lose a value on its way."""
    run = loop(
        """dfg "swap"
%0 = const 0x00000001
%1 = const 0x00000002
%2 = mov %3@1(init=%0)
%3 = mov %2@1(init=%1)
%4 = live_out "%a" %2
%5 = live_out "%b" %3
""",
        trip=3,
    )
    assert run.written == {"%a": 1, "%b": 2}


MEMORY = """dfg "memory"
%0 = live_in "&x"
%1 = iv
%2 = const 0x00000002
%3 = icmp.slt %1, %2
%4 = load "x" %1 shift 2 offset 4 base %0 if %3
%5 = add %4, %2
%6 = store "x" %1, %5 shift 2 base %0 if %3 after %4
%7 = live_out "%last" %4
"""


def test_a_predicated_off_access_does_not_happen() -> None:
    memory = np.arange(10, 18, dtype=np.uint32)
    run = loop(MEMORY, memory, env={"&x": 8})
    assert memory.tolist() == [10, 11, 15, 16, 14, 15, 16, 17]
    assert run.written == {"%last": 0}


def test_the_memory_may_be_bytes() -> None:
    memory = bytearray(np.arange(10, 18, dtype=np.uint32).tobytes())
    loop(MEMORY, memory, env={"&x": 8})
    assert memory[8] == 15


def test_a_predicated_off_operation_passes_its_last_operand() -> None:
    run = loop(
        """dfg "pass"
%0 = iv
%1 = const 0x00000001
%2 = icmp.eq %0, %1
%3 = add %1, %0 if %2
%4 = live_out "%v" %3
"""
    )
    assert run.written == {"%v": 3}


ADDRESSES = """dfg "far"
%0 = const 0x00000000
%1 = iv
%2 = load "x" %1 shift {shift} offset {offset} base %0 !kernel.py:3
%3 = live_out "%v" %2
"""


@pytest.mark.parametrize(
    ("shift", "offset", "reason"),
    [
        (2, 32, "at byte 32 leaves the 32 bytes of the scratchpad"),
        (2, -4, "at byte -4 leaves"),
        (4, 0, "at byte 32 leaves"),
        (2, 2, "at byte 2 is not aligned to 4 bytes"),
    ],
)
def test_a_wrong_access_names_the_source_line(shift: int, offset: int, reason: str) -> None:
    with pytest.raises(SimulationError) as error:
        loop(ADDRESSES.format(shift=shift, offset=offset))
    assert str(error.value).startswith("kernel.py:3: load of x ")
    assert reason in str(error.value)


EXIT = """dfg "exit"
%0 = live_in "&x"
%1 = iv
%2 = const 0x00000002
%3 = icmp.eq %1, %2 exit
%4 = store "x" %1, %2 shift 2 base %0 control %3@1
%5 = store "x" %1, %2 shift 2 offset 16 base %0 control %3 unless_exit
%6 = mov %1
%7 = live_out "%through" %6 control %3@1
%8 = live_out "%before" %6 control %3 unless_exit
"""


def test_the_exiting_iteration_has_only_its_unconditional_effects() -> None:
    memory = np.zeros(8, np.uint32)
    run = loop(EXIT, memory, trip=None, env={"&x": 0})
    assert memory.tolist() == [2, 2, 2, 0, 2, 2, 0, 0]
    assert run.written == {"%through": 2, "%before": 1}
    assert run.iterations == 3


def test_a_trip_count_and_an_exit_may_be_combined() -> None:
    memory = np.zeros(8, np.uint32)
    assert loop(EXIT, memory, trip=2, env={"&x": 0}).iterations == 2
    assert loop(EXIT, memory, trip=7, env={"&x": 0}).iterations == 3


def test_a_loop_that_never_ends_meets_the_limit() -> None:
    with pytest.raises(SimulationError, match="iteration limit"):
        loop(SUM, trip=1001)
    never = 'dfg "never"\n%0 = iv\n%1 = icmp.slt %0, %0 exit\n'
    with pytest.raises(SimulationError, match="region never: the iteration limit"):
        loop(never, trip=None)


def test_a_loop_without_an_end_is_refused() -> None:
    with pytest.raises(DFGError, match="neither a trip count nor an exit"):
        loop(SUM, trip=None)


def test_order_edges_decide_within_an_iteration() -> None:
    text = """dfg "order"
%0 = const 0x00000000
%1 = const 0x00000007
%2 = load "x" %0 shift 2 base %0 {load}
%3 = store "x" %0, %1 shift 2 base %0 {store}
%4 = live_out "%v" %2
"""
    assert loop(text.format(load="after %3", store=""), trip=1).written == {"%v": 7}
    assert loop(text.format(load="", store="after %2"), trip=1).written == {"%v": 0}


def test_a_broken_graph_is_refused() -> None:
    with pytest.raises(DFGError, match="nothing feeds port 1"):
        loop('dfg "d"\n%0 = iv\n%1 = add %0\n')
    with pytest.raises(DFGError, match="has distance 1 and no init"):
        loop('dfg "d"\n%0 = iv\n%1 = add %0, %1@1\n')
    with pytest.raises(DFGError, match="no meaning that can be run"):
        loop('dfg "d"\n%0 = generic "CMERGE"\n')


def test_a_missing_live_in_is_named() -> None:
    with pytest.raises(ArgumentError, match="live-in &x: no such input"):
        loop(MEMORY)


def straight(text: str, **fields: object) -> Region:
    dfg = parse(text)
    return Region(dfg.name, "straight", dfg, **fields)  # type: ignore[arg-type]


def nested(outer_trips: int) -> Kernel:
    """for i in range(outer): s = 0; for j in range(i): s += j; total += s."""
    enter = straight(
        """dfg "enter"
%0 = const 0x00000000
%1 = mov %0
%2 = live_out "%i" %1
%3 = live_out "%total" %1
""",
        next=1,
    )
    head = straight(
        """dfg "head"
%0 = live_in "%i"
%1 = live_in "n"
%2 = icmp.slt %0, %1
%3 = const 0x00000001
%4 = xor %2, %3 branch
%5 = mov %0 trip
%6 = const 0x00000000
%7 = mov %6
%8 = live_out "%s" %7
""",
        next=2,
        branch=4,
    )
    inner = Region("inner", "loop", parse(SUM.replace("64", "00")), next=3, counted=True)
    tail = straight(
        """dfg "tail"
%0 = live_in "%i"
%1 = const 0x00000001
%2 = add %0, %1
%3 = live_in "%total"
%4 = live_in "%s"
%5 = add %3, %4
%6 = live_out "%i" %2
%7 = live_out "%total" %5
""",
        next=1,
    )
    leave = straight(
        """dfg "leave"
%0 = live_in "%total"
%1 = mov %0
%2 = live_out "%return" %1
"""
    )
    return Kernel("nested", (), (enter, head, inner, tail, leave))


@pytest.mark.parametrize("n", [0, 1, 5])
def test_a_kernel_runs_region_by_region(n: int) -> None:
    result = interpret(nested(n), bytearray(4), {"n": n})
    assert result.value == sum(sum(range(i)) for i in range(n))
    assert result.variables[RETURN_VARIABLE] == result.value
    assert result.runs == (1, n + 1, n, n, 1)
    assert result.iterations == (1, n + 1, sum(range(n)), n, 1)
    operations = (1, 4, 1, 2, 1)
    counts = zip(result.iterations, operations, strict=True)
    assert result.operations == sum(count * size for count, size in counts)


def test_a_straight_region_reads_variables_from_before_it() -> None:
    region = straight(
        """dfg "swap"
%0 = live_in "%a"
%1 = live_in "%b"
%2 = mov %1
%3 = mov %0
%4 = live_out "%a" %2
%5 = live_out "%b" %3
"""
    )
    result = interpret(Kernel("swap", (), (region,)), bytearray(), {"%a": 1, "%b": 2})
    assert result.variables == {"%a": 2, "%b": 1}


def test_regions_that_go_round_for_ever_meet_the_limit() -> None:
    region = straight('dfg "round"\n%0 = iv\n%1 = mov %0\n', next=0)
    with pytest.raises(SimulationError, match="region round: the iteration limit"):
        interpret(Kernel("round", (), (region,)), bytearray(), {}, iteration_limit=50)


def test_a_counted_loop_needs_a_trip_count() -> None:
    region = Region("sum", "loop", parse(SUM), counted=True)
    with pytest.raises(DFGError, match="before any TRIP"):
        interpret(Kernel("k", (), (region,)), bytearray(), {})


def test_a_variable_that_nothing_wrote_is_named() -> None:
    kernel = nested(1)
    kernel = replace(kernel, regions=kernel.regions[1:])
    with pytest.raises(ArgumentError, match="%i: variable is read before it is written"):
        interpret(kernel, bytearray(), {"n": 1})


def test_the_same_graph_object_can_run_again() -> None:
    dfg: DFG = parse(SUM)
    runs = [interpret_region(dfg, "loop", 4, {}, bytearray()) for _ in range(2)]
    assert runs[0] == runs[1]

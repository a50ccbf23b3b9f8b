"""Trip counts of counted loops at the ends of the 32-bit range."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import vividc
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.errors import VividcError
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, Param
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref, Value

MASK = 0xFFFFFFFF
STOP = Input("stop")
LEAST, MOST = -(2**31), 2**31 - 1


def near(number: int) -> st.SearchStrategy[int]:
    return st.integers(max(LEAST, number - 20), min(MOST, number + 20))


def loop(start: Value, step: int, *, exact: bool = True, stop: Value = STOP) -> Function:
    """`for i in range(start, stop, step): count += 1; return count`."""
    header = (
        Phi(0, Type.I32, (("entry", start), ("body", Ref(3)))),
        Phi(1, Type.I32, (("entry", Const(0)), ("body", Ref(4)))),
    )
    test = Instr(2, Opcode.ICMP_SLT, Type.PRED, (Ref(0), stop))
    body = (
        Instr(3, Opcode.ADD, Type.I32, (Ref(0), Const(step)), exact=exact),
        Instr(4, Opcode.ADD, Type.I32, (Ref(1), Const(1))),
    )
    blocks = (
        Block("entry", (), (), Branch("header")),
        Block("header", header, (test,), Branch("body", Ref(2), "end")),
        Block("body", (), body, Branch("header")),
        Block("end", (), (), Branch(value=Ref(1))),
    )
    params = (Param("start", DType.I32), Param("stop", DType.I32))
    return Function("count", params, blocks, DType.I32)


@pytest.mark.parametrize("step", [1, 2, 8])
@pytest.mark.parametrize("start", [0, 1, 5, -3, "start"])
@pytest.mark.parametrize("stop", [-(2**31), -7, 0, 1, 6, 17])
def test_the_controller_counts_what_range_gives(start: int | str, stop: int, step: int) -> None:
    first: Value = Input("start") if isinstance(start, str) else Const(start & MASK)
    kernel = build_kernel(loop(first, step))
    assert [region.counted for region in kernel.regions if region.kind == "loop"] == [True]
    for runtime in (-9, 0, 3) if isinstance(start, str) else (0,):
        inputs = {"start": runtime & MASK, "stop": stop & MASK}
        done = interpret(kernel, np.zeros(1, np.uint32), inputs)
        begin = runtime if isinstance(start, str) else start
        assert done.value == len(range(begin, stop, step))


@settings(max_examples=300)
@given(st.data(), st.sampled_from([1, 2, 4, 1 << 8, 1 << 24, 1 << 29, 1 << 30]))
def test_ranges_may_be_wider_than_a_word_is_signed(data: st.DataObject, step: int) -> None:
    """What a constant or an argument says, about the ends of the words and between them."""
    start = data.draw(st.sampled_from([LEAST, -1, 0, MOST]).flatmap(near))
    steps = data.draw(st.integers(-2, 40))
    stop = start + steps * step + data.draw(st.integers(0, step - 1))
    stop = min(max(stop, LEAST), MOST)
    numbers = range(start, stop, step)
    assume(not numbers or numbers[-1] + step <= MOST)
    is_known, ends = data.draw(st.booleans()), data.draw(st.booleans())
    first = Const(start & MASK) if is_known else Input("start")
    last = Const(stop & MASK) if ends else Input("stop")
    inputs = {"start": start & MASK, "stop": stop & MASK}
    done = interpret(build_kernel(loop(first, step, stop=last)), np.zeros(1, np.uint32), inputs)
    assert done.value == len(numbers)


def test_the_longest_range_does_not_count_as_none() -> None:
    """2**31 steps, which no interpreter ends."""
    kernel = build_kernel(loop(Input("start"), 2))
    inputs = {"start": LEAST & MASK, "stop": MOST & MASK}
    with pytest.raises(VividcError, match="the iteration limit is reached"):
        interpret(kernel, np.zeros(1, np.uint32), inputs, iteration_limit=99)


@vividc.kernel("void(int32[::1])")
def of_three(x):
    for _ in range(-(2**31), 2**30, 2**30):
        x[0] += 1


def test_a_wide_range_of_constants_in_a_kernel() -> None:
    x = np.zeros(1, np.int32)
    vividc.simulate(vividc.compile(of_three), x)
    assert x[0] == 3


@pytest.mark.parametrize(("step", "counted"), [(1, True), (2, False)])
def test_a_counter_that_may_wrap_past_its_limit_is_not_counted(step: int, counted: bool) -> None:
    kernel = build_kernel(loop(Input("start"), step, exact=False))
    assert [region.counted for region in kernel.regions if region.kind == "loop"] == [counted]

"""Trip counts of counted loops at the ends of the 32-bit range."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, Param
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref, Value

MASK = 0xFFFFFFFF


def loop(start: Value, step: int, *, exact: bool = True) -> Function:
    """`for i in range(start, stop, step): count += 1; return count`."""
    header = (
        Phi(0, Type.I32, (("entry", start), ("body", Ref(3)))),
        Phi(1, Type.I32, (("entry", Const(0)), ("body", Ref(4)))),
    )
    test = Instr(2, Opcode.ICMP_SLT, Type.PRED, (Ref(0), Input("stop")))
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


@pytest.mark.parametrize(("step", "counted"), [(1, True), (2, False)])
def test_a_counter_that_may_wrap_past_its_limit_is_not_counted(step: int, counted: bool) -> None:
    kernel = build_kernel(loop(Input("start"), step, exact=False))
    assert [region.counted for region in kernel.regions if region.kind == "loop"] == [counted]

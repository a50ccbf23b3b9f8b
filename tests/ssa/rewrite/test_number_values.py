"""Recurrences that begin alike and go on alike are computed once."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.programs import lower, programs
from tests.ssa.support import demand_same
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType
from vividc.ssa.check import check_function
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.rewrite.number_values import merge_recurrences

FIRST, LAST = 5, 12
STEPS = st.tuples(
    st.integers(0, 1), st.sampled_from([Opcode.ADD, Opcode.XOR, Opcode.MUL]), st.integers(0, 3)
)
"""A recurrence's start, and what each iteration does with the word of which recurrence."""


@settings(max_examples=100)
@given(programs())
def test_merging_keeps_a_program(program: tuple[object, ...]) -> None:
    function = normalize(lower(program))
    merged = merge_recurrences(function)
    assert check_function(merged) == []
    demand_same(function, merged, tries=2)
    assert merge_recurrences(merged) is merged


@settings(max_examples=200)
@given(st.lists(STEPS, min_size=2, max_size=5), st.data())
def test_recurrences_that_feed_each_other(
    steps: list[tuple[int, Opcode, int]], data: st.DataObject
) -> None:
    """Few starts and few steps, so that some are equal, some only nearly."""
    reads = [data.draw(st.integers(0, len(steps) - 1)) for _ in steps]
    function = loop_of(steps, reads)
    merged = merge_recurrences(function)
    assert check_function(merged) == []
    demand_same(function, merged, tries=1)
    assert merge_recurrences(merged) is merged
    left = len(merged.blocks[1].phis) - 1
    assert left == len(apart(steps, reads))


def loop_of(steps: list[tuple[int, Opcode, int]], reads: list[int]) -> Function:
    """Some iterations of recurrences, and a word that all of them decide."""
    count = len(steps)
    counter, phis, instrs = 2 * count, [], []
    for at, ((start, op, word), read) in enumerate(zip(steps, reads, strict=True)):
        inside = ("b1", Ref(count + at))
        phis.append(Phi(at, Type.I32, (("b0", Const(start)), inside)))
        instrs.append(Instr(count + at, op, Type.I32, (Ref(read), Const(word))))
    phis.append(Phi(counter, Type.I32, (("b0", Const(FIRST)), ("b1", Ref(counter + 1)))))
    instrs.append(Instr(counter + 1, Opcode.ADD, Type.I32, (Ref(counter), Const(1))))
    free = counter + 2
    total: Ref | Const = Const(0)
    for at in range(count):
        instrs.append(Instr(free, Opcode.MUL, Type.I32, (total, Const(31))))
        instrs.append(Instr(free + 1, Opcode.ADD, Type.I32, (Ref(free), Ref(count + at))))
        total = Ref(free + 1)
        free += 2
    instrs.append(Instr(free, Opcode.ICMP_SLT, Type.PRED, (Ref(counter + 1), Const(LAST))))
    blocks = (
        Block("b0", (), (), Branch("b1")),
        Block("b1", tuple(phis), tuple(instrs), Branch("b1", Ref(free), "b2")),
        Block("b2", (), (), Branch(None, value=total)),
    )
    return Function("f", (), blocks, DType.I32)


def apart(steps: list[tuple[int, Opcode, int]], reads: list[int]) -> set[int]:
    """Classes of recurrences that nothing tells apart: those split until no step splits any."""
    classes = [start for start, _, _ in steps]
    while True:
        keys = [
            (classes[at], op, word, classes[read])
            for at, ((_, op, word), read) in enumerate(zip(steps, reads, strict=True))
        ]
        split = [keys.index(key) for key in keys]
        if len(set(split)) == len(set(classes)):
            return set(split)
        classes = split

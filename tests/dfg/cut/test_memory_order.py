"""Order edges between accesses of any width: every meeting is kept in order, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from random import Random

import pytest

from vividc.dfg.builder import GraphBuilder
from vividc.dfg.cut.memory_order import Access, order_accesses
from vividc.dfg.ir import Edge, EdgeKind
from vividc.machine.lanes import Lane
from vividc.machine.words import WORD_MASK
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Instr
from vividc.ssa.polyhedral.distances.linear import Place
from vividc.ssa.polyhedral.distances.meetings import Meetings
from vividc.ssa.text_parser import parse

ITERATIONS = 24
LOOP = """function "f" file "f.py"
param "x" uint8[1]
param "n" int32
b0:
  jump h
h:
  %0 i32 = phi [b0: 0x00000000, b2: %1]
  %2 pred = icmp.slt %0, $"n"
  branch %2 b2 else b3
b2:
  %1 i32 = add %0, 0x00000001 exact
{body}  jump h
b3:
  return
"""
Shape = tuple[bool, int, int, int]
"""Of an access: whether it is a store, its offset, its width, by how much it moves."""


def loop_of(body: str, arrays: str = "x") -> tuple[Meetings, list[Instr]]:
    """A loop with `body`, and its accesses."""
    params = "".join(f'param "{array}" uint8[1]\n' for array in arrays)
    function = parse(LOOP.replace('param "x" uint8[1]\n', params).format(body=body))
    accesses = [instr for instr in function.by_name["b2"].instrs if instr.array]
    return Meetings(function, find_loops(function)[0]), accesses


def drawn(meetings: Meetings, accesses: list[Instr]) -> list[Edge]:
    """The edges between accesses, whose nodes are numbered in order."""
    builder = GraphBuilder("loop")
    nodes = [builder.add(instr.opcode, []) for instr in accesses]
    places = (Place(instr, "b2") for instr in accesses)
    order_accesses(builder, [Access(*pair) for pair in zip(nodes, places, strict=True)], meetings)
    return [edge for edge in builder.build().edges if edge.kind is EdgeKind.ORDER]


def written(number: int, shape: Shape) -> str:
    """An access, its index computed by a product."""
    is_store, offset, width, stride = shape
    index, ident = number * 2 + 10, number * 2 + 11
    text = f"  %{index} i32 = mul %0, 0x{stride & WORD_MASK:08x}\n"
    about = f'array "x" offset {offset} width {width}'
    if is_store:
        return f'{text}  %{ident} none = store $"&x", %{index}, 0x00000000 {about}\n'
    return f'{text}  %{ident} i32 = load $"&x", %{index} {about}\n'


def meetings(first: Shape, second: Shape) -> set[int]:
    """By how many iterations the second is later when they touch one byte (negative: earlier)."""
    gap = second[1] - first[1]
    return {
        k for k in range(-ITERATIONS, ITERATIONS + 1) if -second[2] < gap + k * first[3] < first[2]
    }


@pytest.mark.parametrize("seed", range(200))
def test_byte_dependences_against_enumeration(seed: int) -> None:
    random = Random(seed)
    stride = random.choice((0, 1, 2, 3, 4, 5, 8, -1, -3, -4))
    shapes = [
        (random.random() < 0.6, random.randint(-9, 9), random.choice((1, 2, 4)), stride)
        for _ in range(4)
    ]
    edges = drawn(*loop_of("".join(written(*each) for each in enumerate(shapes))))
    kept = {(edge.src, edge.dst): edge.distance for edge in edges}
    for (i, first), (j, second) in product(enumerate(shapes), repeat=2):
        earliest = 0 if i < j else 1
        needed = min((k for k in meetings(first, second) if k >= earliest), default=None)
        if not (first[0] or second[0]):
            needed = None
        assert kept.get((i, j)) == needed


def test_an_address_that_is_not_affine_may_be_any_byte() -> None:
    edges = drawn(
        *loop_of("""  %3 i32 = load $"&y", %0 array "y"
  %4 none = store $"&x", %3, 0x00000000 array "x" width 1
  %5 i32 = load $"&x", %0 array "x" offset 7 width 1
""")
    )
    assert {(e.src, e.dst, e.distance) for e in edges} == {(1, 1, 1), (1, 2, 0), (2, 1, 1)}
    assert all(edge.assumed for edge in edges)


def test_bytes_of_one_word_are_independent() -> None:
    shapes = [(True, offset, 1, 4) for offset in range(4)]
    assert not drawn(*loop_of("".join(written(*each) for each in enumerate(shapes))))


@pytest.mark.parametrize(("loop", "kept"), [("h", False), ("elsewhere", True)])
def test_accesses_of_different_threads_have_no_order_in_their_loops(loop: str, kept: bool) -> None:
    meetings, accesses = loop_of(
        """  %3 i32 = load $"&y", %0 array "y"
  %4 none = store $"&x", %3, 0x00000000 array "x"
  %5 none = store $"&x", %3, 0x00000000 array "x"
"""
    )
    ours = [
        replace(access, lane=Lane(thread, 7, 0, ("groups", loop)))
        for thread, access in enumerate(accesses[1:])
    ]
    between = [edge for edge in drawn(meetings, ours) if edge.src != edge.dst]
    assert bool(between) == kept


def test_an_edge_tells_whether_its_distance_is_proved() -> None:
    stepping = drawn(*loop_of(written(0, (False, 0, 4, 4)) + written(1, (True, 4, 4, 4))))
    assert stepping
    assert not any(edge.assumed for edge in stepping)
    same_place = drawn(*loop_of(written(0, (False, 0, 4, 0)) + written(1, (True, 0, 4, 0))))
    assert any(edge.distance for edge in same_place)
    assert not any(edge.assumed for edge in same_place)


@pytest.mark.parametrize(
    ("first", "second", "kept"),
    [
        ("%4", "%5", False),  # x[2 * i] below 8, x[i] from 8 on
        ("%4", "%4", True),
        ("%4", "%6", True),
        ("%4", "%8", False),
        ("%4", None, True),
    ],
)
def test_accesses_whose_predicates_keep_them_apart_have_no_order(
    first: str, second: str | None, kept: bool
) -> None:
    meetings, accesses = loop_of(
        f"""  %3 i32 = shl %0, 0x00000001
  %4 pred = icmp.slt %3, 0x00000008
  %5 pred = icmp.slt 0x00000007, %0
  %6 pred = icmp.slt 0x00000005, %0
  %7 pred = icmp.slt %0, 0x00000008
  %8 pred = xor %7, 0x00000001
  %9 none = store $"&x", %3, 0x00000000, {first} array "x" width 1
  %10 i32 = load $"&x", %0{"" if second is None else f", {second}"} array "x" width 1
"""
    )
    assert bool([edge for edge in drawn(meetings, accesses) if edge.src != edge.dst]) == kept


def test_accesses_of_many_are_ordered_as_each_two_of_them_alone():
    """Arrays and loads between them change nothing, nor does the order of what is told."""
    random, body = Random(5), ""
    for number in range(14):
        shape = random.random() < 0.4, random.randrange(6), 4, random.choice((0, 4, 8))
        array = random.choice("xyz")
        body += written(number, shape).replace('"x"', f'"{array}"').replace("&x", f"&{array}")
    meetings, accesses = loop_of(body, arrays="xyz")
    alone = []
    for first, one in enumerate(accesses):
        for second, other in enumerate(accesses[first:], first):
            if other.array == one.array:
                edges = drawn(meetings, [one] if one is other else [one, other])
                told = [e for e in edges if one is other or e.src != e.dst]
                numbers = first, second
                alone += [(numbers[e.src], numbers[e.dst], e.distance) for e in told]
    assert [(e.src, e.dst, e.distance) for e in drawn(meetings, accesses)] == alone
    assert len(alone) > len(accesses)

"""Bytes and halves on the reference engine: extension, byte stores, alignment, banks."""

from __future__ import annotations

import numpy as np
import pytest

from tests.program.hand_kernels import Hand, N, O, fabric, program, trip_region
from vividc import simulate
from vividc.dfg.ir import Node
from vividc.dfg.regions import Region
from vividc.errors import SimulationError
from vividc.machine.opcodes import BASE
from vividc.program import DType, Param, Program, disassemble


def narrow_op(hand: Hand, node: Node, pe: int, time: int, index: int) -> int:
    """A load or store with the attributes of `node`."""
    made = hand.op(
        node.op,
        pe,
        time,
        name=node.name,
        shift=node.shift,
        offset=node.offset,
        width=node.width,
        signed=node.signed,
    )
    hand.feed(index, made, 0)
    hand.feed(hand.live_in(f"&{node.name}"), made, BASE)
    return made


def widen(dtype: DType, offset: int = 0) -> Program:
    """y[i] = x[i], from a narrow type to int32, for i < n."""
    hand = Hand(fabric(), 1)
    iv = hand.iv()
    width = dtype.size_bytes
    load = Node(
        0,
        O.LOAD,
        name="x",
        shift=width.bit_length() - 1,
        offset=offset,
        width=width,
        signed=dtype.is_signed,
    )
    x = narrow_op(hand, load, 0, 0, iv)
    store = narrow_op(hand, Node(0, O.STORE, name="y", shift=2), 3, 2, iv)
    hand.feed(x, store, 1, via="2 3")
    loop = Region("loop", "loop", hand.dfg("loop"), counted=True)
    params = (Param("x", dtype, 1), Param("y", DType.I32, 1), N)
    return program("widen", params, [trip_region(fabric()), (loop, hand)])


NARROW = [DType.U8, DType.I8, DType.BOOL, DType.U16, DType.I16]


@pytest.mark.parametrize("dtype", NARROW)
def test_loads_extend(dtype: DType) -> None:
    x = np.random.default_rng(1).integers(0, 2, 9 * dtype.size_bytes, dtype=np.uint8)
    x = (x if dtype is DType.BOOL else x * np.uint8(255)).view(dtype.value)
    y = np.zeros(9, np.int32)
    simulate(widen(dtype), x, y, 9)
    np.testing.assert_array_equal(y, x.astype(np.int32))


def test_a_half_at_an_odd_byte_is_misaligned() -> None:
    with pytest.raises(SimulationError, match="misaligned access at byte 1 of the array x"):
        simulate(widen(DType.U16, offset=1), np.ones(8, np.uint16), np.zeros(8, np.int32), 4)


def test_a_narrow_array_ends_at_its_last_byte() -> None:
    compiled = widen(DType.U8)
    y = np.zeros(8, np.int32)
    with pytest.raises(SimulationError, match="out-of-bounds access at byte 5 of the array x"):
        simulate(compiled, np.ones(5, np.uint8), y, 6)


def two_stores(first: Node, second: Node) -> Program:
    """Two stores in one cycle, by PE 0 and by PE 3, of the words 0x11111111 and 0x22222222."""
    hand = Hand(fabric(), 4)
    for node, pe, word in ((first, 0, 0x11111111), (second, 3, 0x22222222)):
        value = hand.op(O.MOV, pe, 0)
        hand.feed(hand.const(word), value)
        store = narrow_op(hand, node, pe, 1, hand.const(0))
        hand.feed(value, store, 1)
    region = Region("both", "straight", hand.dfg("both"))
    return program("both", (Param("x", DType.U32, 1),), [(region, hand)])


@pytest.mark.parametrize(
    ("first", "second", "word"),
    [
        ((1, 0), (1, 1), 0xFFFF2211),
        ((2, 2), (1, 0), 0x1111FF22),
        ((4, 0), (1, 2), 0x11221111),
        ((1, 3), (2, 2), 0x2222FFFF),
        ((4, 0), (4, 0), 0x22222222),
        ((1, 2), (4, 0), 0x22222222),
    ],
)
def test_stores_of_one_cycle_merge_by_byte(
    first: tuple[int, int], second: tuple[int, int], word: int
) -> None:
    """(width, offset); the higher PE wins the bytes that both write."""
    nodes = [Node(0, O.STORE, name="x", width=w, offset=o) for w, o in (first, second)]
    x = np.array([0xFFFFFFFF, 7], np.uint32)
    compiled = two_stores(*nodes)
    result = simulate(compiled, x)
    assert x.tolist() == [word, 7]
    assert result.stats["stalls"]["bank_conflict"] == 1


def test_disassembly_tells_width_and_extension() -> None:
    assert "load.s2 [" in disassemble(widen(DType.I16))
    assert "load.u1 [" in disassemble(widen(DType.BOOL))
    store = Node(0, O.STORE, name="x", width=1)
    assert "store.1 [" in disassemble(two_stores(store, store))

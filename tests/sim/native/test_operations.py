"""Every operation, natively, against its row of `machine.semantics`."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

from vividc.machine.lane_semantics import LANE_SEMANTICS
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.machine.semantics import SEMANTICS
from vividc.program.words.layout import OPCODE_NUMBERS
from vividc.sim.native.compiler import loaded, object_code
from vividc.sim.native.write.operations import DECLARATIONS, LOWERED, lower
from vividc.sim.native.write.text import Code

PORTS = 3
OPS = sorted(LOWERED, key=lambda op: op.value)

EDGES = (
    *(0, 1, 2, 31, 32, 33, 0x7FFFFFFF, 0x80000000, 0x80000001, 0xFFFFFFFE, 0xFFFFFFFF),
    *(0x00800000, 0x007FFFFF, 0x80800000, 0x807FFFFF),  # least normal, greatest subnormal
    *(0x3F800000, 0xBF800000, 0x3F800001, 0x3F7FFFFF, 0x3F000000, 0xBF000000),
    *(0x7F7FFFFF, 0xFF7FFFFF, 0x7F800000, 0xFF800000),
    *(0x7FC00000, 0xFFC00000, 0x7F800001, 0xFFBFFFFF, 0x7FC12345),  # NaNs, signalling ones too
    *(0x4EFFFFFF, 0x4F000000, 0xCF000000, 0xCF000001, 0x4F800000, 0x0DA24260, 0x4B800001),
)
"""Words at which integers or floats turn."""


def module(ops: list[Opcode]) -> str:
    """`run(results, counts, operands)` computes all operations on as many triples as counts[0]."""
    code = Code()
    code.start("entry")
    count = code.load("i32", "%counts")
    code.do("br label %loop")
    code.start("loop")
    code.lines.append("  %k = phi i32 [ 0, %entry ], [ %after, %loop ]")
    base = code.extended("%k")
    operands = []
    for port in range(PORTS):
        index = code.value(f"add i64 {code.value(f'mul i64 {base}, {PORTS}')}, {port}")
        place = code.value(f"getelementptr i32, ptr %operands, i64 {index}")
        operands.append(code.load("i32", place))
    for number, op in enumerate(ops):
        word = lower(code, op, operands[: OPCODES[op].arity])
        index = code.value(f"add i64 {code.value(f'mul i64 {base}, {len(ops)}')}, {number}")
        code.store("i32", word, code.value(f"getelementptr i32, ptr %results, i64 {index}"))
    code.lines.append("  %after = add i32 %k, 1")
    more = code.value(f"icmp ult i32 %after, {count}")
    code.do(f"br i1 {more}, label %loop, label %done")
    code.start("done")
    code.do("ret i32 0")
    head = "define i32 @run(ptr %results, ptr %counts, ptr %operands) {"
    return "\n".join([DECLARATIONS, head, *code.lines, "}", ""])


def compiled(ops: list[Opcode], name: str) -> Callable[[np.ndarray], np.ndarray]:
    """[triples, operations] uint32 of [triples, 3] uint32; `name` is used once in a process."""
    run = loaded(object_code(module(ops)), name)

    def results(operands: np.ndarray) -> np.ndarray:
        words = np.ascontiguousarray(operands, np.uint32)
        found = np.zeros((len(words), len(ops)), np.uint32)
        counts = np.array([len(words)], np.uint32)
        run(found.ctypes.data, counts.ctypes.data, words.ctypes.data)
        return found

    return results


def assert_operations_agree(operands: np.ndarray, name: str) -> None:
    results = compiled(OPS, name)(operands).tolist()
    triples = operands.tolist()
    for number, op in enumerate(OPS):
        function, arity = SEMANTICS[op], OPCODES[op].arity
        # Lanes cost Python ten times as much, and have tests of their own.
        step = max(1, len(triples) // 5_000) if op in LANE_SEMANTICS else 1
        for triple, row in zip(triples[::step], results[::step], strict=True):
            assert row[number] == function(*triple[:arity]), (op, [hex(w) for w in triple])


def random_words(rng: np.random.Generator, count: int) -> np.ndarray:
    """Uniform words, and floats of all exponents and near one another."""
    words = rng.integers(0, 1 << 32, (count, PORTS), np.uint32)
    near = rng.random((count, PORTS)) < 0.4
    exponents = rng.integers(118, 138, (count, PORTS)).astype(np.uint32) << np.uint32(23)
    words[near] = ((words & np.uint32(0x807FFFFF)) | exponents)[near]
    few = rng.random((count, PORTS)) < 0.2
    words[few] &= np.uint32(0xFFF80000)
    return words


def test_every_operation_of_an_fu_has_a_lowering() -> None:
    executed = {op for op in OPCODE_NUMBERS if op is not None}
    assert executed - MEMORY == LOWERED


def test_edges() -> None:
    pairs = [(a, b, c) for a, b in product(EDGES, EDGES) for c in EDGES[:: len(EDGES) // 4]]
    assert_operations_agree(np.array(pairs, np.uint32), "edges")


def test_random_words() -> None:
    assert_operations_agree(random_words(np.random.default_rng(1), 3_000), "random words")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_many_random_words(seed: int) -> None:
    rng = np.random.default_rng([2, seed])
    assert_operations_agree(random_words(rng, 100_000), f"many random words {seed}")


@pytest.mark.slow
def test_all_triples_of_edges() -> None:
    triples = np.array(list(product(EDGES, repeat=3)), np.uint32)
    assert_operations_agree(triples, "triples of edges")


def test_fma_whose_sum_is_halfway_rounds_once() -> None:
    """The product's last bit decides: rounding the product first would go the other way."""
    a, b = 0x3F800001, 0x3F800001  # (1 + 2**-23)**2 = 1 + 2**-22 + 2**-46
    triples = [(a, b, word) for word in (0x33800000, 0xB3800000, 0x80000000, 0xBF800002)]
    assert_operations_agree(np.array(triples, np.uint32), "halfway")


def test_a_product_and_a_sum_are_not_fused() -> None:
    """Two roundings, also where LLVM sees both operations."""
    code = Code()
    code.start("entry")
    words = [code.load("i32", "%operands", port) for port in range(PORTS)]
    product = lower(code, Opcode.FMUL, words[:2])
    code.store("i32", lower(code, Opcode.FADD, (product, words[2])), "%results")
    code.do("ret i32 0")
    head = "define i32 @run(ptr %results, ptr %counts, ptr %operands) {"
    run = loaded(
        object_code("\n".join([DECLARATIONS, head, *code.lines, "}", ""])), "two roundings"
    )
    result = np.zeros(1, np.uint32)
    for triple in random_words(np.random.default_rng(3), 500):
        run(result.ctypes.data, 0, triple.ctypes.data)
        a, b, c = triple.tolist()
        product_word = SEMANTICS[Opcode.FMUL](a, b)
        assert int(result[0]) == SEMANTICS[Opcode.FADD](product_word, c)

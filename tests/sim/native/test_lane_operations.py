"""Operations on lanes, natively: every pair of FP8 codes, ties, and special values of FP16."""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import pairwise, product

import numpy as np
import pytest

from tests.sim.native.test_operations import compiled
from vividc.formats import E4M3, E5M2, F16, FORMATS, Format, round_array, to_floats, values
from vividc.machine.lane_semantics import LANE_SEMANTICS
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.machine.words import word_of

ALL = pytest.mark.parametrize("fmt", FORMATS.values(), ids=FORMATS)
FP8 = pytest.mark.parametrize("fmt", [E4M3, E5M2], ids=["e4m3", "e5m2"])
PORTS = 3


def assert_agree(ops: list[Opcode], operands: np.ndarray, name: str) -> None:
    """All of `ops` on [count, 3] words."""
    results = compiled(ops, name)(operands)
    triples = operands.tolist()
    for number, op in enumerate(ops):
        column = results[:, number].tolist()
        function, arity = LANE_SEMANTICS[op], OPCODES[op].arity
        for triple, got in zip(triples, column, strict=True):
            assert got == function(*triple[:arity]), (op, [hex(word) for word in triple])


def on_lanes(fmt: Format, arity: int) -> list[Opcode]:
    """Operations that take only numbers of a format."""
    type_ = Type(fmt.name)
    return [op for op in LANE_SEMANTICS if OPCODES[op].operands == (type_,) * arity]


def joined(fmt: Format, codes: np.ndarray) -> np.ndarray:
    """Words of [count * lanes] codes."""
    return codes.astype(fmt.dtype).view(np.uint32)


@FP8
def test_every_pair_of_fp8_codes(fmt: Format) -> None:
    a, b = np.divmod(np.arange(1 << 16), 256)
    words = np.stack([joined(fmt, codes) for codes in (a, b, b)], axis=1)
    assert_agree(on_lanes(fmt, 2), words, f"pairs of {fmt.name}")


@ALL
def test_conversions_of_every_code(fmt: Format) -> None:
    codes = np.arange(1 << fmt.bits, dtype=np.uint32)
    words = np.stack([codes, codes % 5, codes], axis=1)
    assert_agree([Opcode(f"fpext.{fmt.name}")], words, f"fpext of {fmt.name}")


@ALL
def test_truncation_at_ties(fmt: Format) -> None:
    """The middle of every two neighbours, and the binary32 numbers beside it, of both signs."""
    numbers = values(fmt)[: fmt.max_code + 1]
    middles = [(low + high) / 2 for low, high in pairwise(numbers)]
    step = max(1, len(middles) // 4000)
    words = [word_of(x) + by for x in middles[::step] for by in (-1, 0, 1)]
    last = word_of(fmt.max_finite + (numbers[-1] - numbers[-2]) / 2)
    words += [last - 1, last, last + 1, 0x7F7FFFFF, 0x7F800000, 0x7F800001, 0x7FC00000, 0, 1]
    words += [word | 1 << 31 for word in words]
    column = np.array(words, np.uint32)
    operands = np.stack([column, column[::-1], column], axis=1)
    packed = f"{fmt.name}x{fmt.lanes}"
    ops = [Opcode(f"fptrunc.{fmt.name}"), Opcode(f"pack.{packed}")]
    ops += [Opcode(f"pack_high.{packed}")] if fmt.lanes > 2 else []
    assert_agree(ops, operands, f"ties of {fmt.name}")


def sums_at_ties(fmt: Format, count: int) -> np.ndarray:
    """Lanes of products with few bits, and addends near them, tiny, or any."""
    rng = random.Random(1)
    rows = []
    for _ in range(count):
        a, b, c = (rng.randrange(1 << fmt.bits) for _ in range(PORTS))
        if fmt is F16 and rng.random() < 0.5:
            a, b = a & ~0x1F, b & ~0x1F
        tiny = rng.randint(0, 3) | rng.choice((0, fmt.sign))
        rows.append((a, b, rng.choice((c, tiny, tiny, (a + b) & fmt.mask))))
    columns = np.array(rows).T
    return np.stack([joined(fmt, np.ascontiguousarray(column)) for column in columns], axis=1)


@ALL
def test_fused_sums(fmt: Format) -> None:
    assert_agree(on_lanes(fmt, 3), sums_at_ties(fmt, 12_000), f"sums of {fmt.name}")


SPECIAL_F16 = (
    *(0, 1, 0x3FF, 0x400, 0x3BFF, 0x3C00, 0x3C01, 0x7BFF, 0x7C00, 0x7C01, 0x7DFF, 0x7E00, 0x7FFF),
    *(0x8000, 0x8001, 0x83FF, 0x8400, 0xBC00, 0xFBFF, 0xFC00, 0xFC01, 0xFE00, 0xFFFF),
)


def test_special_values_of_f16() -> None:
    codes = np.array(list(product(SPECIAL_F16, repeat=3)) * 2, np.uint32)[: 2 * 23**3 // 2 * 2]
    lanes = codes.reshape(-1, 2, PORTS)
    words = lanes[:, 0] | lanes[:, 1] << np.uint32(16)
    assert_agree([*on_lanes(F16, 2), *on_lanes(F16, 3)], words, "special f16")


@ALL
def test_dot_products(fmt: Format) -> None:
    rng = np.random.default_rng(2)
    operands = rng.integers(0, 1 << 32, (6000, PORTS), np.uint32)
    near_one = rng.integers(0x3E000000, 0x41000000, 6000).astype(np.uint32)
    operands[::2, 2] = near_one[::2]
    top = np.uint32(sum(1 << at for at in range(fmt.bits - 2, 32, fmt.bits)))
    operands[::3, :2] &= ~top  # numbers below 2: fewer NaNs
    assert_agree([Opcode(f"dot.{fmt.name}x{fmt.lanes}")], operands, f"dot of {fmt.name}")


FUSED: dict[str, Callable[..., np.ndarray]] = {
    "fma": lambda a, b, c: a * b + c,
    "fms": lambda a, b, c: a * b - c,
    "fnma": lambda a, b, c: c - a * b,
}


@FP8
@pytest.mark.parametrize("name", FUSED)
def test_every_triple_of_fp8_codes(fmt: Format, name: str) -> None:
    """Sums of three numbers are exact in binary64 where they are not too large (16,777,216)."""
    run = compiled([Opcode(f"{name}.{fmt.name}x{fmt.lanes}")], f"triples of {name} {fmt.name}")
    b, c = np.divmod(np.arange(1 << 16), 256)
    value = to_floats(fmt, np.arange(256)).astype(np.float64)
    for a in range(256):
        words = [joined(fmt, codes) for codes in (np.full(1 << 16, a), b, c)]
        with np.errstate(invalid="ignore"):
            wanted = round_array(fmt, FUSED[name](value[a], value[b], value[c]))
        got = run(np.stack(words, axis=1))[:, 0].view(fmt.dtype)
        np.testing.assert_array_equal(got, wanted)


@pytest.mark.parametrize("name", ["fadd", "fsub", "fmul"])
def test_f16_arithmetic_is_numpys(name: str) -> None:
    run = compiled([Opcode(f"{name}.f16x2")], f"numpy's {name}")
    function = {"fadd": np.add, "fsub": np.subtract, "fmul": np.multiply}[name]
    rng = np.random.default_rng(3)
    for _ in range(20):
        words = rng.integers(0, 1 << 32, (200_000, PORTS), np.uint32)
        a, b = (np.ascontiguousarray(words[:, port]).view(np.float16) for port in (0, 1))
        with np.errstate(all="ignore"):
            result = function(a, b)
        wanted = np.where(np.isnan(result), np.uint16(F16.nan), result.view(np.uint16))
        np.testing.assert_array_equal(run(words)[:, 0].view(np.uint16), wanted)


@ALL
def test_truncation_of_words_of_every_exponent(fmt: Format) -> None:
    run = compiled([Opcode(f"fptrunc.{fmt.name}")], f"truncation to {fmt.name}")
    for first in range(0, 1 << 32, 1 << 24):
        words = np.arange(first, first + (1 << 24), 401, dtype=np.uint32)
        numbers = words.view(np.float32)
        got = run(np.stack([words] * PORTS, axis=1))[:, 0]
        np.testing.assert_array_equal(got, round_array(fmt, numbers))

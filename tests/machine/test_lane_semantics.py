"""Operations on lanes: FP8 on every pair of codes, FP16 on hard cases, against exact numbers."""

from __future__ import annotations

import math
import operator
import random
from collections.abc import Callable, Iterator
from fractions import Fraction

import numpy as np
import pytest

from tests.rounding import nearest
from vividc.dfg.check import check
from vividc.dfg.ir import DFG, Edge, Node
from vividc.formats import E4M3, E5M2, F16, FORMATS, Format, join, round_bits, split, to_float
from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode, Type
from vividc.machine.semantics import evaluate, evaluate_predicated
from vividc.machine.words import CANONICAL_NAN, float_of, word_of

ALL = pytest.mark.parametrize("fmt", FORMATS.values(), ids=FORMATS)
FP8 = pytest.mark.parametrize("fmt", [E4M3, E5M2], ids=["e4m3", "e5m2"])
ARITHMETIC = {"fadd": operator.add, "fsub": operator.sub, "fmul": operator.mul}


def op(name: str, fmt: Format) -> Opcode:
    """The packed operation of this name."""
    return Opcode(f"{name}.{fmt.name}x{fmt.lanes}")


def every_pair(fmt: Format) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Each code, with all codes a word at a time."""
    for a in range(256):
        for first in range(0, 256, fmt.lanes):
            yield a, tuple(range(first, first + fmt.lanes))


def exact(fmt: Format, function: Callable[..., Fraction], *codes: int) -> int:
    """The nearest code of an exact result of finite numbers; a result of 0 is signed by IEEE."""
    numbers = [to_float(fmt, code) for code in codes]
    result = function(*map(Fraction, numbers))
    if result:
        return nearest(fmt, result)
    return round_bits(fmt, function(*numbers))  # floats know the sign, and a zero is exact


def special(fmt: Format, function: Callable[..., float], *codes: int) -> int:
    """The code of a result of infinities and NaNs."""
    result = function(*(to_float(fmt, code) for code in codes))
    if math.isnan(result):
        return fmt.nan
    assert math.isinf(result)
    assert fmt.infinity is not None
    return fmt.infinity | (fmt.sign if result < 0 else 0)


def expected(fmt: Format, function: Callable[..., float], *codes: int) -> int:
    if all(math.isfinite(to_float(fmt, code)) for code in codes):
        return exact(fmt, function, *codes)
    return special(fmt, function, *codes)


@FP8
@pytest.mark.parametrize("name", ARITHMETIC)
def test_fp8_arithmetic_of_every_pair(fmt: Format, name: str) -> None:
    function, opcode = ARITHMETIC[name], op(name, fmt)
    known: dict[Fraction, int] = {}
    for a, codes in every_pair(fmt):
        word = evaluate(opcode, [join(fmt, [a] * 4), join(fmt, codes)])
        for b, got in zip(codes, split(fmt, word), strict=True):
            x, y = to_float(fmt, a), to_float(fmt, b)
            result = function(x, y)  # exact in binary64
            if result and math.isfinite(result):
                ratio = Fraction(result)
                if ratio not in known:
                    known[ratio] = nearest(fmt, ratio)
                assert got == known[ratio], (a, b)
            else:
                assert got == expected(fmt, function, a, b), (a, b)


@FP8
def test_fp8_extrema_of_every_pair(fmt: Format) -> None:
    for a, codes in every_pair(fmt):
        words = [join(fmt, [a] * 4), join(fmt, codes)]
        least = split(fmt, evaluate(op("fmin", fmt), words))
        greatest = split(fmt, evaluate(op("fmax", fmt), words))
        for b, low, high in zip(codes, least, greatest, strict=True):
            x, y = to_float(fmt, a), to_float(fmt, b)
            numbers = [code for code, value in ((a, x), (b, y)) if not math.isnan(value)]
            # The order of numbers, -0 before +0.
            numbers.sort(key=lambda c: (to_float(fmt, c), math.copysign(1.0, to_float(fmt, c))))
            assert (low, high) == ((numbers[0], numbers[-1]) if numbers else (fmt.nan, fmt.nan))


@FP8
def test_fp8_comparisons_of_every_pair(fmt: Format) -> None:
    for a, codes in every_pair(fmt):
        words = [join(fmt, [a] * 4), join(fmt, codes)]
        got = {
            name: split(fmt, evaluate(op(f"fcmp.{name}", fmt), words))
            for name in ("oeq", "une", "olt", "ole", "ult", "ule")
        }
        for lane, b in enumerate(codes):
            x, y = to_float(fmt, a), to_float(fmt, b)
            unordered = math.isnan(x) or math.isnan(y)
            truth = {
                "oeq": x == y,
                "une": x != y,
                "olt": x < y,
                "ole": x <= y,
                "ult": x < y or unordered,
                "ule": x <= y or unordered,
            }
            assert {name: lanes[lane] for name, lanes in got.items()} == truth


def fma(x: Fraction, y: Fraction, z: Fraction) -> Fraction:
    return x * y + z


FUSED = {"fma": fma, "fms": lambda x, y, z: x * y - z, "fnma": lambda x, y, z: z - x * y}


def hard_triples(fmt: Format, count: int) -> Iterator[tuple[int, int, int]]:
    """Addends next to the product or to its negative, tiny addends beside ties, any codes."""
    rng = random.Random(3)
    for _ in range(count):
        a, b = rng.randrange(1 << fmt.bits), rng.randrange(1 << fmt.bits)
        product = round_bits(fmt, to_float(fmt, a) * to_float(fmt, b))
        near = (product ^ rng.choice((0, fmt.sign))) + rng.randint(-2, 2)
        tiny = rng.choice((0, fmt.sign)) | rng.randint(0, 3)
        yield a, b, rng.choice((near, tiny, rng.randrange(1 << fmt.bits))) & fmt.mask


@ALL
@pytest.mark.parametrize("name", FUSED)
def test_fused_products_round_once(fmt: Format, name: str) -> None:
    triples = list(hard_triples(fmt, 12_000))
    for first in range(0, len(triples), fmt.lanes):
        group = triples[first : first + fmt.lanes]
        words = [join(fmt, column) for column in zip(*group, strict=True)]
        for codes, got in zip(group, split(fmt, evaluate(op(name, fmt), words)), strict=True):
            assert got == expected(fmt, FUSED[name], *codes), [hex(code) for code in codes]


@ALL
def test_fma_of_a_tie_and_a_tiny_addend(fmt: Format) -> None:
    """What a sum rounded to binary32 first would round to the even neighbour."""
    rng = random.Random(4)
    checked = 0
    for _ in range(20_000):
        a, b = rng.randrange(1, fmt.max_code), rng.randrange(1, fmt.max_code)
        if fmt is F16:  # ties are of 12 bits; products of few bits are so more often
            a, b = a & ~0x1F | 0x20, b & ~0x1F | 0x20
        product = Fraction(to_float(fmt, a)) * Fraction(to_float(fmt, b))
        below = nearest(fmt, product - Fraction(1, 1 << 80))
        above = nearest(fmt, product + Fraction(1, 1 << 80))
        if below == above or product > fmt.max_finite:
            continue
        for tiny in (1, fmt.sign | 1):
            got = evaluate(op("fma", fmt), [a, b, tiny]) & fmt.mask
            assert got == nearest(fmt, product + Fraction(to_float(fmt, tiny)))
            checked += 1
    assert checked > 500


def test_fma_of_e5m2_that_binary32_loses() -> None:
    codes = [round_bits(E5M2, x) for x in (48.0, 24.0, 2.0**-16)]  # 1152 is a tie
    assert to_float(E5M2, evaluate(Opcode.FMA_E5M2X4, codes)) == 1280
    assert to_float(E5M2, evaluate(Opcode.FMA_E5M2X4, [*codes[:2], codes[2] | 0x80])) == 1024


@ALL
def test_fma_of_any_exponents(fmt: Format) -> None:
    """Large addends with tiny products, where the binary64 sum is not exact."""
    rng = random.Random(5)
    numbers = range(1, fmt.max_code + 1)
    for _ in range(4000):
        a, b = rng.choice(numbers[: len(numbers) // 3]), rng.choice(numbers[: len(numbers) // 3])
        c = rng.choice(numbers[-len(numbers) // 3 :])
        a ^= rng.choice((0, fmt.sign))
        got = evaluate(op("fma", fmt), [a, b, c]) & fmt.mask
        assert got == expected(fmt, fma, a, b, c)


@pytest.mark.parametrize("name", ARITHMETIC)
def test_f16_arithmetic_is_numpys_and_exact(name: str) -> None:
    rng = np.random.default_rng(6)
    a, b = rng.integers(0, 1 << 16, (2, 8000), np.uint16)
    b[::4] = a[::4] ^ rng.choice(np.array([0, 0x8000, 1, 0x8001], np.uint16), len(a[::4]))
    function = ARITHMETIC[name]
    with np.errstate(all="ignore"):
        result = function(a.view(np.float16), b.view(np.float16))
    codes = np.where(np.isnan(result), 0x7E00, result.view(np.uint16)).tolist()
    pairs = list(zip(a.tolist(), b.tolist(), strict=True))
    for (x, y), code in zip(pairs, codes, strict=True):
        lanes = split(F16, evaluate(op(name, F16), [x | y << 16, y | x << 16]))
        assert lanes[0] == code
        assert lanes[1] == expected(F16, function, y, x)


@ALL
def test_conversions_of_every_code(fmt: Format) -> None:
    for code in range(1 << fmt.bits):
        value = to_float(fmt, code)
        word = CANONICAL_NAN if math.isnan(value) else word_of(value)
        assert evaluate(Opcode(f"fpext.{fmt.name}"), [code]) == word
        back = evaluate(Opcode(f"fptrunc.{fmt.name}"), [word])
        assert back == (fmt.nan if math.isnan(value) else code)


@ALL
def test_truncation_rounds_to_the_nearest(fmt: Format) -> None:
    words = np.random.default_rng(7).integers(0, 1 << 32, 4000, np.uint32)
    words[::2] = words[::2] & np.uint32(0x87FFFFFF) | np.uint32(0x38000000)
    for word in words.tolist():
        value = float_of(word)
        if math.isfinite(value):
            wanted = nearest(fmt, Fraction(value)) if value else word >> 31 << (fmt.bits - 1)
        else:
            wanted = special_code(fmt, value)
        assert evaluate(Opcode(f"fptrunc.{fmt.name}"), [word]) == wanted


def special_code(fmt: Format, value: float) -> int:
    if math.isnan(value):
        return fmt.nan
    largest = fmt.max_code if fmt is E4M3 else fmt.infinity
    assert largest is not None
    return largest | (fmt.sign if value < 0 else 0)


def test_packing_and_unpacking() -> None:
    one, two, minus = word_of(1.0), word_of(2.0), word_of(-1.0)
    assert evaluate(Opcode.PACK_F16X2, [one, minus]) == 0xBC003C00
    low = evaluate(Opcode.PACK_E4M3X4, [one, minus])
    assert low == 0x0000B838
    word = evaluate(Opcode.PACK_HIGH_E4M3X4, [two, word_of(1e9), low | 0xFFFF0000])
    assert word == 0x7E40B838
    assert [evaluate(Opcode.UNPACK_E4M3X4, [word, lane]) for lane in range(5)] == [
        *(one, minus, two, word_of(448.0), one)
    ]
    assert [evaluate(Opcode.EXTRACT_X4, [word, lane]) for lane in range(4)] == [
        *(0x38, 0xB8, 0x40, 0x7E)
    ]
    assert evaluate(Opcode.UNPACK_F16X2, [0xBC003C00, 1]) == minus
    assert evaluate(Opcode.UNPACK_F16X2, [0xFE013C00, 1]) == CANONICAL_NAN
    assert evaluate(Opcode.EXTRACT_X2, [0xBC003C00, 3]) == 0xBC00
    assert evaluate(Opcode.MERGE_X2, [0xFFFF1234, 0xFFFF5678]) == 0x56781234
    assert evaluate(Opcode.MERGE_X4, [0xFFFFFF12, 0xFFFFFF34]) == 0x3412


def test_a_mask_chooses_by_the_lowest_bit_of_each_lane() -> None:
    a, b = 0x11223344, 0x55667788
    assert evaluate(Opcode.SELECT_X4, [0x01000001, a, b]) == 0x11667744
    assert evaluate(Opcode.SELECT_X4, [0x0203FEFD, a, b]) == 0x55227744
    assert evaluate(Opcode.SELECT_X2, [0x00010000, a, b]) == 0x11227788
    assert evaluate(Opcode.SELECT_X2, [0xFFFFFFFE, a, b]) == 0x11227788
    assert evaluate(Opcode.FCMP_OLT_E5M2X4, [0x3C003C00, 0x00003C3C]) == 0x00000001


@ALL
def test_dot_is_a_loop_in_binary32(fmt: Format) -> None:
    rng = np.random.default_rng(8)
    for _ in range(1500):
        a, b = rng.integers(0, 1 << fmt.bits, (2, fmt.lanes)).tolist()
        total = np.array([rng.integers(0, 1 << 32)], np.uint32).view(np.float32)[0]
        start = int(total.view(np.uint32))
        with np.errstate(all="ignore"):
            for x, y in zip(a, b, strict=True):
                product = np.float32(to_float(fmt, x)) * np.float32(to_float(fmt, y))
                total = np.float32(total + product)
        wanted = CANONICAL_NAN if np.isnan(total) else int(total.view(np.uint32))
        got = evaluate(op("dot", fmt), [join(fmt, a), join(fmt, b), start])
        assert got == wanted


@ALL
def test_products_are_exact_in_binary32(fmt: Format) -> None:
    smallest = Fraction(fmt.min_subnormal) ** 2
    assert Fraction(float(np.float32(float(smallest)))) == smallest
    assert 2 * (fmt.mantissa_bits + 1) <= 24
    assert fmt.max_finite**2 < float(np.finfo(np.float32).max)


def test_a_predicated_operation_passes_its_last_operand() -> None:
    assert evaluate_predicated(Opcode.DOT_E4M3X4, 0, (1, 2, 3)) == 3
    assert evaluate_predicated(Opcode.FMA_F16X2, 0, (1, 2, 3)) == 3
    assert evaluate_predicated(Opcode.PACK_HIGH_E5M2X4, 0, (1, 2, 3)) == 3


@ALL
def test_the_three_formats_have_the_same_operations(fmt: Format) -> None:
    packed = f".{fmt.name}x{fmt.lanes}"
    names = {o.value.removesuffix(packed) for o in Opcode if o.value.endswith(packed)}
    wanted = {"fadd", "fsub", "fmul", *FUSED, "fmin", "fmax", "dot", "pack", "unpack"}
    wanted |= {f"fcmp.{name}" for name in ("oeq", "une", "olt", "ole", "ult", "ule")}
    assert names == wanted | ({"pack_high"} if fmt.lanes == 4 else set())
    for name in ("fadd", "fsub", "fmul", *FUSED):
        row, plain = OPCODES[op(name, fmt)], OPCODES[Opcode(name)]
        assert (row.latency_class, row.commutes) == (plain.latency_class, plain.commutes)
        assert row.sliced
        assert not plain.sliced
    assert OPCODES[op("dot", fmt)].latency_class is LatencyClass.DOT


def test_numbers_of_two_formats_do_not_meet() -> None:
    nodes = (
        Node(0, Opcode.LIVE_IN, name="x"),
        Node(1, Opcode.FPTRUNC_F16),
        Node(2, Opcode.FADD_E4M3X4),
        Node(3, Opcode.FADD),
    )
    edges = (Edge(0, 1, 0), Edge(1, 2, 0), Edge(0, 2, 1), Edge(1, 3, 0), Edge(0, 3, 1))
    problems = check(DFG("mixed", nodes, edges))
    assert problems == [
        "edge 1 -> 2 (port 0, distance 0): f16 read as e4m3",
        "edge 1 -> 3 (port 0, distance 0): f16 read as f32",
    ]
    assert OPCODES[Opcode.FCMP_OLT_F16X2].result is Type.I32  # a mask: logic may work on it

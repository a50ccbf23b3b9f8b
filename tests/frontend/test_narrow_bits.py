"""LLVM's bit intrinsics and small-integer instructions in words, on values of every width."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vividc.frontend.llvm.reader import read_function
from vividc.frontend.narrow.narrow import narrow
from vividc.machine.params import DType, Param
from vividc.ssa.interpret import interpret as run

VALUES = (0, 1, 2, 7, 8, 31, 127, 128, 255, 256, 32768, 65535, 2**31 - 1, 2**31, 2**32 - 1)
WIDTHS = (8, 16, 32)
PARAMS = (Param("a", DType.U32), Param("b", DType.U32), Param("c", DType.U32))


def signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) else value


def clamp(value: int, low: int, high: int) -> int:
    return min(max(value, low), high)


def funnel(a: int, b: int, c: int, n: int, left: bool) -> int:
    both, by = a << n | b, c % n
    return (both << by) >> n if left else both >> by


def truncated(a: int, b: int) -> int:
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def of_signed(function: Callable[[int, int, int], int]) -> Callable[..., int]:
    return lambda a, b, c, n: function(signed(a, n), signed(b, n), n)


def limits(n: int) -> tuple[int, int]:
    return -(1 << n - 1), (1 << n - 1) - 1


Reference = Callable[[int, int, int, int], int]
CALLS: dict[str, tuple[str, Reference]] = {
    "ctpop": ("a", lambda a, b, c, n: a.bit_count()),
    "ctlz": ("a, i1 false", lambda a, b, c, n: n - a.bit_length()),
    "cttz": ("a, i1 false", lambda a, b, c, n: (a & -a).bit_length() - 1 if a else n),
    "bitreverse": ("a", lambda a, b, c, n: int(f"{a:0{n}b}"[::-1], 2)),
    "abs": ("a, i1 false", of_signed(lambda a, b, n: abs(a))),
    "smin": ("ab", of_signed(lambda a, b, n: min(a, b))),
    "smax": ("ab", of_signed(lambda a, b, n: max(a, b))),
    "umin": ("ab", lambda a, b, c, n: min(a, b)),
    "umax": ("ab", lambda a, b, c, n: max(a, b)),
    "uadd.sat": ("ab", lambda a, b, c, n: min(a + b, (1 << n) - 1)),
    "usub.sat": ("ab", lambda a, b, c, n: max(a - b, 0)),
    "sadd.sat": ("ab", of_signed(lambda a, b, n: clamp(a + b, *limits(n)))),
    "ssub.sat": ("ab", of_signed(lambda a, b, n: clamp(a - b, *limits(n)))),
    "fshl": ("abc", lambda a, b, c, n: funnel(a, b, c, n, True)),
    "fshr": ("abc", lambda a, b, c, n: funnel(a, b, c, n, False)),
}
INSTRUCTIONS: dict[str, Reference] = {
    "add": lambda a, b, c, n: a + b,
    "sub": lambda a, b, c, n: a - b,
    "mul": lambda a, b, c, n: a * b,
    "udiv": lambda a, b, c, n: a // b,
    "urem": lambda a, b, c, n: a % b,
    "sdiv": of_signed(lambda a, b, n: truncated(a, b)),
    "srem": of_signed(lambda a, b, n: a - b * truncated(a, b)),
    "shl": lambda a, b, c, n: a << b,
    "lshr": lambda a, b, c, n: a >> b,
    "ashr": of_signed(lambda a, b, n: a >> b),
}


def lowered(line: str, result: str, bits: int) -> Callable[[int, int, int], int]:
    """A function of three words of which `line` gets the low bits, as %x, %y and %z."""
    names = zip("abc", "xyz", strict=True)
    if bits < 32:
        body = "".join(f"  %{to} = trunc i32 %{name} to i{bits}\n" for name, to in names)
    else:
        body = "".join(f"  %{to} = add i32 %{name}, 0\n" for name, to in names)
    width = int(result[1:])
    back = "%r" if width == 32 else "%w"
    extend = "" if width == 32 else f"  %w = zext {result} %r to i32\n"
    text = (
        f"define i32 @k(i32 %a, i32 %b, i32 %c) {{\nentry:\n{body}"
        f"  %r = {line}\n{extend}  ret i32 {back}\n}}\n"
    )
    wide = read_function(text, "k", "k.ll")
    function = narrow(replace(wide, params=PARAMS, returns=DType.U32)).function

    def call(a: int, b: int, c: int) -> int:
        value = run(function, a, b, c)
        assert isinstance(value, int)
        return value

    return call


def operands(bits: int) -> list[tuple[int, int]]:
    return list(itertools.product([v for v in VALUES if v < 1 << bits], repeat=2))


@pytest.mark.parametrize("bits", WIDTHS)
@pytest.mark.parametrize("name", CALLS)
def test_intrinsics(name: str, bits: int) -> None:
    arguments, reference = CALLS[name]
    if len(arguments) <= 3:
        listed = ", ".join(f"i{bits} %{'xyz'['abc'.index(name)]}" for name in arguments)
    else:
        listed = f"i{bits} %x, i1 false"
    call = lowered(f"call i{bits} @llvm.{name}.i{bits}({listed})", f"i{bits}", bits)
    amounts = (0, 1, bits - 1, bits, bits + 3) if arguments == "abc" else (0,)
    for (a, b), c in itertools.product(operands(bits), amounts):
        assert call(a, b, c) == reference(a, b, c, bits) % (1 << bits), (a, b, c)


@pytest.mark.parametrize("bits", WIDTHS)
@pytest.mark.parametrize("name", INSTRUCTIONS)
def test_instructions(name: str, bits: int) -> None:
    call = lowered(f"{name} i{bits} %x, %y", f"i{bits}", bits)
    for a, b in operands(bits):
        if (name[1:] in ("div", "rem") and b == 0) or (name[-2:] in ("hl", "hr") and b >= bits):
            continue  # no meaning
        assert call(a, b, 0) == INSTRUCTIONS[name](a, b, 0, bits) % (1 << bits), (a, b)


@pytest.mark.parametrize("bits", [16, 32])
def test_swapped_bytes(bits: int) -> None:
    call = lowered(f"call i{bits} @llvm.bswap.i{bits}(i{bits} %x)", f"i{bits}", bits)
    for a in VALUES:
        low = a % (1 << bits)
        expected = int.from_bytes(low.to_bytes(bits // 8, "little"), "big")
        assert call(a, 0, 0) == expected


@pytest.mark.parametrize("bits", WIDTHS)
@pytest.mark.parametrize("name", ["scmp", "ucmp"])
def test_three_way_comparisons(name: str, bits: int) -> None:
    call = lowered(f"call i8 @llvm.{name}.i8.i{bits}(i{bits} %x, i{bits} %y)", "i8", bits)
    for a, b in operands(bits):
        x, y = (signed(a, bits), signed(b, bits)) if name == "scmp" else (a, b)
        assert call(a, b, 0) == ((x > y) - (x < y)) % 256


@pytest.mark.parametrize("bits", WIDTHS)
@pytest.mark.parametrize("pred", ["slt", "sle", "sgt", "sge", "ult", "uge", "eq"])
def test_comparisons(pred: str, bits: int) -> None:
    call = lowered(f"icmp {pred} i{bits} %x, %y", "i1", bits)
    for a, b in operands(bits):
        x, y = (signed(a, bits), signed(b, bits)) if pred[0] == "s" else (a, b)
        order = {"lt": x < y, "le": x <= y, "gt": x > y, "ge": x >= y, "eq": x == y}
        assert call(a, b, 0) == order[pred[-2:]]


@pytest.mark.parametrize("word", [0, 1, 5, -1, -8, 2**31 - 1, -(2**31)])
def test_bit_counts_of_64_bit_integers_that_words_hold(word: int) -> None:
    for name, expected in {
        "ctpop": (word % 2**64).bit_count(),
        "ctlz": 64 - (word % 2**64).bit_length(),
        "cttz": (word & -word).bit_length() - 1 if word else 64,
    }.items():
        flag = "" if name == "ctpop" else ", i1 false"
        text = (
            "define i32 @k(i32 %a, i32 %b, i32 %c) {\nentry:\n  %x = sext i32 %a to i64\n"
            f"  %r = call i64 @llvm.{name}.i64(i64 %x{flag})\n"
            "  %t = trunc i64 %r to i32\n  ret i32 %t\n}\n"
        )
        wide = read_function(text, "k", "k.ll")
        function = narrow(replace(wide, params=PARAMS, returns=DType.U32)).function
        assert run(function, word, 0, 0) == expected, name


def test_small_integers_become_floats_with_their_sign() -> None:
    call = lowered("sitofp i8 %x to float", "i32", 8)
    for a in range(0, 256, 5):
        assert call(a, 0, 0) == int(np.float32(signed(a, 8)).view(np.uint32))

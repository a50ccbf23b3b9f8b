"""What the operations on lanes compute: two numbers of 16 bits, or four of 8 bits, in a word.

What a format's numbers are and how they round is in `vividc.formats`. Arithmetic works on all
lanes, each rounded once from the exact result: it is computed in binary64, where sums and products
of two numbers of these formats are exact. So are the sums of `fma`, `fms` and `fnma`, but for those
that overflow, and for those of a large addend and a product that is smaller than a quarter of its
last place: there, too, the sum rounds to what the exact one rounds to.

- `fmin` and `fmax` are minimumNumber and maximumNumber of IEEE 754-2019, as on binary32.
- `fcmp` gives 1 in the lowest bit of each lane in which it holds; `select.x2` and `select.x4`
  choose by that bit of each lane. A lane that holds 0 or 1 is so the predicate of one thread, and
  `and`, `or` and `xor` of words combine those of all threads.
- `fptrunc` rounds a binary32 number to lane 0 and makes the others 0; `fpext` and `unpack` give a
  lane as a binary32 number. `pack` rounds two numbers to lanes 0 and 1, `pack_high` two to lanes 2
  and 3 beside the lower lanes of its last operand.
- `merge` joins lanes 0 of two words to lanes 0 and 1; `extract` gives a lane's bits. Lane numbers
  count modulo the number of lanes.
- `dot` adds the products of the lanes to a binary32 number, one after another from lane 0 on, and
  rounds to binary32 after each. The products are exact in binary32, so this is what a loop over
  the lanes computes in binary32, fused or not.

Negation and absolute value are `xor` and `and` with a mask of the lanes' sign bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Final

from vividc.formats import FORMATS, Format, join, round_bits, split, values
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_MASK, float_of, word_of

Semantics = Callable[..., int]

_COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "oeq": lambda x, y: x == y,
    "une": lambda x, y: x != y,
    "olt": lambda x, y: x < y,
    "ole": lambda x, y: x <= y,
    "ult": lambda x, y: not x >= y,
    "ule": lambda x, y: not x > y,
}


def _arithmetic(fmt: Format, function: Callable[..., float]) -> Semantics:
    value = values(fmt)

    def lanes(*words: int) -> int:
        columns = zip(*(split(fmt, word) for word in words), strict=True)
        return join(
            fmt, [round_bits(fmt, function(*(value[code] for code in codes))) for codes in columns]
        )

    return lanes


def _extremum(fmt: Format, largest: bool) -> Semantics:
    value = values(fmt)

    def lane(a: int, b: int) -> int:
        x, y = value[a], value[b]
        if x == y:  # equal numbers share all bits but the sign of zero
            return a & b if largest else a | b
        if math.isnan(y):
            return fmt.nan if math.isnan(x) else a
        if math.isnan(x):
            return b
        return a if (x > y) is largest else b

    return _by_lane(fmt, lane)


def _by_lane(fmt: Format, lane: Callable[[int, int], int]) -> Semantics:
    def lanes(a: int, b: int) -> int:
        return join(fmt, [lane(*codes) for codes in zip(split(fmt, a), split(fmt, b), strict=True)])

    return lanes


def _compared(fmt: Format, holds: Callable[[float, float], bool]) -> Semantics:
    value = values(fmt)
    return _by_lane(fmt, lambda a, b: 1 if holds(value[a], value[b]) else 0)


def _truncated(fmt: Format) -> Semantics:
    return lambda a: round_bits(fmt, float_of(a))


def _extended(fmt: Format) -> Semantics:
    words = _words(fmt)
    return lambda a: words[a & fmt.mask]


def _unpacked(fmt: Format) -> Semantics:
    words = _words(fmt)
    return lambda a, lane: words[a >> fmt.bits * (lane % fmt.lanes) & fmt.mask]


@cache
def _words(fmt: Format) -> tuple[int, ...]:
    return tuple(word_of(value) for value in values(fmt))


def _packed(fmt: Format) -> Semantics:
    return lambda a, b: join(fmt, [round_bits(fmt, float_of(word)) for word in (a, b)])


def _packed_high(fmt: Format) -> Semantics:
    half = fmt.bits * fmt.lanes // 2

    def high(a: int, b: int, low: int) -> int:
        codes = [round_bits(fmt, float_of(word)) for word in (a, b)]
        return join(fmt, codes) << half | low & (1 << half) - 1

    return high


def _dot(fmt: Format) -> Semantics:
    value = values(fmt)

    def dot(a: int, b: int, total: int) -> int:
        for x, y in zip(split(fmt, a), split(fmt, b), strict=True):
            total = word_of(value[x] * value[y] + float_of(total))
        return total

    return dot


def _select(lanes: int) -> Semantics:
    bits = 32 // lanes
    ones = sum(1 << bits * lane for lane in range(lanes))

    def select(mask: int, a: int, b: int) -> int:
        chosen = (mask & ones) * ((1 << bits) - 1)
        return a & chosen | b & ~chosen & WORD_MASK

    return select


def _merge(lanes: int) -> Semantics:
    bits = 32 // lanes
    mask = (1 << bits) - 1
    return lambda a, b: a & mask | (b & mask) << bits


def _extract(lanes: int) -> Semantics:
    bits = 32 // lanes
    return lambda a, lane: a >> bits * (lane % lanes) & (1 << bits) - 1


def _of_format(fmt: Format) -> dict[str, Semantics]:
    """Operations on numbers of a format, by name."""
    packed = f"{fmt.name}x{fmt.lanes}"
    arithmetic: dict[str, Callable[..., float]] = {
        "fadd": lambda x, y: x + y,
        "fsub": lambda x, y: x - y,
        "fmul": lambda x, y: x * y,
        "fma": lambda x, y, z: x * y + z,
        "fms": lambda x, y, z: x * y - z,
        "fnma": lambda x, y, z: z - x * y,
    }
    semantics = {f"{name}.{packed}": _arithmetic(fmt, of) for name, of in arithmetic.items()}
    semantics |= {f"fcmp.{name}.{packed}": _compared(fmt, of) for name, of in _COMPARISONS.items()}
    semantics |= {
        f"fmin.{packed}": _extremum(fmt, largest=False),
        f"fmax.{packed}": _extremum(fmt, largest=True),
        f"fptrunc.{fmt.name}": _truncated(fmt),
        f"fpext.{fmt.name}": _extended(fmt),
        f"pack.{packed}": _packed(fmt),
        f"unpack.{packed}": _unpacked(fmt),
        f"dot.{packed}": _dot(fmt),
    }
    if fmt.lanes > 2:  # noqa: PLR2004 - the lanes that `pack` fills
        semantics[f"pack_high.{packed}"] = _packed_high(fmt)
    return semantics


def _table() -> dict[Opcode, Semantics]:
    semantics = {name: of for fmt in FORMATS.values() for name, of in _of_format(fmt).items()}
    for lanes in (2, 4):
        semantics[f"select.x{lanes}"] = _select(lanes)
        semantics[f"merge.x{lanes}"] = _merge(lanes)
        semantics[f"extract.x{lanes}"] = _extract(lanes)
    return {Opcode(name): of for name, of in semantics.items()}


LANE_SEMANTICS: Final = _table()

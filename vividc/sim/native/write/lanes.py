"""The operations on lanes as LLVM IR: the second writing of `machine.lane_semantics`.

The lanes of a word are the elements of a vector of i32. Codes become binary32 numbers and back by
shifts of exponent and mantissa; the last place of subnormal numbers is that of a sum with a power
of two. Sums and products of two numbers, rounded to binary32 first, round to what they round to at
once: 24 bits are at least 2 * 11 + 2 (Figueroa, "When is double rounding innocuous?", 1995). The
sums of `fma` are not so: those of E4M3 are exact in binary32 where it matters, the others are
computed in binary64 and rounded to binary32 to odd.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from struct import pack, unpack
from typing import Final

from vividc.formats import E4M3, FORMATS, Format
from vividc.machine.opcodes import Opcode
from vividc.machine.words import CANONICAL_NAN, INFINITY, INT_MAX, WORD_BITS
from vividc.sim.native.write.text import Code

LANE_DECLARATIONS: Final = "".join(
    f"declare {kind} @llvm.umin.{short}({kind}, {kind})\n"
    for kind, short in (("i32", "i32"), ("<2 x i32>", "v2i32"), ("<4 x i32>", "v4i32"))
)

Lowering = Callable[[Code, Sequence[str]], str]

_MANTISSA: Final = 23
_BIAS: Final = 127
_CUT: Final = 29  # bits of a binary64 mantissa that binary32 has not


@dataclass(frozen=True, slots=True)
class _Lanes:
    """Instructions on `count` lanes of 32 bits; one lane is a scalar."""

    code: Code
    count: int

    def of(self, kind: str) -> str:
        """Type of as many of `kind`."""
        return kind if self.count == 1 else f"<{self.count} x {kind}>"

    def all(self, value: int | str, kind: str = "i32") -> str:
        """The same constant in each lane."""
        if self.count == 1:
            return str(value)
        return f"<{', '.join([f'{kind} {value}'] * self.count)}>"

    def do(self, name: str, a: str, b: str | int, kind: str = "i32") -> str:
        """A binary instruction; an integer is a constant of all lanes."""
        right = self.all(b) if isinstance(b, int) else b
        return self.code.value(f"{name} {self.of(kind)} {a}, {right}")

    def cast(self, name: str, value: str, source: str, target: str) -> str:
        """A conversion."""
        return self.code.value(f"{name} {self.of(source)} {value} to {self.of(target)}")

    def choose(self, condition: str, a: str, b: str) -> str:
        """Lanes of `a` where the condition holds, else of `b`."""
        kind = self.of("i32")
        return self.code.value(f"select {self.of('i1')} {condition}, {kind} {a}, {kind} {b}")

    def umin(self, a: str, limit: int) -> str:
        """The smaller of `a` and a constant, unsigned."""
        kind = self.of("i32")
        short = "i32" if self.count == 1 else f"v{self.count}i32"
        return self.code.value(
            f"call {kind} @llvm.umin.{short}({kind} {a}, {kind} {self.all(limit)})"
        )

    def split(self, fmt: Format, word: str) -> str:
        """Codes of a word's lanes."""
        if self.count == 1:
            return self.do("and", word, fmt.mask)
        narrow = self.code.value(f"bitcast i32 {word} to <{self.count} x i{fmt.bits}>")
        return self.cast("zext", narrow, f"i{fmt.bits}", "i32")

    def join(self, fmt: Format, codes: str) -> str:
        """The word of codes; lanes that are not there are 0."""
        if self.count == 1:
            return codes
        narrow = self.cast("trunc", codes, "i32", f"i{fmt.bits}")
        bits = self.count * fmt.bits
        word = self.code.value(f"bitcast <{self.count} x i{fmt.bits}> {narrow} to i{bits}")
        return word if bits == WORD_BITS else self.code.value(f"zext i{bits} {word} to i32")

    def decode(self, fmt: Format, codes: str) -> str:
        """binary32 bits of codes; a NaN stays some NaN."""
        magnitude = self.do("and", codes, fmt.sign - 1)
        shifted = self.do("shl", magnitude, _MANTISSA - fmt.mantissa_bits)
        number = self.do("add", shifted, (_BIAS - fmt.bias) << _MANTISSA)
        # One more in the exponent is an implicit 1 that a subnormal number has not.
        unit = (_BIAS - fmt.bias + 1) << _MANTISSA
        sum_ = self.cast("bitcast", self.do("add", shifted, unit), "i32", "float")
        rest = self.do("fsub", sum_, self._float(unit), "float")
        is_small = self.do("icmp ult", magnitude, 1 << fmt.mantissa_bits)
        bits = self.choose(is_small, self.cast("bitcast", rest, "float", "i32"), number)
        special = self.do("or", shifted, INFINITY | (0 if fmt.has_infinity else 1))
        is_special = self.do("icmp ugt", magnitude, fmt.max_code)
        bits = self.choose(is_special, special, bits)
        sign = self.do("shl", self.do("and", codes, fmt.sign), WORD_BITS - fmt.bits)
        return self.do("or", bits, sign)

    def numbers(self, fmt: Format, word: str) -> str:
        """Lanes of a word as binary32 numbers."""
        return self.floats(self.decode(fmt, self.split(fmt, word)))

    def floats(self, bits: str) -> str:
        """Bits as binary32 numbers."""
        return self.cast("bitcast", bits, "i32", "float")

    def encode(self, fmt: Format, floats: str) -> str:
        """Codes of binary32 numbers, rounded once to nearest even."""
        bits = self.cast("bitcast", floats, "float", "i32")
        magnitude = self.do("and", bits, INT_MAX)
        cut = _MANTISSA - fmt.mantissa_bits
        moved = self.do("sub", magnitude, (_BIAS - fmt.bias) << _MANTISSA)
        last = self.do("and", self.do("lshr", moved, cut), 1)
        rounded = self.do("add", self.do("add", moved, (1 << (cut - 1)) - 1), last)
        normal = self.do("lshr", rounded, cut)
        # In a sum with this power of two the last place is that of the subnormal numbers.
        unit = (_BIAS + fmt.min_exponent + cut) << _MANTISSA
        sum_ = self.do("fadd", self.floats(magnitude), self._float(unit), "float")
        small = self.do("sub", self.cast("bitcast", sum_, "float", "i32"), unit)
        is_small = self.do("icmp ult", magnitude, (_BIAS + fmt.min_exponent) << _MANTISSA)
        codes = self.umin(self.choose(is_small, small, normal), fmt.overflow)
        sign = self.do("and", self.do("lshr", bits, WORD_BITS - fmt.bits), fmt.sign)
        is_nan = self.do("icmp ugt", magnitude, INFINITY)
        return self.choose(is_nan, self.all(fmt.nan), self.do("or", codes, sign))

    def _float(self, bits: int) -> str:
        """A constant: LLVM writes binary32 constants as binary64."""
        number = unpack("<f", pack("<I", bits))[0]
        return self.all(f"0x{unpack('<Q', pack('<d', number))[0]:016X}", "float")


def _binary(fmt: Format, name: str, code: Code, words: Sequence[str]) -> str:
    lanes = _Lanes(code, fmt.lanes)
    x, y = (lanes.numbers(fmt, word) for word in words)
    return lanes.join(fmt, lanes.encode(fmt, lanes.do(name, x, y, "float")))


def _fused(fmt: Format, name: str, code: Code, words: Sequence[str]) -> str:
    lanes = _Lanes(code, fmt.lanes)
    numbers = [lanes.numbers(fmt, word) for word in words]
    kind = "float" if fmt is E4M3 else "double"
    if kind == "double":
        numbers = [lanes.cast("fpext", number, "float", kind) for number in numbers]
    x, y, z = numbers
    product = lanes.do("fmul", x, y, kind)
    if name == "fma":
        total = lanes.do("fadd", product, z, kind)
    else:
        total = lanes.do("fsub", *((product, z) if name == "fms" else (z, product)), kind)
    if kind == "double":
        total = _rounded_to_odd(lanes, total)
    return lanes.join(fmt, lanes.encode(fmt, total))


def _rounded_to_odd(lanes: _Lanes, doubles: str) -> str:
    """binary32 numbers whose last bit is set where bits were cut off."""
    bits = lanes.cast("bitcast", doubles, "double", "i64")
    cut = (1 << _CUT) - 1
    lost = lanes.do("and", bits, lanes.all(cut, "i64"), "i64")
    inexact = lanes.do("icmp ne", lost, lanes.all(0, "i64"), "i64")
    last = lanes.cast("zext", inexact, "i1", "i64")
    last = lanes.do("shl", last, lanes.all(_CUT, "i64"), "i64")
    kept = lanes.do("and", bits, lanes.all(~cut, "i64"), "i64")
    odd = lanes.cast("bitcast", lanes.do("or", kept, last, "i64"), "i64", "double")
    return lanes.cast("fptrunc", odd, "double", "float")


def _compared(fmt: Format, comparison: str, code: Code, words: Sequence[str]) -> str:
    lanes = _Lanes(code, fmt.lanes)
    x, y = (lanes.numbers(fmt, word) for word in words)
    holds = lanes.do(f"fcmp {comparison}", x, y, "float")
    return lanes.join(fmt, lanes.cast("zext", holds, "i1", "i32"))


def _extremum(fmt: Format, comparison: str, if_equal: str, code: Code, words: Sequence[str]) -> str:
    """minimumNumber or maximumNumber; equal numbers share all bits but the sign of zero."""
    lanes = _Lanes(code, fmt.lanes)
    a, b = (lanes.split(fmt, word) for word in words)
    x, y = (lanes.floats(lanes.decode(fmt, codes)) for codes in (a, b))
    result = lanes.choose(lanes.do(f"fcmp {comparison}", x, y, "float"), a, b)
    equal = lanes.do("fcmp oeq", x, y, "float")
    result = lanes.choose(equal, lanes.do(if_equal, a, b), result)
    x_is_nan, y_is_nan = (lanes.do("fcmp uno", number, number, "float") for number in (x, y))
    if_y_is_nan = lanes.choose(x_is_nan, lanes.all(fmt.nan), a)
    return lanes.join(fmt, lanes.choose(y_is_nan, if_y_is_nan, result))


def _truncated(fmt: Format, code: Code, words: Sequence[str]) -> str:
    one = _Lanes(code, 1)
    return one.encode(fmt, one.floats(words[0]))


def _extended(fmt: Format, code: Code, words: Sequence[str]) -> str:
    one = _Lanes(code, 1)
    return _canonical(code, one.decode(fmt, one.split(fmt, words[0])))


def _unpacked(fmt: Format, code: Code, words: Sequence[str]) -> str:
    return _extended(fmt, code, [_lane(code, fmt.bits, words)])


def _lane(code: Code, bits: int, words: Sequence[str]) -> str:
    """A word, shifted right by so many lanes."""
    word, number = words
    lane = code.value(f"and i32 {number}, {WORD_BITS // bits - 1}")
    shift = code.value(f"mul i32 {lane}, {bits}")
    return code.value(f"lshr i32 {word}, {shift}")


def _packed(fmt: Format, code: Code, words: Sequence[str]) -> str:
    pair = _Lanes(code, 2)
    first = code.value(f"insertelement <2 x i32> poison, i32 {words[0]}, i32 0")
    both = code.value(f"insertelement <2 x i32> {first}, i32 {words[1]}, i32 1")
    return pair.join(fmt, pair.encode(fmt, pair.floats(both)))


def _packed_high(fmt: Format, code: Code, words: Sequence[str]) -> str:
    half = WORD_BITS // 2
    high = code.value(f"shl i32 {_packed(fmt, code, words[:2])}, {half}")
    low = code.value(f"and i32 {words[2]}, {(1 << half) - 1}")
    return code.value(f"or i32 {high}, {low}")


def _dot(fmt: Format, code: Code, words: Sequence[str]) -> str:
    lanes = _Lanes(code, fmt.lanes)
    x, y = (lanes.numbers(fmt, word) for word in words[:2])
    products = lanes.do("fmul", x, y, "float")
    total = code.value(f"bitcast i32 {words[2]} to float")
    for lane in range(fmt.lanes):
        product = code.value(f"extractelement {lanes.of('float')} {products}, i32 {lane}")
        total = code.value(f"fadd float {total}, {product}")
    return _canonical(code, code.value(f"bitcast float {total} to i32"))


def _canonical(code: Code, bits: str) -> str:
    magnitude = code.value(f"and i32 {bits}, {INT_MAX}")
    is_nan = code.value(f"icmp ugt i32 {magnitude}, {INFINITY}")
    return code.choose(is_nan, "i32", str(CANONICAL_NAN), bits)


def _select(bits: int, code: Code, words: Sequence[str]) -> str:
    mask, a, b = words
    ones = sum(1 << at for at in range(0, WORD_BITS, bits))
    lowest = code.value(f"and i32 {mask}, {ones}")
    chosen = code.value(f"mul i32 {lowest}, {(1 << bits) - 1}")
    differs = code.value(f"xor i32 {a}, {b}")
    return code.value(f"xor i32 {b}, {code.value(f'and i32 {differs}, {chosen}')}")


def _merge(bits: int, code: Code, words: Sequence[str]) -> str:
    low, high = (code.value(f"and i32 {word}, {(1 << bits) - 1}") for word in words)
    return code.value(f"or i32 {low}, {code.value(f'shl i32 {high}, {bits}')}")


def _extract(bits: int, code: Code, words: Sequence[str]) -> str:
    return code.value(f"and i32 {_lane(code, bits, words)}, {(1 << bits) - 1}")


def _of_format(fmt: Format) -> dict[str, Lowering]:
    """Operations on numbers of a format, by name."""
    packed = f"{fmt.name}x{fmt.lanes}"
    lowerings: dict[str, Lowering] = {
        f"{name}.{packed}": partial(_binary, fmt, name) for name in ("fadd", "fsub", "fmul")
    }
    comparisons = ("oeq", "une", "olt", "ole", "ult", "ule")
    lowerings |= {f"{name}.{packed}": partial(_fused, fmt, name) for name in ("fma", "fms", "fnma")}
    lowerings |= {f"fcmp.{name}.{packed}": partial(_compared, fmt, name) for name in comparisons}
    lowerings |= {
        f"fmin.{packed}": partial(_extremum, fmt, "olt", "or"),
        f"fmax.{packed}": partial(_extremum, fmt, "ogt", "and"),
        f"fptrunc.{fmt.name}": partial(_truncated, fmt),
        f"fpext.{fmt.name}": partial(_extended, fmt),
        f"pack.{packed}": partial(_packed, fmt),
        f"unpack.{packed}": partial(_unpacked, fmt),
        f"dot.{packed}": partial(_dot, fmt),
    }
    if fmt.bits < WORD_BITS // 2:
        lowerings[f"pack_high.{packed}"] = partial(_packed_high, fmt)
    return lowerings


def _table() -> dict[Opcode, Lowering]:
    lowerings = {name: of for fmt in FORMATS.values() for name, of in _of_format(fmt).items()}
    for lanes in (2, 4):
        bits = WORD_BITS // lanes
        lowerings[f"select.x{lanes}"] = partial(_select, bits)
        lowerings[f"merge.x{lanes}"] = partial(_merge, bits)
        lowerings[f"extract.x{lanes}"] = partial(_extract, bits)
    return {Opcode(name): of for name, of in lowerings.items()}


LANE_LOWERINGS: Final = _table()

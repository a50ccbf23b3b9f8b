"""Integer expressions with the range of their values, so that no program overflows 64 bits."""

from __future__ import annotations

from dataclasses import dataclass

LEAST, MOST = -(2**63), 2**63 - 1


@dataclass(frozen=True, slots=True)
class Value:
    """An expression of a signed type, and the least and the greatest value it may have."""

    text: str
    low: int
    high: int

    @property
    def fits(self) -> bool:
        """Whether no value overflows 64 bits."""
        return self.low >= LEAST and self.high <= MOST

    @property
    def size(self) -> int:
        """The greatest magnitude."""
        return max(abs(self.low), abs(self.high))


TYPES = {
    "int8": (-128, 127),
    "uint8": (0, 255),
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "int64": (LEAST, MOST),
}
"""Ranges of the integer types."""


def constant(number: int) -> Value:
    """A literal."""
    return Value(str(number) if number >= 0 else f"({number})", number, number)


def typed(text: str, dtype: str) -> Value:
    """A value of which only the type is known; unsigned ones become signed, as numba wants it."""
    low, high = TYPES[dtype]
    return Value(f"np.int64({text})" if low == 0 else text, low, high)


def cast(value: Value, dtype: str) -> Value:
    """`value` in a type that may cut bits off; of a signed type again if that has none."""
    low, high = TYPES[dtype]
    if low <= value.low and value.high <= high:
        low, high = value.low, value.high
    text = f"np.{dtype}({value.text})"
    return Value(f"np.int64({text})" if dtype.startswith("u") else text, low, high)


def narrowed(value: Value) -> Value:
    """`value` in 32 bits."""
    return cast(value, "int32")


def ring(operator: str, a: Value, b: Value) -> Value:
    """A sum, difference, product or bitwise operation; its operands are cut where it overflows."""
    found = _ring(operator, a, b)
    return found if found.fits else _ring(operator, narrowed(a), narrowed(b))


def _ring(operator: str, a: Value, b: Value) -> Value:
    text = f"({a.text} {operator} {b.text})"
    if operator == "+":
        return Value(text, a.low + b.low, a.high + b.high)
    if operator == "-":
        return Value(text, a.low - b.high, a.high - b.low)
    if operator == "*":
        ends = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
        return Value(text, min(ends), max(ends))
    if operator == "&" and min(a.low, b.low) < 0 <= max(a.low, b.low):
        return Value(text, 0, a.high if a.low >= 0 else b.high)
    bits = max(a.low.bit_length(), a.high.bit_length(), b.low.bit_length(), b.high.bit_length())
    return Value(text, -(2**bits) if min(a.low, b.low) < 0 else 0, 2**bits - 1)


def divided(operator: str, a: Value, b: Value) -> Value:
    """A quotient or remainder; `b` is never 0."""
    if a.low == LEAST:
        a = narrowed(a)
    if b.low == LEAST:
        b = narrowed(b)
    size = a.size if operator == "//" else b.size
    return Value(f"({a.text} {operator} {b.text})", -size, size)


def odd(value: Value) -> Value:
    """`value` with its lowest bit set, which is not 0."""
    return Value(f"({value.text} | 1)", value.low, value.high | 1)


def shifted(a: Value, amount: int) -> Value:
    """`a` times a power of two."""
    found = Value(f"({a.text} << {amount})", a.low << amount, a.high << amount)
    if not found.fits:
        a = Value(f"({a.text} & 65535)", 0, 65535)
        found = Value(f"({a.text} << {amount})", 0, 65535 << amount)
    return found if found.fits else a


def right(a: Value, amount: int) -> Value:
    """`a` divided by a power of two."""
    return Value(f"({a.text} >> {amount})", a.low >> amount, a.high >> amount)


def either(form: str, a: Value, b: Value) -> Value:
    """A form whose value is `a` or `b`."""
    text = form.format(a=a.text, b=b.text)
    return Value(text, min(a.low, b.low), max(a.high, b.high))

"""Random integer expressions: 64 signed bits without overflow, and 64 unsigned ones that wrap."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any, Protocol

from tests.fuzz.places import Places
from tests.fuzz.values import (
    TYPES,
    Value,
    cast,
    constant,
    divided,
    either,
    narrowed,
    odd,
    right,
    ring,
    shifted,
    typed,
)

CONSTANTS = (0, 1, -1, 2, 7, 31, 127, 255, 256, -128, 32767, 65535, 2**31 - 1, -(2**31), 2**32 - 1)
WIDE = (2**32, -(2**32) - 1, 2**40 + 3, -(2**55), 0x9E3779B97F4A7C15 >> 2)
DIVISORS = (1, 2, 3, 7, 10, 16, 255, -3, -7, -8, 641)
MASKS = (1, 15, 255, 65535, 2**31 - 1, 2**32 - 1)
RING = ("+", "-", "*", "&", "|", "^")
VARIABLES = {
    "s": (-(2**31), 2**31 - 1),
    "t": (-(2**62) - 2**54, 2**62 + 2**54),
    "n": (-(2**31), 2**31 - 1),
    "p": (-(2**62), 2**62),
    "q": (-128, 127),
    "k": (-(2**50), 2**50),
    "y": (0, 255),
}
SCALARS = (("m", "uint32"), ("m8", "uint8"), ("m16", "uint16"), ("n16", "int16"))
"""Parameters of types that have no other."""

UNSIGNED = (
    "({a} + {b})",
    "({a} - {b})",
    "({a} * {b})",
    "({a} ^ {b})",
    "({a} & {b})",
    "({a} | {b})",
    "({a} >> np.uint64({k}))",
    "({a} << np.uint64({k}))",
    "({a} >> ({b} & np.uint64(63)))",
    "({a} // np.uint64({d}))",
    "({a} % np.uint64({d}))",
    "(({a} << np.uint64({j})) | ({a} >> np.uint64(64 - {j})))",
    "min({a}, {b})",
    "max({a}, {b})",
    "({a} if {a} > {b} else {b})",
)


Form = Callable[[Any, Value, Value], Value]
"""Makes an expression of two."""


class Context(Protocol):
    """What an expression may read."""

    random: Random
    places: Places
    is_wide: bool
    items: list[tuple[str, str]]
    more: tuple[Form, ...]

    def condition(self, depth: int) -> str:
        """A boolean expression."""

    def real(self, depth: int) -> str:
        """A float32 expression."""

    def real_method(self) -> str | None:
        """A sum or an extreme of float32."""

    def element(self, dtypes: tuple[str, ...], deep: bool) -> tuple[str, str] | None:
        """An element of an array of one of the types, and its type."""


def integer(at: Context, depth: int) -> Value:
    """An expression of a signed type."""
    if depth == 0:
        return leaf(at)
    kind = at.random.random()
    if kind < 0.35:
        a, b = integer(at, depth - 1), integer(at, at.random.randint(0, depth - 1))
        return ring(at.random.choice(RING), a, b)
    if at.is_wide and kind < 0.45:
        return cast_back(at, unsigned(at, depth - 1))
    form = at.random.choice(FORMS + at.more)
    return form(at, integer(at, depth - 1), integer(at, at.random.randint(0, depth - 1)))


def cast_back(at: Context, text: str) -> Value:
    """A signed value of an unsigned expression."""
    dtype = at.random.choice(["int32", "int32", "uint32", "uint8", "int64"])
    return cast(Value(text, 0, 2**64 - 1), dtype)


def leaf(at: Context) -> Value:
    """A variable, a parameter, a counter, an element or a constant."""
    kind = at.random.random()
    if kind < 0.2:
        name = at.random.choice("stnpqky" if at.is_wide else "snqky")
        low, high = VARIABLES[name]
        return Value(f"np.int64({name})" if name == "y" else name, low, high)
    if kind < 0.25:
        return typed(*at.random.choice([*SCALARS, *at.items]))
    if kind < 0.45 and at.places.counters:
        counter = at.random.choice(at.places.counters)
        return Value(counter.name, -4, counter.most)
    if kind < 0.6:
        return constant(at.random.choice(CONSTANTS + WIDE * at.is_wide))
    found = at.element(tuple(TYPES), at.random.random() < 0.2)
    if found is None:
        return constant(at.random.choice(CONSTANTS))
    return typed(*found)


def unsigned(at: Context, depth: int) -> str:
    """An expression of type uint64."""
    if depth <= 0:
        leaves = ["r", "h", "np.uint64(m)", f"np.uint64({leaf(at).text})"]
        leaves.append(f"np.uint64({at.random.choice([1, 255, 2**32, 2**63, 0xCBF29CE484222325])})")
        return at.random.choice(leaves)
    form = at.random.choice(UNSIGNED)
    return form.format(
        a=unsigned(at, depth - 1),
        b=unsigned(at, depth - 1),
        k=at.random.choice([0, 1, 7, 29, 31, 32, 33, 63]),
        j=at.random.choice([1, 13, 31, 32, 47]),
        d=at.random.choice([1, 2, 3, 10, 1000, 2**32, 2**32 + 1, 2**63 + 1]),
    )


def _word(operator: str, at: Context, a: Value, b: Value) -> Value:
    """An operation of 32 unsigned bits."""
    one, other = f"np.uint32({a.text})", f"np.uint32({b.text})"
    if operator in ("//", "%"):
        other = f"np.uint32(({b.text}) | 1)"
    if operator == ">>":
        other = f"np.uint32(({b.text}) & 31)"
    return Value(f"np.int64(np.uint32({one} {operator} {other}))", 0, 2**32 - 1)


def _any_word(at: Context, a: Value, b: Value) -> Value:
    return _word(at.random.choice((*RING, "//", "%", ">>")), at, a, b)


def _cast(at: Context, a: Value, b: Value) -> Value:
    return cast(a, at.random.choice(list(TYPES)[: 7 if at.is_wide else 6]))


def _divide(at: Context, a: Value, b: Value) -> Value:
    operator = at.random.choice(["//", "%"])
    kind = at.random.random()
    if kind < 0.5:
        return divided(operator, a, constant(at.random.choice(DIVISORS)))
    if kind < 0.9 or not at.is_wide:
        return divided(operator, narrowed(a), odd(narrowed(b)))
    return divided(operator, a, odd(b))


def _shift(at: Context, a: Value, b: Value) -> Value:
    kind = at.random.random()
    if kind < 0.3:
        return shifted(a, at.random.choice([0, 1, 5, 8, 16, 31]))
    if kind < 0.6:
        return right(a, at.random.choice([0, 1, 5, 8, 16, 31, 32]))
    if kind < 0.8:
        a = narrowed(a)
        return Value(f"({a.text} >> ({b.text} & 31))", min(a.low, 0), max(a.high, 0))
    if kind < 0.9:
        a = narrowed(a)
        return Value(
            f"({a.text} << ({b.text} & 15))", a.low << 15 if a.low < 0 else 0, a.size << 15
        )
    return Value(f"({a.text} >> ({b.text} & 63))", min(a.low, 0), max(a.high, 0))


def _extreme(at: Context, a: Value, b: Value) -> Value:
    kind = at.random.random()
    if kind < 0.3:
        low, high = sorted(at.random.sample([-128, 0, 127, 255, 1000], 2))
        return Value(f"min(max({a.text}, {low}), {high})", low, high)
    return either(at.random.choice(["min({a}, {b})", "max({a}, {b})"]), a, b)


def _absolute(at: Context, a: Value, b: Value) -> Value:
    a = narrowed(a) if a.low == TYPES["int64"][0] or at.random.random() < 0.7 else a
    return Value(f"abs({a.text})", min(a.low, 0), a.size)


def _unary(at: Context, a: Value, b: Value) -> Value:
    if at.random.random() < 0.5:
        return Value(f"(~({a.text}))", -a.high - 1, -a.low - 1)
    a = narrowed(a) if a.low == TYPES["int64"][0] else a
    return Value(f"(-({a.text}))", -a.high, -a.low)


def _mask(at: Context, a: Value, b: Value) -> Value:
    mask = at.random.choice(MASKS)
    return Value(f"({a.text} & {mask})", 0, mask)


def _select(at: Context, a: Value, b: Value) -> Value:
    return either(f"({{a}} if {at.condition(0)} else {{b}})", a, b)


def _call(at: Context, a: Value, b: Value) -> Value:
    text = f"mix(np.int32({a.text}), np.int32({b.text}))"
    return Value(text, *TYPES["int32"])


def _table(at: Context, a: Value, b: Value) -> Value:
    if at.random.random() < 0.5:
        return Value(f"TABLE[({a.text}) & 15]", *TYPES["int32"])
    return Value(f"SMALL[({a.text}) & 3]", -3, 12)


def _power(at: Context, a: Value, b: Value) -> Value:
    if at.random.random() < 0.5:
        return Value(f"(({a.text} & 15) ** 3)", 0, 15**3)
    a, b = narrowed(a), odd(narrowed(b))
    number = at.random.choice([0, 1])
    size = b.size if number else a.size
    return Value(f"divmod({a.text}, {b.text})[{number}]", -size, size)


def _of_real(at: Context, a: Value, b: Value) -> Value:
    x = at.real(1)
    change = at.random.choice(["np.int32({x})", "np.int32(math.floor({x}))", "np.int64({x})"])
    text = f"({change.format(x=x)} if abs({x}) < np.float32(1000.0) else {at.random.randint(0, 9)})"
    return Value(text, -1000, 1000)


def _truth(at: Context, a: Value, b: Value) -> Value:
    return Value(f"np.int32({at.condition(0)})", 0, 1)


FORMS = (
    _cast,
    _cast,
    _any_word,
    _any_word,
    _divide,
    _divide,
    _divide,
    _shift,
    _shift,
    _shift,
    _extreme,
    _extreme,
    _absolute,
    _unary,
    _mask,
    _mask,
    _select,
    _select,
    _call,
    _table,
    _power,
    _of_real,
    _truth,
)


def narrowed_text(value: Value) -> str:
    """`value` in 32 bits, as text."""
    return f"np.int32({value.text})"

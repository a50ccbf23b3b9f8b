"""Interval arithmetic contains every concrete result."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from vividc.frontend.ranges.interval import (
    BOTTOM,
    Interval,
    compare,
    contains,
    evaluate,
    full,
    refine,
    union,
    widen,
    width,
)
from vividc.ssa.ir import Instr

BINARY = ("add", "sub", "mul", "and", "or", "xor", "shl", "lshr", "ashr")
FLOORS = ("sfloordiv", "sfloorrem", "ufloordiv", "ufloorrem")
DIVISIONS = ("sdiv", "udiv", "srem", "urem")
EXTREMA = ("smin", "smax", "umin", "umax")
PREDICATES = ("eq", "ne", "slt", "sle", "sgt", "sge", "ult", "ule", "ugt", "uge")


def wrapped(value: int, type_: str) -> int:
    bits = width(type_)
    value &= (1 << bits) - 1
    return value - (1 << bits) if value >> (bits - 1) else value


def unsigned(value: int, type_: str) -> int:
    return value & ((1 << width(type_)) - 1)


def truncated(a: int, b: int) -> int:
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def concrete(op: str, a: int, b: int, type_: str) -> int | None:
    """The instruction on two values, None where it is undefined."""
    if op in ("shl", "lshr", "ashr") and not 0 <= b < width(type_):
        return None
    if op in DIVISIONS and b == 0:
        return None
    ua, ub = unsigned(a, type_), unsigned(b, type_)
    results = {
        "add": lambda: a + b,
        "sub": lambda: a - b,
        "mul": lambda: a * b,
        "and": lambda: a & b,
        "or": lambda: a | b,
        "xor": lambda: a ^ b,
        "shl": lambda: a << b,
        "lshr": lambda: ua >> b,
        "ashr": lambda: a >> b,
        "sdiv": lambda: truncated(a, b),
        "udiv": lambda: ua // ub,
        "srem": lambda: a - b * truncated(a, b),
        "urem": lambda: ua % ub,
        "sfloordiv": lambda: a // b if b else 0,
        "sfloorrem": lambda: a % b if b else 0,
        "ufloordiv": lambda: ua // ub if b else 0,
        "ufloorrem": lambda: ua % ub if b else 0,
        "smin": lambda: min(a, b),
        "smax": lambda: max(a, b),
        "umin": lambda: min(a, b, key=lambda v: unsigned(v, type_)),
        "umax": lambda: max(a, b, key=lambda v: unsigned(v, type_)),
    }
    return wrapped(results[op](), type_)


def compared(pred: str, a: int, b: int, type_: str) -> bool:
    if pred[0] == "u":
        a, b, pred = unsigned(a, type_), unsigned(b, type_), "s" + pred[1:]
    order = {"slt": a < b, "sle": a <= b, "sgt": a > b, "sge": a >= b, "eq": a == b, "ne": a != b}
    return order[pred]


@st.composite
def interval_and_value(draw: st.DrawFn, type_: str) -> tuple[Interval, int]:
    low, high = full(type_)
    edges = [0, 1, -1, 5, 31, 32, 2**31 - 1, 2**31, -(2**31), 2**32 - 1, low, high]
    point = st.one_of(st.integers(low, high), st.integers(-70, 70), st.sampled_from(edges))
    three = sorted(min(max(draw(point), low), high) for _ in range(3))
    return (three[0], three[2]), three[1]


TYPES = st.sampled_from(["i32", "i64"])


@given(st.data(), TYPES, st.sampled_from(BINARY + DIVISIONS + FLOORS + EXTREMA))
def test_results_lie_in_the_interval(data: st.DataObject, type_: str, name: str) -> None:
    left, a = data.draw(interval_and_value(type_))
    right, b = data.draw(interval_and_value(type_))
    call = name in EXTREMA
    op = Instr(0, "call" if call else name, type_, (), pred=f"llvm.{name}.{type_}" if call else "")
    result = concrete(name, a, b, type_)
    low, high = evaluate(op, (left, right))
    assert result is None or low <= result <= high


@given(st.data(), st.sampled_from(["i8", "i16"]), st.sampled_from(BINARY + DIVISIONS + EXTREMA))
def test_small_types_are_kept_without_sign(data: st.DataObject, type_: str, name: str) -> None:
    left, a = data.draw(interval_and_value(type_))
    right, b = data.draw(interval_and_value(type_))
    call = name in EXTREMA
    op = Instr(0, "call" if call else name, type_, (), pred=f"llvm.{name}.{type_}" if call else "")
    result = concrete(name, wrapped(a, type_), wrapped(b, type_), type_)
    low, high = evaluate(op, (left, right))
    assert result is None or low <= unsigned(result, type_) <= high


@given(st.data(), TYPES, st.sampled_from(PREDICATES))
def test_comparisons_decide_and_refine_soundly(data: st.DataObject, type_: str, pred: str) -> None:
    left, a = data.draw(interval_and_value(type_))
    right, b = data.draw(interval_and_value(type_))
    truth = compared(pred, a, b, type_)
    assert compare(pred, left, right) in (None, truth)
    if truth:
        low, high = refine(left, pred, right)
        assert low <= a <= high


WIDTHS = [("i8", "i16"), ("i8", "i32"), ("i16", "i64"), ("i32", "i64"), ("i1", "i8"), ("i1", "i64")]


@given(st.data(), st.sampled_from(["sext", "zext", "trunc"]), st.sampled_from(WIDTHS))
def test_conversions_keep_the_value(data: st.DataObject, name: str, types: tuple[str, str]) -> None:
    source, target = reversed(types) if name == "trunc" else types
    interval, value = data.draw(interval_and_value(source))
    result = unsigned(value, source) if name == "zext" else wrapped(value, source)
    result = unsigned(result, target) if width(target) < 32 else wrapped(result, target)
    low, high = evaluate(Instr(0, name, target, (), source=source), (interval,))
    assert low <= result <= high


@given(st.data(), TYPES)
def test_widening_covers_and_ends(data: st.DataObject, type_: str) -> None:
    current, _ = data.draw(interval_and_value(type_))
    for _ in range(40):
        grown, _ = data.draw(interval_and_value(type_))
        new = widen(current, union(current, grown), type_)
        assert contains(new, current)
        assert contains(new, grown)
        if new == full(type_):
            break
        current = new


def test_nothing_is_contained_everywhere() -> None:
    assert contains((3, 4), BOTTOM)
    assert union(BOTTOM, (1, 2)) == (1, 2) == union((1, 2), BOTTOM)

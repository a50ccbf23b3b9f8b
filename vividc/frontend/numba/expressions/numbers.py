"""Numbers that are known while numba lowers a function, or are LLVM's: sizes, bounds, subscripts.

What is computed from sizes of parameters and constants alone is computed once, where the function
begins, so that equal sizes of two views are the same value.
"""

from __future__ import annotations

from typing import Any, Final

from llvmlite import ir as llvm

Number = Any
"""An int, or an i64 of LLVM's."""

_I64: Final = llvm.IntType(64)


def value(number: Number) -> Any:
    """A number as LLVM's."""
    return _I64(number) if isinstance(number, int) else number


class Numbers:
    """Arithmetic at the place of `builder`, in 64 bits, which nothing here exceeds; `begin`: the
    block where the function has its arguments, whose end numba writes last.
    """

    def __init__(self, builder: llvm.IRBuilder, begin: Any = None) -> None:
        self._builder = builder
        self._begin = begin
        self._fixed: set[Any] = set()
        self._made: dict[tuple[Any, ...], Any] = {}

    def fix(self, *values: Any) -> None:
        """Take note that values are computed where the function begins."""
        self._fixed.update(map(id, values))

    def is_fixed(self, number: Number) -> bool:
        """Whether a number is the same wherever it is read."""
        return isinstance(number, int) or id(number) in self._fixed

    def add(self, one: Number, other: Number) -> Number:
        """The sum."""
        if isinstance(one, int) and isinstance(other, int):
            return one + other
        if 0 in (one, other):
            return other if one == 0 else one
        return self._compute("add", one, other)

    def sub(self, one: Number, other: Number) -> Number:
        """The difference."""
        if isinstance(one, int) and isinstance(other, int):
            return one - other
        return self.add(one, -other) if isinstance(other, int) else self._compute("sub", one, other)

    def mul(self, one: Number, other: Number) -> Number:
        """The product."""
        if isinstance(one, int) and isinstance(other, int):
            return one * other
        if 1 in (one, other):
            return other if one == 1 else one
        return self._compute("mul", one, other)

    def divide(self, one: Number, by: int) -> Number:
        """The quotient of a number that is not negative."""
        return one // by if isinstance(one, int) else self._compute("udiv", one, by)

    def larger(self, one: Number, other: Number) -> Number:
        """The larger one of two."""
        if isinstance(one, int) and isinstance(other, int):
            return max(one, other)
        return self._compute("<", one, other)

    def smaller(self, one: Number, other: Number) -> Number:
        """The smaller one of two."""
        if isinstance(one, int) and isinstance(other, int):
            return min(one, other)
        return self._compute(">", one, other)

    def up(self, start: Any, stop: Any, size: Number) -> tuple[Number, Number]:
        """The first index of a slice with a positive step, and how far it reaches; None: no bound.

        The first index is at most `size` unless the slice is empty.
        """
        begin = start or 0
        if not isinstance(begin, int):
            begin = self.larger(self._wrapped(begin, size), 0)
        elif begin < 0:
            begin = self.larger(self.add(size, begin), 0)
        end = size
        if isinstance(stop, int) and stop < 0:
            end = self.add(size, stop)
        elif stop is not None:
            end = self.smaller(self._wrapped(stop, size), size)
        return begin, self.larger(self.sub(end, begin), 0)

    def down(self, start: Any, stop: Any, size: Number) -> tuple[Number, Number]:
        """The first index of a slice with a negative step, and how far it reaches."""
        begin = last = self.add(size, -1)
        if isinstance(start, int) and start < 0:
            begin = self.add(size, start)
        elif start is not None:
            begin = self.smaller(self._wrapped(start, size), last)
        end = -1 if stop is None else stop
        if isinstance(stop, int) and stop < 0:
            end = self.larger(self.add(size, stop), -1)
        elif not isinstance(end, int):
            end = self.larger(self._wrapped(end, size), -1)
        return begin, self.larger(self.sub(begin, end), 0)

    def _wrapped(self, bound: Number, size: Number) -> Number:
        """A bound that counts from the end if it is negative."""
        if isinstance(bound, int):
            return bound
        below = self._builder.icmp_signed("<", bound, bound.type(0))
        return self._builder.select(below, self._builder.add(bound, value(size)), bound)

    def _compute(self, what: str, one: Number, other: Number) -> Number:
        if not (self.is_fixed(one) and self.is_fixed(other)):
            return self._emit(what, value(one), value(other))
        key = (what, *(n if isinstance(n, int) else (id(n),) for n in (one, other)))
        if key not in self._made:
            with self._builder.goto_block(self._begin):
                self._made[key] = self._emit(what, value(one), value(other))
            self.fix(self._made[key])
        return self._made[key]

    def _emit(self, what: str, one: Any, other: Any) -> Any:
        if what in "<>":  # the other one if the first is less, or greater
            return self._builder.select(self._builder.icmp_signed(what, one, other), other, one)
        flags = () if what == "udiv" else ("nsw",)
        return getattr(self._builder, what)(one, other, flags=flags)

"""A function's body under construction: LLVM IR as text, blocks, and local variables."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Final

from vividc.host.machine_code.types import (
    ELEMENTS,
    FLOAT,
    INT,
    TRUTH,
    Array,
    Number,
    Record,
    Type,
    parts,
    words,
)

OUTSIDE: Final = "outside"


@dataclass(frozen=True, slots=True)
class Value:
    """A value in the parts in which it is passed; `number`: what is known of a constant."""

    type: Type
    parts: tuple[str, ...]
    number: int | float | None = None

    @property
    def text(self) -> str:
        """Of a number, its one part."""
        (part,) = self.parts
        return part


def constant(number: float) -> Value:
    """A number of the source.

    Raises
    ------
    TypeError
        It is no number, or has more than 64 bits.
    """
    if isinstance(number, bool):
        return Value(TRUTH, (str(number).lower(),))
    if isinstance(number, int) and -(1 << 63) <= number < 1 << 63:
        return Value(INT, (str(int(number)),), number)
    if isinstance(number, float):
        return Value(FLOAT, (f"0x{struct.pack('>d', number).hex()}",), number)
    raise TypeError(f"no constant of compiled functions: {number!r}")


class Body:
    """Lines of one function; `checked`: indices out of bounds are taken for 0, and `OUTSIDE` tells
    that there was one.
    """

    def __init__(self, checked: bool = False) -> None:
        self.checked = checked
        self.lines: list[str] = []
        self.locals: list[str] = []
        self.block = "entry"
        self.is_open = True
        self._made = 0

    def new(self, expression: str) -> str:
        """Name of what an expression computes."""
        self._made += 1
        name = f"%v{self._made}"
        self.lines.append(f"  {name} = {expression}")
        return name

    def do(self, statement: str) -> None:
        """A statement without a value."""
        self.lines.append(f"  {statement}")

    def local(self, llvm: str) -> str:
        """The address of a new local variable."""
        self._made += 1
        name = f"%x{self._made}"
        self.locals.append(f"  {name} = alloca {llvm}")
        return name

    def labels(self, *names: str) -> tuple[str, ...]:
        """Labels that no other block has."""
        self._made += 1
        return tuple(f"{name}{self._made}" for name in names)

    def start(self, label: str) -> None:
        """Begin a block; the one before goes on there if it has no end yet."""
        self.go(label)
        self.lines.append(f"{label}:")
        self.block, self.is_open = label, True

    def go(self, label: str) -> None:
        """End the block, if it is open."""
        self.end(f"br label %{label}")

    def branch(self, condition: str, yes: str, no: str) -> None:
        """End the block with a choice."""
        self.end(f"br i1 {condition}, label %{yes}, label %{no}")

    def end(self, statement: str) -> None:
        """End the block, if it is open."""
        if self.is_open:
            self.do(statement)
        self.is_open = False

    # --- values ---

    def converted(self, value: Value, to: Type) -> Value:
        """The value as another type, without loss.

        Raises
        ------
        TypeError
            It would lose something, or mean something else.
        """
        if value.type == to:
            return value
        if isinstance(value.type, Number) and isinstance(to, Number):
            return self._converted_number(value, to)
        if isinstance(value.type, Record) and isinstance(to, Record):
            return self._converted_record(value, to)
        raise TypeError(f"{value.type} is no {to}")

    def _converted_number(self, value: Value, to: Number) -> Value:
        if value.type == INT and to == FLOAT and value.number is not None:
            return constant(float(value.number))
        casts = {(TRUTH, INT): "zext", (TRUTH, FLOAT): "uitofp", (INT, FLOAT): "sitofp"}
        assert isinstance(value.type, Number)
        cast = casts.get((value.type, to))
        if cast is None:
            raise TypeError(f"{value.type.llvm} where {to.llvm} is wanted")
        return Value(to, (self.new(f"{cast} {value.type.llvm} {value.text} to {to.llvm}"),))

    def _converted_record(self, value: Value, to: Record) -> Value:
        assert isinstance(value.type, Record)
        if len(value.type.fields) != len(to.fields) or value.type.is_stored or to.is_stored:
            raise TypeError(f"{value.type} is no {to}")
        items = map(self.converted, self.items(value), to.fields)
        return Value(to, tuple(part for item in items for part in item.parts))

    def items(self, value: Value) -> list[Value]:
        """The items of a tuple."""
        if not isinstance(value.type, Record):
            raise TypeError(f"{value.type} is no tuple")
        if value.type.is_stored:
            return [self.item(value, place) for place in range(len(value.type.fields))]
        found: list[Value] = []
        first = 0
        for field in value.type.fields:
            count = len(parts(field))
            found.append(Value(field, value.parts[first : first + count]))
            first += count
        return found

    def item(self, value: Value, place: int) -> Value:
        """One item of a tuple."""
        assert isinstance(value.type, Record)
        if not value.type.is_stored:
            return self.items(value)[place]
        before = sum(map(words, value.type.fields[:place]))
        return self.loaded(value.type.fields[place], self.at(value.text, before))

    def at(self, pointer: str, word: int) -> str:
        """The address of a word, so many behind the first."""
        return self.new(f"getelementptr i64, ptr {pointer}, i64 {word}") if word else pointer

    def loaded(self, kind: Type, pointer: str) -> Value:
        """What is stored in words that nothing changes."""
        if isinstance(kind, Record):
            if kind.is_stored:
                return Value(kind, (pointer,))
            found: list[str] = []
            first = 0
            for field in kind.fields:
                found += self.loaded(field, self.at(pointer, first)).parts
                first += words(field)
            return Value(kind, tuple(found))
        if isinstance(kind, Array):
            llvm = parts(kind)
            made = [self._word(part, self.at(pointer, k)) for k, part in enumerate(llvm)]
            return Value(kind, tuple(made))
        if kind == TRUTH:
            return Value(kind, (self.new(f"trunc i64 {self._word('i64', pointer)} to i1"),))
        return Value(kind, (self._word(kind.llvm, pointer),))

    def _word(self, llvm: str, pointer: str) -> str:
        return self.new(f"load {llvm}, ptr {pointer}, !invariant.load !0")

    # --- elements of arrays ---

    def element(self, array: Value, indices: list[Value]) -> str:
        """The address of an element, or of a row."""
        assert isinstance(array.type, Array)
        pointer, *lengths = array.parts
        place = ""
        for index, length in zip(indices, lengths, strict=False):
            at = self.converted(index, INT).text
            at = self._inside(at, length) if self.checked else at
            if place:
                at = self.new(f"add nsw i64 {self.new(f'mul nsw i64 {place}, {length}')}, {at}")
            place = at
        for length in lengths[len(indices) :]:
            place = self.new(f"mul nsw i64 {place}, {length}")
        memory = ELEMENTS[array.type.dtype][0]
        return self.new(f"getelementptr {memory}, ptr {pointer}, i64 {place}")

    def _inside(self, at: str, length: str) -> str:
        outside = self.new(f"icmp uge i64 {at}, {length}")
        seen = self.new(f"load i64, ptr @{OUTSIDE}")
        more = self.new(f"zext i1 {outside} to i64")
        self.do(f"store i64 {self.new(f'or i64 {seen}, {more}')}, ptr @{OUTSIDE}")
        return self.new(f"select i1 {outside}, i64 0, i64 {at}")

    def read(self, dtype: str, address: str) -> Value:
        """An element as a value."""
        memory, kind = ELEMENTS[dtype]
        found = self.new(f"load {memory}, ptr {address}")
        if memory == "i8":
            found = self.new(f"zext i8 {found} to i64")
        return Value(kind, (found,))

    def write(self, dtype: str, address: str, value: Value) -> None:
        """Set an element; of bytes, the low eight bits of an integer."""
        memory, kind = ELEMENTS[dtype]
        text = self.converted(value, kind).text
        if memory == "i8":
            text = self.new(f"trunc i64 {text} to i8")
        self.do(f"store {memory} {text}, ptr {address}")

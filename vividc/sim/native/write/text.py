"""LLVM IR as text, one value at a time, with the trivial cases folded.

Text, because it is several times faster to write and parse than building the module object by
object; the verifier of LLVM checks it.
"""

from __future__ import annotations

from typing import Final

TRUE: Final = "true"
FALSE: Final = "false"


class Code:
    """The body of one function under construction."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.block = "entry"
        self._values = 0
        self._blocks = 0

    def value(self, expression: str) -> str:
        """Name of a new value that `expression` computes."""
        self._values += 1
        name = f"%v{self._values}"
        self.lines.append(f"  {name} = {expression}")
        return name

    def do(self, statement: str) -> None:
        """A statement without a value."""
        self.lines.append(f"  {statement}")

    def fresh(self, name: str) -> str:
        """A label that no other block has."""
        self._blocks += 1
        return f"{name}{self._blocks}"

    def start(self, label: str) -> None:
        """Begin a block."""
        self.lines.append(f"{label}:")
        self.block = label

    def both(self, a: str, b: str) -> str:
        """Conjunction of two i1."""
        if FALSE in (a, b):
            return FALSE
        if TRUE in (a, b):
            return b if a == TRUE else a
        return self.value(f"and i1 {a}, {b}")

    def either(self, a: str, b: str) -> str:
        """Disjunction of two i1."""
        if TRUE in (a, b):
            return TRUE
        if FALSE in (a, b):
            return b if a == FALSE else a
        return self.value(f"or i1 {a}, {b}")

    def negated(self, a: str) -> str:
        """Negation of an i1."""
        if a in (TRUE, FALSE):
            return FALSE if a == TRUE else TRUE
        return self.value(f"xor i1 {a}, true")

    def choose(self, condition: str, kind: str, a: str, b: str) -> str:
        """`a` if the condition holds, else `b`."""
        if condition == TRUE or a == b:
            return a
        if condition == FALSE:
            return b
        return self.value(f"select i1 {condition}, {kind} {a}, {kind} {b}")

    def counted(self, total: str, condition: str) -> str:
        """The i64 `total`, plus one if the condition holds."""
        if condition == FALSE:
            return total
        if condition == TRUE:
            return self.value(f"add i64 {total}, 1")
        one = self.value(f"zext i1 {condition} to i64")
        return self.value(f"add i64 {total}, {one}")

    def extended(self, word: str) -> str:
        """The i32 `word` as i64, with zeros."""
        return self.value(f"zext i32 {word} to i64")

    def at(self, pointer: str, kind: str, index: int) -> str:
        """Address of element `index` of an array."""
        return self.value(f"getelementptr {kind}, ptr {pointer}, i64 {index}")

    def load(self, kind: str, pointer: str, index: int = 0) -> str:
        """Element `index` of an array."""
        place = self.at(pointer, kind, index) if index else pointer
        return self.value(f"load {kind}, ptr {place}")

    def store(self, kind: str, value: str, pointer: str, index: int = 0) -> None:
        """Set element `index` of an array."""
        place = self.at(pointer, kind, index) if index else pointer
        self.do(f"store {kind} {value}, ptr {place}")

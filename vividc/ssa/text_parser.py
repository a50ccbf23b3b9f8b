"""The parser of a function's text form (see `vividc.ssa.text` for the language)."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from typing import Any, Final

from vividc.errors import SourceLoc, SSAError, quoted
from vividc.host.inputs import demand_few_parts
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import MAX_NDIM, DType, LocalArray, Param
from vividc.machine.text_line import TextLine
from vividc.machine.words import WORD_MASK
from vividc.ssa.ir import (
    Block,
    Branch,
    Const,
    Float,
    Function,
    Global,
    Input,
    Instr,
    Int,
    Kind,
    Parts,
    Phi,
    Ref,
    Undefined,
    Value,
)
from vividc.ssa.results import Results

PLAIN: Final = re.compile(r"[A-Za-z_][\w.]*")
"""A block's name that needs no quotes."""

_OPCODES: Final = {op.value: op for op in Opcode}
_TYPES: Final = {kind.value: kind for kind in Type}
_DTYPES: Final = {kind.value: kind for kind in DType}
_VALUES: Final = frozenset({"undef", "f64", "parts"})
"""Words that values begin with."""


def parse(text: str, file: str = "<text>") -> Function:
    """The function that `to_text` printed.

    Parameters
    ----------
    file
        Named in errors.

    Raises
    ------
    SSAError
        The text is malformed; file and line are named. Invariants are `check_function`'s.
    """
    demand_few_parts(text.count("\n"), "lines", file, SSAError)
    reader = _Reader()
    for number, source in enumerate(text.split("\n"), start=1):
        if source.strip() and not source.lstrip().startswith("#"):
            reader.line(_Line(SourceLoc(file, number), source, SSAError))
    return reader.function(file)


class _Line(TextLine):
    """A line of a function; `is_llvm`: its operations and types are LLVM's."""

    is_llvm = False

    @property
    def ended(self) -> bool:
        """All tokens are taken, but for the source line."""
        return self.peek()[0] in ("end", "loc")

    def text(self) -> str:
        """A text in quotes."""
        return self.string(self.expect("string"))

    def name(self) -> str:
        """A block's name, in quotes or without."""
        plain = self.accept("word")
        return self.text() if plain is None else plain

    def choice(self, table: dict[str, Any], what: str) -> Any:
        """One of the table's words."""
        word = self.accept("word")
        if word not in table:
            self.fail(f"expected {what}, found {word or self.peek()[1]}")
        return table[word]

    def listed(self, one: Callable[[], Any]) -> tuple[Any, ...]:
        """What stands between brackets, with commas between."""
        self.expect("mark", "[")
        if self.accept("mark", "]"):
            return ()
        items = [one()]
        while self.accept("mark", ","):
            items.append(one())
        self.expect("mark", "]")
        return tuple(items)

    def value(self) -> Value:
        """An operand."""
        ref = self.accept("ref")
        if ref is not None:
            return Ref(self.whole(ref[1:]))
        if self.accept("mark", "$"):
            return Input(self.text())
        if self.accept("word", "undef"):
            return Undefined()
        return self.constant() if self.is_llvm else self.word()

    def word(self) -> Const:
        """A constant of 32 bits."""
        word = self.integer()
        if not 0 <= word <= WORD_MASK:
            self.fail(f"{word} is not a 32-bit word")
        return Const(word)

    def constant(self) -> Value:
        """A constant of LLVM's."""
        if self.accept("mark", "@"):
            name = self.text()
            return Global(name, self.integer() if self.peek()[0] == "number" else 0)
        if self.accept("word", "parts"):
            return Parts(self.listed(self.value))
        if not self.accept("word", "f64"):
            return Int(self.integer())
        bits = self.integer()
        if not 0 <= bits < 1 << 64:
            self.fail(f"{bits} are not the bits of a double")
        return Float(struct.unpack("<d", bits.to_bytes(8, "little"))[0])

    def kind(self) -> Kind:
        """A type: a word's, or of LLVM's by name."""
        kind: Kind = self.name() if self.is_llvm else self.choice(_TYPES, "a type")
        return kind

    def values(self) -> tuple[Value, ...]:
        """Operands up to the first clause."""
        kind, text = self.peek()
        if self.ended or (kind == "word" and text not in _VALUES):
            return ()
        values = [self.value()]
        while self.accept("mark", ","):
            values.append(self.value())
        return tuple(values)

    def result(self) -> int | None:
        """The id of what the line defines, if it defines anything."""
        ref = self.accept("ref")
        return None if ref is None else self.whole(ref[1:])


class _Reader:
    """What has been read so far."""

    def __init__(self) -> None:
        self._header: dict[str, Any] | None = None
        self._inputs: list[tuple[str, str]] = []
        self._params: list[Param] = []
        self._locals: list[LocalArray] = []
        self._results: Results | None = None
        self._blocks: list[Block] = []
        self._name: str | None = None
        self._phis: list[Phi] = []
        self._instrs: list[Instr] = []

    def line(self, line: _Line) -> None:
        """Read one line."""
        line.is_llvm = self._header is not None and "result" in self._header
        if self._header is None:
            self._header = _header(line)
        elif self._name is None and not self._blocks and line.accept("word", "input"):
            self._inputs.append((line.text(), line.name()))
        elif self._name is None and not self._blocks and line.accept("word", "param"):
            self._params.append(_param(line))
        elif self._name is None and not self._blocks and line.accept("word", "local"):
            self._locals.append(_local(line))
        elif self._name is None and not self._blocks and line.accept("word", "results"):
            self._results = _results(line)
        elif self._name is None:
            self._name = line.name()
            line.expect("mark", ":")
        else:
            self._in_block(line)
        line.end()

    def _in_block(self, line: _Line) -> None:
        id_ = line.result()
        if id_ is None:
            branch = _branch(line)
            name, phis, instrs = str(self._name), tuple(self._phis), tuple(self._instrs)
            self._blocks.append(Block(name, phis, instrs, branch))
            self._name, self._phis, self._instrs = None, [], []
            return
        kind = line.kind()
        line.expect("mark", "=")
        if not line.accept("word", "phi"):
            self._instrs.append(_instr(line, id_, kind))
        elif self._instrs:
            line.fail("phis come before instructions")
        else:
            incoming = line.listed(lambda: _incoming(line))
            self._phis.append(Phi(id_, kind, incoming, line.location()))

    def function(self, file: str) -> Function:
        """What was read, if it is whole."""
        if self._header is None:
            raise SSAError('the text is empty; it starts with `function "NAME"`', loc=file)
        if self._name is not None:
            raise SSAError(f"block {quoted(self._name)} has no end", loc=file)
        blocks, params = tuple(self._blocks), tuple(self._params)
        return Function(
            params=params,
            blocks=blocks,
            locals=tuple(self._locals),
            results=self._results,
            inputs=tuple(self._inputs),
            **self._header,
        )


def _header(line: _Line) -> dict[str, Any]:
    line.expect("word", "function")
    header: dict[str, Any] = {"name": line.text()}
    if line.accept("word", "file"):
        header["file"] = line.text()
    if line.accept("word", "returns"):
        header["returns"] = line.choice(_DTYPES, "a type")
    if line.accept("word", "llvm"):
        header["result"] = line.text()
        if not header["result"]:
            line.fail("LLVM's type of the result is missing")
    if line.accept("word", "sequential"):
        names = [line.name()]
        while line.accept("mark", ","):
            names.append(line.name())
        header["sequential"] = frozenset(names)
    return header


def _param(line: _Line) -> Param:
    name, dtype = line.text(), line.choice(_DTYPES, "a type")
    ndim = 0
    if line.accept("mark", "["):
        ndim = line.integer()
        if not 1 <= ndim <= MAX_NDIM:
            line.fail(f"an array of {ndim} dimensions, where 1 to {MAX_NDIM} are possible")
        line.expect("mark", "]")
    flat = line.accept("word", "flat") is not None
    words = line.integer() if line.accept("word", "words") else 1
    longest = line.integer() if line.accept("word", "longest") else 0
    known = line.listed(line.integer) if line.accept("word", "known") else ()
    if known and len(known) != (ndim or 1):
        line.fail(f"{len(known)} known numbers, where {ndim or 1} are possible")
    made: list[str | int] = []
    if line.accept("word", "made"):
        while not line.ended:
            made.append(_formula_part(line))
    return Param(name, dtype, ndim, flat, words, longest, known, tuple(made))


def _local(line: _Line) -> LocalArray:
    name = line.text()
    line.expect("word", "words")
    words = line.integer()
    contents = None
    if line.accept("word", "contents"):
        contents = tuple(line.integer() for _ in range(words))
    size: list[str | int] = []
    loops: list[SourceLoc] = []
    has_loops = line.accept("word", "loops")
    if not has_loops and line.accept("word", "size"):
        while not line.ended and not (has_loops := line.accept("word", "loops")):
            size.append(_formula_part(line))
    while has_loops and not line.ended:
        loops.append(_place(line))
    return LocalArray(name, words, contents, tuple(size), tuple(loops))


def _results(line: _Line) -> Results:
    try:
        found = Results.from_text(line.text())
    except (ValueError, TypeError, KeyError, AttributeError):
        line.fail("no description of results")
    if not found.is_sound:
        line.fail("the form of the results is none of their leaves")
    return found


def _formula_part(line: _Line) -> str | int:
    text = line.accept("string")
    return line.integer() if text is None else line.string(text)


def _place(line: _Line) -> SourceLoc:
    line.expect("mark", "[")
    file = line.text()
    line.expect("mark", ",")
    at = SourceLoc(file, line.integer())
    line.expect("mark", "]")
    return at


def _incoming(line: _Line) -> tuple[str, Value]:
    name = line.name()
    line.expect("mark", ":")
    return name, line.value()


def _instr(line: _Line, id_: int, kind: Kind) -> Instr:
    op = line.name() if line.is_llvm else line.choice(_OPCODES, "an operation")
    fields: dict[str, Any] = {"operands": line.values()}
    while not line.ended:
        clause = line.expect("word")
        if clause not in _CLAUSES or clause in fields:
            line.fail(f"{quoted(clause, 30)} is not a clause allowed here")
        fields[clause] = _CLAUSES[clause](line)
    return Instr(id_, op, kind, loc=line.location(), **fields)


def _lane(line: _Line) -> Lane:
    thread, origin, part = (line.integer() for _ in range(3))
    return Lane(thread, origin, part, line.listed(line.name))


def _axis(line: _Line) -> int | None:
    return None if line.accept("word", "_") else line.integer()


_CLAUSES: Final[dict[str, Callable[[_Line], object]]] = {
    "array": lambda line: line.text(),
    "shift": lambda line: line.integer(),
    "offset": lambda line: line.integer(),
    "width": lambda line: line.integer(),
    "signed": lambda line: True,
    "exact": lambda line: True,
    "distinct": lambda line: line.name(),
    "subscript": lambda line: line.listed(lambda: _axis(line)),
    "pred": lambda line: line.name(),
    "source": lambda line: line.name(),
    "strides": lambda line: line.listed(line.integer),
    "flags": lambda line: frozenset(line.listed(line.name)),
    "lane": _lane,
}


def _branch(line: _Line) -> Branch:
    if line.accept("word", "jump"):
        return Branch(line.name(), loc=line.location())
    if line.accept("word", "unreachable"):
        return Branch(unreachable=True, loc=line.location())
    if line.accept("word", "branch"):
        cond, target = line.value(), line.name()
        line.expect("word", "else")
        return Branch(target, cond, line.name(), loc=line.location())
    line.expect("word", "return")
    values = (*line.values(), None, None)
    return Branch(value=values[0], high=values[1], loc=line.location())

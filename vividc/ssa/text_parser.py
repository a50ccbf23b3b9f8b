"""The parser of a function's text form (see `vividc.ssa.text` for the language)."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import Any, Final, NoReturn

from vividc.errors import SourceLoc, SSAError, quoted
from vividc.host.inputs import demand_few_parts
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, LocalArray, Param
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref, Undefined, Value

PLAIN: Final = re.compile(r"[A-Za-z_][\w.]*")
"""A block's name that needs no quotes."""

_TOKEN: Final = re.compile(
    r"""\s*(?:(?P<loc>!.*)
    |(?P<string>"[^"\\]*+(?:\\.[^"\\]*+)*+")
    |(?P<ref>%-?\d+)
    |(?P<number>0x[0-9a-fA-F]+|-?\d+)
    |(?P<word>[A-Za-z_][\w.]*)
    |(?P<mark>[=,:$\[\]]))""",
    re.VERBOSE,
)
_LOC: Final = re.compile(r'!(?P<file>"[^"\\]*+(?:\\.[^"\\]*+)*+"|.*):(?P<line>\d+)\s*\Z')
_OPCODES: Final = {op.value: op for op in Opcode}
_TYPES: Final = {kind.value: kind for kind in Type}
_DTYPES: Final = {kind.value: kind for kind in DType}
_WORD: Final = 1 << 32
_DIGITS: Final = 20
"""No number has more."""


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
            reader.line(_Line(SourceLoc(file, number), source))
    return reader.function(file)


class _Line:
    """Tokens of a line, taken one after the other."""

    def __init__(self, loc: SourceLoc, text: str) -> None:
        self.loc = loc
        self._tokens: list[tuple[str, str]] = []
        self._at = place = 0
        while text[place:].strip():
            match = _TOKEN.match(text, place)
            if match is None:
                self.fail(f"{quoted(text[place:].strip(), 20)} is nothing that can stand here")
            kind = str(match.lastgroup)
            self._tokens.append((kind, match[kind]))
            place = match.end()

    def fail(self, what: str) -> NoReturn:
        """Refuse the line."""
        raise SSAError(what, loc=self.loc)

    @property
    def ended(self) -> bool:
        """All tokens are taken, but for the source line."""
        return self._at == len(self._tokens) or self._tokens[self._at][0] == "loc"

    def accept(self, kind: str, text: str | None = None) -> str | None:
        """The next token if it is of this kind, and this one if a text is given."""
        if self._at < len(self._tokens):
            found, value = self._tokens[self._at]
            if found == kind and text in (None, value):
                self._at += 1
                return value
        return None

    def take(self, kind: str, what: str, text: str | None = None) -> str:
        """The next token, which must be of this kind."""
        value = self.accept(kind, text)
        if value is None:
            here = "the end" if self.ended else quoted(self._tokens[self._at][1], 30)
            self.fail(f"{what} is expected, and there is {here}")
        return value

    def number(self, what: str) -> int:
        """An integer."""
        digits = self.take("number", what)
        if len(digits) > _DIGITS:
            self.fail(f"{what} has too many digits")
        return int(digits, 0)

    def string(self, what: str) -> str:
        """A text in quotes."""
        return self.unquoted(self.take("string", what))

    def unquoted(self, text: str) -> str:
        """What a text in quotes stands for."""
        try:
            return str(json.loads(text))
        except ValueError:
            self.fail(f"{quoted(text, 30)} is no text in quotes as JSON has them")

    def name(self, what: str) -> str:
        """A block's name, in quotes or without."""
        plain = self.accept("word")
        return self.string(what) if plain is None else plain

    def choice(self, table: dict[str, Any], what: str) -> Any:
        """One of the table's words."""
        word = self.take("word", what)
        if word not in table:
            self.fail(f"{what} is expected, and there is {quoted(word, 30)}")
        return table[word]

    def listed(self, one: Callable[[], Any]) -> tuple[Any, ...]:
        """What stands between brackets, with commas between."""
        self.take("mark", "`[`", "[")
        if self.accept("mark", "]"):
            return ()
        items = [one()]
        while self.accept("mark", ","):
            items.append(one())
        self.take("mark", "`]`", "]")
        return tuple(items)

    def value(self) -> Value:
        """An operand."""
        ref = self.accept("ref")
        if ref is not None:
            return Ref(self._id(ref))
        if self.accept("mark", "$"):
            return Input(self.string("an input's key"))
        if self.accept("word", "undef"):
            return Undefined()
        word = self.number("a value")
        if not 0 <= word < _WORD:
            self.fail(f"{word} is no word of 32 bits")
        return Const(word)

    def values(self) -> tuple[Value, ...]:
        """Operands up to the first clause."""
        kind, text = ("loc", "") if self.ended else self._tokens[self._at]
        if kind == "loc" or (kind == "word" and text != "undef"):
            return ()
        found = [self.value()]
        while self.accept("mark", ","):
            found.append(self.value())
        return tuple(found)

    def result(self) -> int | None:
        """The id of what the line defines, if it defines anything."""
        ref = self.accept("ref")
        return None if ref is None else self._id(ref)

    def _id(self, ref: str) -> int:
        if len(ref) > _DIGITS:
            self.fail("an id has too many digits")
        return int(ref[1:])

    def source(self) -> SourceLoc | None:
        """The source line at the end."""
        text = self.accept("loc")
        if text is None:
            return None
        match = _LOC.match(text)
        if match is None or len(match["line"]) > _DIGITS:
            self.fail("a source line is written !FILE:LINE")
        file = match["file"]
        return SourceLoc(self.unquoted(file) if file.startswith('"') else file, int(match["line"]))

    def finish(self) -> None:
        """Nothing may be left."""
        if self._at != len(self._tokens):
            self.fail(f"{quoted(self._tokens[self._at][1], 30)} is not expected here")


class _Reader:
    """What has been read so far."""

    def __init__(self) -> None:
        self._header: dict[str, Any] | None = None
        self._params: list[Param] = []
        self._locals: list[LocalArray] = []
        self._blocks: list[Block] = []
        self._name: str | None = None
        self._phis: list[Phi] = []
        self._instrs: list[Instr] = []

    def line(self, line: _Line) -> None:
        """Read one line."""
        if self._header is None:
            self._header = _header(line)
        elif self._name is None and not self._blocks and line.accept("word", "param"):
            self._params.append(_param(line))
        elif self._name is None and not self._blocks and line.accept("word", "local"):
            self._locals.append(_local(line))
        elif self._name is None:
            self._name = line.name("a block's name")
            line.take("mark", "`:`", ":")
        else:
            self._in_block(line)
        line.finish()

    def _in_block(self, line: _Line) -> None:
        id_ = line.result()
        if id_ is None:
            branch = _branch(line)
            name, phis, instrs = str(self._name), tuple(self._phis), tuple(self._instrs)
            self._blocks.append(Block(name, phis, instrs, branch))
            self._name, self._phis, self._instrs = None, [], []
            return
        kind = line.choice(_TYPES, "a type")
        line.take("mark", "`=`", "=")
        if not line.accept("word", "phi"):
            self._instrs.append(_instr(line, id_, kind))
        elif self._instrs:
            line.fail("phis come before instructions")
        else:
            incoming = line.listed(lambda: _incoming(line))
            self._phis.append(Phi(id_, kind, incoming, line.source()))

    def function(self, file: str) -> Function:
        """What was read, if it is whole."""
        if self._header is None:
            raise SSAError('the text is empty; it starts with `function "NAME"`', loc=file)
        if self._name is not None:
            raise SSAError(f"block {quoted(self._name)} has no end", loc=file)
        blocks, params = tuple(self._blocks), tuple(self._params)
        return Function(params=params, blocks=blocks, locals=tuple(self._locals), **self._header)


def _header(line: _Line) -> dict[str, Any]:
    line.take("word", '`function "NAME"`', "function")
    header: dict[str, Any] = {"name": line.string("the function's name")}
    if line.accept("word", "file"):
        header["file"] = line.string("the file's name")
    if line.accept("word", "returns"):
        header["returns"] = line.choice(_DTYPES, "a type")
    if line.accept("word", "sequential"):
        names = [line.name("a block's name")]
        while line.accept("mark", ","):
            names.append(line.name("a block's name"))
        header["sequential"] = frozenset(names)
    return header


def _param(line: _Line) -> Param:
    name, dtype = line.string("a parameter's name"), line.choice(_DTYPES, "a type")
    ndim = 0
    if line.accept("mark", "["):
        ndim = line.number("how many dimensions")
        line.take("mark", "`]`", "]")
    flat = line.accept("word", "flat") is not None
    words = line.number("how many words") if line.accept("word", "words") else 1
    longest = line.number("how many elements") if line.accept("word", "longest") else 0
    return Param(name, dtype, ndim, flat, words, longest)


def _local(line: _Line) -> LocalArray:
    name = line.string("an array's name")
    line.take("word", "`words`", "words")
    words = line.number("how many words")
    contents = None
    if line.accept("word", "contents"):
        contents = tuple(line.number("a word") for _ in range(words))
    size: list[str | int] = []
    loops: list[SourceLoc] = []
    has_loops = line.accept("word", "loops")
    if not has_loops and line.accept("word", "size"):
        while not line.ended and not (has_loops := line.accept("word", "loops")):
            size.append(_formula_part(line))
    while has_loops and not line.ended:
        loops.append(_place(line))
    return LocalArray(name, words, contents, tuple(size), tuple(loops))


def _formula_part(line: _Line) -> str | int:
    text = line.accept("string")
    return line.number("a part of a formula") if text is None else line.unquoted(text)


def _place(line: _Line) -> SourceLoc:
    line.take("mark", "`[`", "[")
    file = line.string("a file's name")
    line.take("mark", "`,`", ",")
    at = SourceLoc(file, line.number("a line"))
    line.take("mark", "`]`", "]")
    return at


def _incoming(line: _Line) -> tuple[str, Value]:
    name = line.name("a block's name")
    line.take("mark", "`:`", ":")
    return name, line.value()


def _instr(line: _Line, id_: int, kind: Type) -> Instr:
    op = line.choice(_OPCODES, "an operation")
    fields: dict[str, Any] = {"operands": line.values()}
    while not line.ended:
        clause = line.take("word", "a clause")
        if clause not in _CLAUSES or clause in fields:
            line.fail(f"{quoted(clause, 30)} is no clause that can stand here")
        fields[clause] = _CLAUSES[clause](line)
    return Instr(id_, op, kind, loc=line.source(), **fields)


def _lane(line: _Line) -> Lane:
    thread, origin, part = (line.number("a number of the lane") for _ in range(3))
    return Lane(thread, origin, part, line.listed(lambda: line.name("a block's name")))


def _axis(line: _Line) -> int | None:
    return None if line.accept("word", "_") else line.number("a subscript")


_CLAUSES: Final[dict[str, Callable[[_Line], object]]] = {
    "array": lambda line: line.string("an array's name"),
    "shift": lambda line: line.number("a shift"),
    "offset": lambda line: line.number("an offset"),
    "width": lambda line: line.number("a width"),
    "signed": lambda line: True,
    "exact": lambda line: True,
    "distinct": lambda line: line.name("a block's name"),
    "subscript": lambda line: line.listed(lambda: _axis(line)),
    "lane": _lane,
}


def _branch(line: _Line) -> Branch:
    if line.accept("word", "jump"):
        return Branch(line.name("a block's name"), loc=line.source())
    if line.accept("word", "branch"):
        cond, target = line.value(), line.name("a block's name")
        line.take("word", "`else`", "else")
        return Branch(target, cond, line.name("a block's name"), loc=line.source())
    line.take("word", "`jump`, `branch`, `return` or a result", "return")
    values = (*line.values(), None, None)
    return Branch(value=values[0], high=values[1], loc=line.source())

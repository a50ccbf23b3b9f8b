"""Read the text of LLVM IR into `ssa.Function`: as much of the language as kernels use."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from vividc.errors import InternalError, SourceLoc
from vividc.frontend.llvm.aggregates import split_aggregates
from vividc.frontend.llvm.calls import PITCH
from vividc.frontend.llvm.layout import offsets, part_type, structs_of
from vividc.frontend.llvm.metadata import Locations
from vividc.frontend.llvm.subscripts import Subscripts
from vividc.frontend.llvm.tokens import Cursor, Names, Structs, bare
from vividc.ssa.ir import (
    LLVM_BINARY,
    LLVM_CASTS,
    Block,
    Branch,
    Function,
    Instr,
    Phi,
    Value,
    pitch_of,
)

_DEFINE = re.compile(r'^define .*?(?P<name>@(?:"[^"]*"|[-\w.$]+))\(', re.MULTILINE)
_LABEL = re.compile(r'^(?P<name>"[^"]*"|[-\w.$]+):')
_PITCH = re.compile(rf'^\s*(%\S+) = .*call .*(@"{re.escape(PITCH)}[^"]*")\(\)')


def read_function(text: str, name: str, file: str) -> Function:
    """Read one function of a module.

    Parameters
    ----------
    text
        The module, as LLVM prints it.
    name
        The function's name.
    file
        The user's source file: lines in it take precedence.

    Raises
    ------
    InternalError
        The text holds a construct that is not known here.
    """
    start, end = _function_span(text, name)
    header, *lines = text[start:end].split("\n")
    params, returns = signature(header)
    pitches = dict(_pitches(lines))
    lines = [line for line in lines if not _PITCH.match(line)]
    locations = Locations(text, file)
    structs = structs_of(text)
    inputs = {name: name for name, _ in params} | pitches
    reader = _Lines(locations, structs, Subscripts(text), Names(inputs))
    blocks = tuple(reader.blocks(lines))
    params += tuple((key, "i32") for key in dict.fromkeys(pitches.values()))
    return split_aggregates(Function(name, (), blocks, inputs=params, result=returns), structs)


def _pitches(lines: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Local names of pitches, and their keys as inputs."""
    for line in lines:
        match = _PITCH.match(line)
        if match is not None:
            array, _, axis = bare(match[2]).removeprefix(PITCH).rpartition(".")
            yield bare(match[1]), pitch_of(array, int(axis)).key


def _function_span(text: str, name: str) -> tuple[int, int]:
    for match in _DEFINE.finditer(text):
        if bare(match["name"]) == name:
            return match.start(), text.index("\n}", match.start())
    raise InternalError(f"LLVM lost the function {name}")


def signature(header: str) -> tuple[tuple[tuple[str, str], ...], str]:
    """Names and types of the parameters of a `define` line, and the type that it returns."""
    cursor, returns = Cursor(header), ""
    while cursor.peek[:1] != "@":
        returns = cursor.type()
        if cursor.peek == "(":
            cursor.skip_parentheses()
    cursor.take()
    cursor.expect("(")
    return tuple(_params(cursor)), returns


def _params(cursor: Cursor) -> Iterator[tuple[str, str]]:
    while not cursor.accept(")"):
        if cursor.accept("..."):
            continue
        type_ = cursor.type()
        while cursor.peek[:1] != "%":
            cursor.take()
            cursor.skip_parentheses()
        yield bare(cursor.take()), type_
        cursor.accept(",")


@dataclass(frozen=True, slots=True)
class _Lines:
    """What the lines of a function are read with."""

    locations: Locations
    structs: Structs
    subscripts: Subscripts
    names: Names

    def blocks(self, lines: list[str]) -> Iterator[Block]:
        """The function's blocks in order."""
        name = ""
        phis: list[Phi] = []
        instrs: list[Instr] = []
        for line in joined(lines):
            label = label_of(line)
            if label:
                name = label
                continue
            stripped = line.strip()
            if not stripped or stripped.startswith((";", "#dbg")):
                continue
            item = self._instruction(stripped)
            if isinstance(item, Phi):
                phis.append(item)
            elif isinstance(item, Instr):
                instrs.append(item)
            else:
                yield Block(name, tuple(phis), tuple(instrs), item)
                phis, instrs = [], []

    def _instruction(self, line: str) -> Instr | Phi | Branch:
        cursor = Cursor(line, self.structs, self.names)
        name = ""
        if cursor.peek[:1] == "%":
            name = bare(cursor.take())
            cursor.expect("=")
        cursor.skip_flags()
        opcode = cursor.take()
        flags = cursor.skip_flags()
        reader = _READERS.get(opcode, _read_other)
        item = reader(cursor, self.names.result(name), opcode, self.locations(line))
        if not isinstance(item, Instr):
            return item
        return replace(item, flags=flags, subscript=self.subscripts(line))


def label_of(line: str) -> str:
    """The block that a line begins, else ""."""
    label = _LABEL.match(line)
    return bare("%" + label["name"]) if label is not None else ""


def joined(lines: list[str]) -> Iterator[str]:
    """A switch is printed over several lines; all else on one."""
    pending = ""
    for line in lines:
        pending += line
        if pending.rstrip().endswith("[") or (
            pending.count("[") > pending.count("]") and "switch" in pending
        ):
            continue
        yield pending
        pending = ""


def _read_phi(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Phi:
    type_ = cursor.type()
    incoming: list[tuple[str, Value]] = []
    while cursor.accept("["):
        value = cursor.operand(type_)
        cursor.expect(",")
        incoming.append((bare(cursor.take()), value))
        cursor.expect("]")
        if not cursor.accept(","):
            break
    # A predecessor with two edges is listed twice.
    return Phi(id_, type_, tuple(dict.fromkeys(incoming)), loc)


def _read_br(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Branch:
    if cursor.accept("label"):
        return Branch(bare(cursor.take()), loc=loc)
    _, cond = cursor.typed_operand()
    targets = []
    while cursor.accept(","):
        if not cursor.accept("label"):
            break
        targets.append(bare(cursor.take()))
    if targets[0] == targets[1]:
        return Branch(targets[0], loc=loc)
    return Branch(targets[0], cond, targets[1], loc=loc)


def _read_ret(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Branch:
    if cursor.peek == "void":
        return Branch(loc=loc)
    return Branch(value=cursor.typed_operand()[1], loc=loc)


def _read_unreachable(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Branch:
    return Branch(unreachable=True, loc=loc)


def _read_compare(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    pred = cursor.take()
    type_, left = cursor.typed_operand()
    cursor.expect(",")
    return Instr(id_, opcode, type_, (left, cursor.operand(type_)), pred=pred, loc=loc)


def _read_select(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    _, cond = cursor.typed_operand()
    cursor.expect(",")
    type_, left = cursor.typed_operand()
    cursor.expect(",")
    _, right = cursor.typed_operand()
    return Instr(id_, opcode, type_, (cond, left, right), loc=loc)


def _read_cast(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    source, value = cursor.typed_operand()
    cursor.expect("to")
    return Instr(id_, opcode, cursor.type(), (value,), source=source, loc=loc)


def _read_load(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    type_ = cursor.type()
    cursor.expect(",")
    return Instr(id_, opcode, type_, (cursor.typed_operand()[1],), loc=loc)


def _read_store(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    type_, value = cursor.typed_operand()
    cursor.expect(",")
    return Instr(id_, opcode, type_, (value, cursor.typed_operand()[1]), loc=loc)


def _read_gep(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    element, args = cursor.address()
    scaled = offsets(element, args[1:], cursor.structs)
    indices, strides = scaled or (args[1:], ())
    operands = (args[0], *indices)
    return Instr(id_, opcode, "ptr", operands, source=element, strides=strides, loc=loc)


def _read_call(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    type_ = cursor.type()
    while cursor.peek[:1] not in ("@", "%", ""):
        type_ = cursor.type()
        cursor.skip_parentheses()
    callee = cursor.take()
    args: list[Value] = []
    cursor.expect("(")
    while not cursor.accept(")"):
        args.append(cursor.typed_operand()[1])
        cursor.accept(",")
    return Instr(id_, "call", type_, tuple(args), pred=bare(callee), loc=loc)


def _read_part(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    """`extractvalue` and `insertvalue`, with constant indices."""
    type_, whole = cursor.typed_operand()
    args, source = [whole], type_
    if opcode == "insertvalue":
        cursor.expect(",")
        source, value = cursor.typed_operand()
        args.append(value)
    indices: list[int] = []
    while cursor.accept(",") and cursor.peek[:1] != "!":
        indices.append(int(cursor.take()))
    if opcode == "extractvalue":
        type_ = part_type(type_, tuple(indices), cursor.structs)
    return Instr(id_, opcode, type_, tuple(args), source=source, strides=tuple(indices), loc=loc)


def _read_other(cursor: Cursor, id_: int, opcode: str, loc: SourceLoc | None) -> Instr:
    """Arithmetic: `op type a[, b]`. What the kernel may not use is refused later, by opcode, with
    its line.
    """
    type_ = cursor.type()
    args: list[Value] = []
    if opcode in ARITHMETIC:
        args.append(cursor.operand(type_))
        while cursor.accept(",") and cursor.peek[:1] != "!":
            args.append(cursor.operand(type_))
    return Instr(id_, opcode, type_, tuple(args), loc=loc)


ARITHMETIC = LLVM_BINARY | {"fneg", "freeze"}
_Item = Instr | Phi | Branch
_Reader = Callable[[Cursor, int, str, SourceLoc | None], _Item]
_READERS: dict[str, _Reader] = {
    "phi": _read_phi,
    "br": _read_br,
    "ret": _read_ret,
    "unreachable": _read_unreachable,
    "icmp": _read_compare,
    "fcmp": _read_compare,
    "select": _read_select,
    "load": _read_load,
    "store": _read_store,
    "getelementptr": _read_gep,
    "call": _read_call,
    "extractvalue": _read_part,
    "insertvalue": _read_part,
    **dict.fromkeys(LLVM_CASTS, _read_cast),
}

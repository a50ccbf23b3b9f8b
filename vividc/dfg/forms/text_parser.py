"""The parser of a DFG's text form (see `vividc.dfg.forms.text` for the language)."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from typing import Final, NoReturn

from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.errors import DFGError, SourceLoc, quoted
from vividc.host.inputs import demand_few_parts
from vividc.machine.opcodes import BASE, ORDER, PRED, Opcode

_TOKEN: Final = re.compile(
    r"""\s*(?:(?P<loc>!.*)
    |(?P<string>"[^"\\]*+(?:\\.[^"\\]*+)*+")
    |(?P<ref>%-?\d+)
    |(?P<number>0x[0-9a-fA-F]+|-?\d+)
    |(?P<word>[A-Za-z_][\w.]*)
    |(?P<mark>[=@(),:]))""",
    re.VERBOSE,
)
_LOC: Final = re.compile(r'!(?P<file>"[^"\\]*+(?:\\.[^"\\]*+)*+"|.*):(?P<line>\d+)\s*\Z')
_OPCODES: Final = {op.value: op for op in Opcode}
_CONTROLS: Final = {mark.value: mark for mark in Control}


def parse(text: str, file: str = "<text>") -> DFG:
    """The graph that `to_text` printed.

    Parameters
    ----------
    text
        The text form.
    file
        Named in errors.

    Raises
    ------
    DFGError
        The text is malformed; file and line are named. Invariants are `check`'s, not the parser's.
    """
    demand_few_parts(text.count("\n"), "lines", file, DFGError)
    name: str | None = None
    nodes: list[Node] = []
    edges: list[Edge] = []
    order: list[int] | None = None
    for number, source in enumerate(text.split("\n"), start=1):
        if not source.strip() or source.lstrip().startswith("#"):
            continue
        line = _Line(SourceLoc(file, number), source)
        if name is None:
            name = line.header()
        elif order is not None:
            line.fail("nothing may follow the line `edges`")
        elif line.accept("word", "edges"):
            order = line.edge_order(len(edges))
        else:
            node, into = line.node()
            nodes.append(node)
            edges.extend(into)
    if name is None:
        raise DFGError('the text is empty; it starts with `dfg "NAME"`', loc=file)
    arranged = edges if order is None else [edges[place] for place in order]
    return DFG(name, tuple(nodes), tuple(arranged))


@dataclass(slots=True)
class _Clauses:
    """What may follow a node's operands."""

    edges: list[Edge] = field(default_factory=list)
    shift: int = 0
    offset: int = 0
    width: int = 4
    signed: bool = False
    control: Control | None = None
    unless_exit: bool = False


class _Line:
    """The tokens of one line, read from left to right."""

    def __init__(self, loc: SourceLoc, source: str) -> None:
        self.loc = loc
        self.tokens: list[tuple[str, str]] = []
        self.next = 0
        at = 0
        source = source.rstrip()
        while at < len(source):
            match = _TOKEN.match(source, at)
            if match is None or match.lastgroup is None:
                self.fail(f"cannot read {quoted(source[at:].strip())}")
            self.tokens.append((match.lastgroup, match[match.lastgroup]))
            at = match.end()

    def fail(self, reason: str) -> NoReturn:
        """Raise the error of this line."""
        raise DFGError(reason, loc=self.loc)

    def peek(self) -> tuple[str, str]:
        """Kind and text of the next token; kind "end" behind the last."""
        return (
            self.tokens[self.next] if self.next < len(self.tokens) else ("end", "the end of line")
        )

    def accept(self, kind: str, text: str | None = None) -> str | None:
        """The next token if it is the given one."""
        found, value = self.peek()
        if found != kind or (text is not None and value != text):
            return None
        self.next += 1
        return value

    def expect(self, kind: str, text: str | None = None) -> str:
        """The next token, which must be the given one."""
        value = self.accept(kind, text)
        if value is None:
            self.fail(f"expected {text or _KINDS[kind]}, found {self.peek()[1]}")
        return value

    def header(self) -> str:
        """`dfg "NAME"`."""
        self.expect("word", "dfg")
        name = self.string(self.expect("string"))
        self.end()
        return name

    def edge_order(self, count: int) -> list[int]:
        """`edges 2 0 1`, the word `edges` read."""
        order: list[int] = []
        while (number := self.accept("number")) is not None:
            order.append(self.whole(number))
        self.end()
        if sorted(order) != list(range(count)):
            self.fail(f"`edges` must list each of 0 .. {count - 1} once")
        return order

    def node(self) -> tuple[Node, list[Edge]]:
        """A node and the edges that enter it."""
        node_id = self.whole(self.expect("ref")[1:])
        self.expect("mark", "=")
        op = self.opcode()
        quoted = self.accept("string")
        const = self.integer() if op is Opcode.CONST else None
        edges = self.operands(node_id)
        clauses = _Clauses()
        while (word := self.accept("word")) is not None:
            self.clause(word, node_id, clauses)
        loc = self.location()
        self.end()
        node = Node(
            id=node_id,
            op=op,
            const=const,
            name=self.string(quoted) if quoted is not None else "",
            shift=clauses.shift,
            offset=clauses.offset,
            width=clauses.width,
            signed=clauses.signed,
            control=clauses.control,
            unless_exit=clauses.unless_exit,
            loc=loc,
        )
        return node, edges + clauses.edges

    def opcode(self) -> Opcode:
        """The name of an operation."""
        word = self.expect("word")
        if word not in _OPCODES:
            self.fail(f"there is no operation {word}")
        return _OPCODES[word]

    def operands(self, dst: int) -> list[Edge]:
        """`%1, %2@1(init=%0), 5: %3`, possibly none."""
        edges: list[Edge] = []
        port = 0
        while self.peek()[0] in {"ref", "number"}:
            if self.peek()[0] == "number":
                port = self.integer()
                self.expect("mark", ":")
            edges.append(self.edge(dst, port))
            port += 1
            if self.accept("mark", ",") is None:
                return edges
        if edges:
            self.fail("an operand must follow the comma")
        return edges

    def clause(self, word: str, dst: int, clauses: _Clauses) -> None:
        """One clause, its first word read."""
        if word in _NUMBER_CLAUSES:
            setattr(clauses, word, self.integer())
        elif word in _FLAG_CLAUSES:
            setattr(clauses, word, True)
        elif word in _CONTROLS:
            if clauses.control is not None:
                self.fail(f"the node is already marked {clauses.control.value}")
            clauses.control = _CONTROLS[word]
        elif word in _EDGE_CLAUSES:
            port, kind = _EDGE_CLAUSES[word]
            clauses.edges.append(self.edge(dst, port, kind))
            while self.accept("mark", ",") is not None:
                clauses.edges.append(self.edge(dst, port, kind))
        else:
            self.fail(f"there is no clause {word}")

    def edge(self, dst: int, port: int, kind: EdgeKind = EdgeKind.DATA) -> Edge:
        """`%3`, `%3@1` or `%3@1(init=%0)`."""
        src = self.whole(self.expect("ref")[1:])
        distance = self.integer() if self.accept("mark", "@") is not None else 0
        init: int | None = None
        if self.accept("mark", "(") is not None:
            self.expect("word", "init")
            self.expect("mark", "=")
            init = self.whole(self.expect("ref")[1:])
            self.expect("mark", ")")
        return Edge(src, dst, port, distance, init, kind)

    def integer(self) -> int:
        """A decimal or hexadecimal integer."""
        return self.whole(self.expect("number"))

    def whole(self, text: str) -> int:
        """The integer of a text; Python reads none of thousands of digits."""
        try:
            return int(text, 16 if text.startswith("0x") else 10)
        except ValueError:
            self.fail(f"a number of {len(text)} digits")

    def string(self, quoted: str) -> str:
        """The value of a string in JSON's notation."""
        try:
            value = json.loads(quoted)
        except json.JSONDecodeError:
            self.fail(f"{quoted} is no string")
        return str(value)

    def location(self) -> SourceLoc | None:
        """`!file:line`, if it is there."""
        text = self.accept("loc")
        if text is None:
            return None
        match = _LOC.fullmatch(text)
        if match is None:
            self.fail(f"{text} is no source line: write !file:line")
        file = match["file"]
        return SourceLoc(
            self.string(file) if file.startswith('"') else file, self.whole(match["line"])
        )

    def end(self) -> None:
        """Nothing may be left."""
        if self.peek()[0] != "end":
            self.fail(f"unexpected {self.peek()[1]}")


_KINDS: Final = {
    "ref": "a node like %3",
    "number": "a number",
    "string": "a name in quotes",
    "word": "a word",
    "mark": "a mark",
    "loc": "a source line",
}
_NUMBER_CLAUSES: Final = frozenset({"shift", "offset", "width"})
_FLAG_CLAUSES: Final = frozenset({"signed", "unless_exit"})
_EDGE_CLAUSES: Final = {
    "if": (PRED, EdgeKind.DATA),
    "base": (BASE, EdgeKind.DATA),
    "after": (ORDER, EdgeKind.ORDER),
    "control": (ORDER, EdgeKind.CONTROL),
}

"""The parser of a DFG's text form (see `vividc.dfg.forms.text` for the language)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.errors import DFGError, SourceLoc
from vividc.host.inputs import demand_few_parts
from vividc.machine.opcodes import BASE, ORDER, PRED, Opcode
from vividc.machine.text_line import TextLine

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
        line = _Line(SourceLoc(file, number), source, DFGError)
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


class _Line(TextLine):
    """The tokens of one line, read from left to right."""

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


_NUMBER_CLAUSES: Final = frozenset({"shift", "offset", "width"})
_FLAG_CLAUSES: Final = frozenset({"signed", "unless_exit"})
_EDGE_CLAUSES: Final = {
    "if": (PRED, EdgeKind.DATA),
    "base": (BASE, EdgeKind.DATA),
    "after": (ORDER, EdgeKind.ORDER),
    "control": (ORDER, EdgeKind.CONTROL),
}

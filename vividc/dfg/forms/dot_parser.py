"""A parser for the subset of DOT that dataflow graphs are published in.

Understood: one ``[strict] digraph [name] { ... }`` with node statements, edge statements and chains
(``a -> b -> c``), attribute lists, default attributes (``node [...]``, ``edge [...]``; those of
``graph`` are the graph's own), ``name=value``, subgraphs (their braces only: grouping has no
meaning here), quoted strings, bare words, numbers, and comments. A port behind a node (``a:out:n``)
is read over. Refused: undirected graphs, HTML labels, and edges from or to a subgraph.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final, NoReturn

from vividc.errors import DFGError, printable
from vividc.host.inputs import demand_few_parts

_TOKEN: Final = re.compile(
    r"""(?P<space>\s+|//[^\n]*|\#[^\n]*|/\*.*?\*/)
    |(?P<arrow>->)
    |(?P<line>--)
    |(?P<mark>[{}\[\]=;,:])
    |"(?P<string>[^"\\]*+(?:\\.[^"\\]*+)*+)"
    |(?P<word>-?(?:\.\d+|\d+(?:\.\d*)?)|[A-Za-z_\x80-\U0010FFFF][\w\x80-\U0010FFFF.]*)""",
    re.VERBOSE | re.DOTALL,
)
_ESCAPE: Final = re.compile(r"\\(.)", re.DOTALL)
_CHECKED: Final = 1 << 12
_KEYWORDS: Final = frozenset({"graph", "node", "edge"})


@dataclass(frozen=True, slots=True)
class DotNode:
    """A node with all its attributes, defaults included, and the line of its first mention."""

    name: str
    attributes: dict[str, str]
    line: int


@dataclass(frozen=True, slots=True)
class DotEdge:
    """An edge with its attributes, defaults included."""

    src: str
    dst: str
    attributes: dict[str, str]
    line: int


@dataclass(slots=True)
class DotGraph:
    """What a DOT text says; nodes in the order of their first mention."""

    name: str
    attributes: dict[str, str] = field(default_factory=dict)
    by_name: dict[str, DotNode] = field(default_factory=dict)
    edges: list[DotEdge] = field(default_factory=list)

    @property
    def nodes(self) -> list[DotNode]:
        """All nodes."""
        return list(self.by_name.values())


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    line: int


def parse_graph(text: str, file: str) -> DotGraph:
    """The graph of a DOT text.

    Raises
    ------
    DFGError
        The text leaves the subset; file and line are named.
    """
    return _Parser(text, file).graph()


def _tokens(text: str, file: str) -> list[_Token]:
    tokens: list[_Token] = []
    at, line = 0, 1
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None or match.lastgroup is None:
            what = "HTML labels are" if text[at] == "<" else f"{text[at]!r} is"
            raise DFGError(f"{what} not understood in DOT", loc=f"{file}:{line}")
        if match.lastgroup != "space":
            tokens.append(_Token(match.lastgroup, match[match.lastgroup], line))
            if len(tokens) % _CHECKED == 0:
                demand_few_parts(len(tokens), "words and marks of DOT", file, DFGError)
        line += match[0].count("\n")
        at = match.end()
    tokens.append(_Token("end", "the end of the file", line))
    return tokens


class _Parser:
    def __init__(self, text: str, file: str) -> None:
        self.file = file
        self.tokens = _tokens(text, file)
        self.next = 0
        self.defaults: list[dict[str, dict[str, str]]] = [{"node": {}, "edge": {}}]

    def fail(self, reason: str) -> NoReturn:
        raise DFGError(reason, loc=f"{self.file}:{self.peek().line}")

    def peek(self) -> _Token:
        return self.tokens[self.next]

    def accept(self, kind: str, text: str | None = None) -> bool:
        token = self.peek()
        if token.kind != kind or (text is not None and token.text.lower() != text):
            return False
        self.next += 1
        return True

    def expect(self, kind: str, text: str) -> None:
        if not self.accept(kind, text):
            self.fail(f"expected {text}, found {printable(self.peek().text)}")

    def identifier(self) -> str:
        token = self.peek()
        if token.kind not in {"word", "string"}:
            self.fail(f"expected a name, found {printable(token.text)}")
        self.next += 1
        return token.text if token.kind == "word" else _unescaped(token.text)

    def graph(self) -> DotGraph:
        self.accept("word", "strict")
        if self.peek().text.lower() == "graph":
            self.fail("a dataflow graph is directed: write digraph")
        self.expect("word", "digraph")
        named = self.peek().kind in {"word", "string"}
        graph = DotGraph(self.identifier() if named else "")
        self.expect("mark", "{")
        self.statements(graph)
        if self.peek().kind != "end":
            self.fail("only one graph in a file is understood")
        return graph

    def statements(self, graph: DotGraph) -> None:
        depth = 1
        while depth:
            if self.accept("mark", ";"):
                continue
            if self.accept("mark", "}"):
                depth -= 1
                self.defaults.pop()
                if depth and self.peek().kind == "arrow":
                    self.fail("an edge from a subgraph is not understood")
            elif self.opens_subgraph():
                depth += 1
                outer = self.defaults[-1]
                self.defaults.append({kind: dict(of) for kind, of in outer.items()})
            else:
                self.statement(graph, outermost=depth == 1)

    def opens_subgraph(self) -> bool:
        if self.accept("word", "subgraph") and self.peek().kind != "mark":
            self.identifier()
        return self.accept("mark", "{")

    def statement(self, graph: DotGraph, *, outermost: bool) -> None:
        token = self.peek()
        if token.kind == "end":
            self.fail("the graph is not closed by }")
        keyword = token.text.lower()
        if token.kind == "word" and keyword in _KEYWORDS:
            self.next += 1
            own = graph.attributes if outermost else {}
            self.defaults[-1].get(keyword, own).update(self.attributes())
            return
        name = self.identifier()
        if self.accept("mark", "="):
            value = self.identifier()
            if outermost:
                graph.attributes[name] = value
            return
        self.node_or_chain(graph, name, token.line)

    def node_or_chain(self, graph: DotGraph, name: str, line: int) -> None:
        names = [name]
        self.skip_port()
        while self.accept("arrow"):
            if self.peek().text in {"{", "subgraph"}:
                self.fail("an edge to a subgraph is not understood")
            names.append(self.identifier())
            self.skip_port()
        attributes = self.attributes()
        defaults = self.defaults[-1]
        for each in names:
            graph.by_name.setdefault(each, DotNode(each, dict(defaults["node"]), line))
        if len(names) == 1:
            graph.by_name[name].attributes.update(attributes)
        for src, dst in pairwise(names):
            graph.edges.append(DotEdge(src, dst, {**defaults["edge"], **attributes}, line))

    def skip_port(self) -> None:
        while self.accept("mark", ":"):
            self.identifier()

    def attributes(self) -> dict[str, str]:
        given: dict[str, str] = {}
        while self.accept("mark", "["):
            while not self.accept("mark", "]"):
                key = self.identifier()
                given[key] = self.identifier() if self.accept("mark", "=") else "true"
                if not self.accept("mark", ","):
                    self.accept("mark", ";")
        return given


def _unescaped(text: str) -> str:
    return _ESCAPE.sub(lambda match: "\n" if match[1] in "nlr" else match[1], text)

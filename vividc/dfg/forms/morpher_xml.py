"""The XML that Morpher's DFG generator writes (`*_DFG.xml`; Wijerathne et al. 2022), read only.

A `<DFG>` holds a `<Node idx BB CONST>` per operation with `<OP>`, perhaps `<BasePointerName>` (the
array), and `<Outputs>` of `<Output idx nextiter type>`. `nextiter` is the distance; the type `P` is
the predicate, `I1`, `I2` and `I3` are the operands, and `PS` orders without carrying a value.
`<Inputs>` and `<RecParents>` say the same from the other side and are not read.

The files are no well-formed XML: attributes follow each other without a blank, and a second root
element (`<MutexBB>`) may stand before the graph. So the tags are read by a scanner of our own.
"""

from __future__ import annotations

import html
import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Final, NoReturn

from vividc.dfg.forms.json_form import from_json
from vividc.dfg.ir import DFG
from vividc.errors import DFGError, quoted
from vividc.host.inputs import demand_few_parts

_TOKEN: Final = re.compile(
    r"""<!--.*?-->|<\?.*?\?>|<!\w[^>]*>
    |<(?P<close>/)?(?P<tag>[A-Za-z_][\w.:-]*+)(?P<attributes>(?:[^<>"']|"[^"]*+"|'[^']*+')*+)>
    |(?P<text>[^<]+)""",
    re.VERBOSE | re.DOTALL,
)
"""Possessive, as in all of this package that reads foreign text: no part of it is tried twice."""
_ATTRIBUTE: Final = re.compile(r"""\s*([A-Za-z_][\w.:-]*)\s*=\s*(?:"([^"]*)"|'([^']*)')\s*""")
_OPERANDS: Final[dict[str, int | str]] = {"P": "pred", "I1": 0, "I2": 1, "I3": 2}
_ORDER: Final = "PS"
_INTEGER: Final = re.compile(r"-?[0-9]{1,18}")
_ENDING: Final = re.compile(r"(_PartPred|_FullPred)?_?DFG$")


@dataclass(frozen=True, slots=True)
class _Tag:
    """An opening tag (`closes` False), or a closing one; `text` stands behind it."""

    name: str
    attributes: dict[str, str]
    closes: bool
    empty: bool
    line: int
    text: str


@dataclass(slots=True)
class _Graph:
    nodes: list[dict[str, object]] = field(default_factory=list)
    edges: list[dict[str, object]] = field(default_factory=list)
    lines: dict[str, int] = field(default_factory=dict)

    def add(self, kind: str, entry: dict[str, object], line: int) -> None:
        entries = self.nodes if kind == "nodes" else self.edges
        self.lines[f"{kind}[{len(entries)}]"] = line
        entries.append(entry)


def parse_morpher_xml(text: str, file: str = "<xml>") -> DFG:
    """The graph in a Morpher DFG file; it is named after the file.

    Two operations with one index (the generator makes such) become one node, with a warning, and
    an operand may have several definitions: its merges come so.

    Raises
    ------
    DFGError
        A tag or attribute is missing or malformed (the line is named), or the graph is no DFG.
    """
    graph = _Graph()
    tags = list(_tags(text, file))
    if not any(tag.name == "DFG" and not tag.closes for tag in tags):
        raise DFGError(
            "the XML has no <DFG> element",
            loc=file,
            hint="Morpher's *_DFG.xml is the XML that is understood",
        )
    _read(tags, graph, file)
    data: dict[str, object] = {"name": _ENDING.sub("", PurePath(file).stem) or "dfg"}
    data |= {"source": "Morpher", "nodes": graph.nodes, "edges": graph.edges}
    return from_json(data, file=file, lines=graph.lines)


def _read(tags: list[_Tag], graph: _Graph, file: str) -> None:
    node: dict[str, object] | None = None
    inside = False
    for tag in tags:
        if tag.name == "DFG":
            inside = not tag.closes
            _check_count(tag, graph, file)
        elif inside and tag.name == "Node":
            _demand_operation(node, tag, file)
            node = None if tag.closes else _node(tag, file)
            if node is not None:
                graph.add("nodes", node, tag.line)
        elif inside and not tag.closes:
            _inner(tag, node, graph, file)
    if inside:
        _fail(file, tags[-1].line, "<DFG> is not closed: the file ends early")


def _inner(tag: _Tag, node: dict[str, object] | None, graph: _Graph, file: str) -> None:
    """A tag inside a node."""
    if node is None:
        _fail(file, tag.line, f"<{tag.name}> stands outside a <Node>")
    if tag.name == "OP":
        node["op"] = tag.text.strip()
    elif tag.name == "BasePointerName":
        node["array"] = tag.text.strip()
    elif tag.name == "Output":
        graph.add("edges", _edge(node["id"], tag, file), tag.line)


def _check_count(tag: _Tag, graph: _Graph, file: str) -> None:
    """The opening tag says how many nodes follow; a file cut short in the middle has fewer."""
    if not tag.closes:
        graph.lines["count"] = _integer(tag, "count", file) if "count" in tag.attributes else -1
    elif graph.lines.get("count", -1) not in (-1, len(graph.nodes)):
        count = graph.lines["count"]
        _fail(file, tag.line, f"<DFG> announces {count} nodes and holds {len(graph.nodes)}")


def _demand_operation(node: dict[str, object] | None, tag: _Tag, file: str) -> None:
    if node is not None and not tag.closes:
        _fail(file, tag.line, f"a <Node> begins inside node {node['id']}")
    if tag.closes and (node is None or not node.get("op")):
        what = "closes nothing" if node is None else f"has no <OP> (idx {node['id']})"
        _fail(file, tag.line, f"the <Node> {what}")


def _node(tag: _Tag, file: str) -> dict[str, object]:
    entry: dict[str, object] = {"id": _integer(tag, "idx", file)}
    if "CONST" in tag.attributes:
        entry["const"] = tag.attributes["CONST"]
    if tag.empty:
        _fail(file, tag.line, f"the <Node> has no <OP> (idx {entry['id']})")
    return entry


def _edge(src: object, tag: _Tag, file: str) -> dict[str, object]:
    distance = _integer(tag, "nextiter", file) if "nextiter" in tag.attributes else 0
    entry: dict[str, object] = {"src": src, "dst": _integer(tag, "idx", file), "distance": distance}
    kind = tag.attributes.get("type")
    if kind == _ORDER:
        return entry | {"kind": "order"}
    if kind is None:
        return entry
    if kind not in _OPERANDS:
        known = ", ".join([*_OPERANDS, _ORDER])
        _fail(file, tag.line, f"the type {quoted(kind, 40)} of an <Output> is none of {known}")
    return entry | {"operand": _OPERANDS[kind]}


def _integer(tag: _Tag, key: str, file: str) -> int:
    text = tag.attributes.get(key)
    if text is None:
        _fail(file, tag.line, f"<{tag.name}> has no {key}")
    if not _INTEGER.fullmatch(text.strip()):
        _fail(file, tag.line, f"{key} {quoted(text, 40)} of <{tag.name}> is no integer")
    return int(text)


def _tags(text: str, file: str) -> Iterator[_Tag]:
    demand_few_parts(text.count("<"), "tags of XML", file, DFGError)
    breaks = [match.start() for match in re.finditer("\n", text)]
    pending: _Tag | None = None
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            line = bisect_right(breaks, at) + 1
            _fail(file, line, f"no tag of XML: {text[at : at + 30]!r}")
        if match["tag"] is not None:
            if pending is not None:
                yield pending
            pending = _tag(match, bisect_right(breaks, at) + 1, file)
        elif match["text"] is not None and pending is not None:
            pending = _with_text(pending, html.unescape(match["text"]))
        at = match.end()
    if pending is not None:
        yield pending


def _tag(match: re.Match[str], line: int, file: str) -> _Tag:
    rest = match["attributes"]
    empty = rest.endswith("/")
    rest = rest.removesuffix("/")
    attributes: dict[str, str] = {}
    at, end = 0, len(rest.rstrip())
    while at < end:
        attribute = _ATTRIBUTE.match(rest, at)
        if attribute is None:
            odd = f"{rest[at : at + 30]!r}"
            _fail(file, line, f"an attribute of <{quoted(match['tag'])[1:-1]}> is malformed: {odd}")
        value = attribute[2] if attribute[2] is not None else attribute[3]
        attributes[attribute[1]] = html.unescape(value)
        at = attribute.end()
    return _Tag(match["tag"], attributes, match["close"] is not None, empty, line, "")


def _with_text(tag: _Tag, text: str) -> _Tag:
    return _Tag(tag.name, tag.attributes, tag.closes, tag.empty, tag.line, tag.text + text)


def _fail(file: str, line: int, reason: str) -> NoReturn:
    raise DFGError(reason, loc=f"{file}:{line}", hint="docs/dfg-formats.md shows the form")

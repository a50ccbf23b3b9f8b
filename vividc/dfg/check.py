"""The invariants of a DFG, checked one by one: every stage may assume what this module lists.

A graph with a `generic` node, or none of whose memory operations has a base address, comes from
another tool and cannot be executed; of its memory operations the ports need not be fed, since a
foreign file often keeps an address in the node.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from typing import Final

from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.dfg.order import zero_cycle
from vividc.errors import printable
from vividc.machine.opcodes import BASE, ORDER, PRED, Opcode, Type, never_meet

WORD_LIMIT: Final = 1 << 32
_SHIFT_LIMIT: Final = 32
_SHOWN: Final = 12
_WIDTHS: Final = (1, 2, 4)
_INIT_SOURCES: Final = frozenset({Opcode.CONST, Opcode.LIVE_IN})
_EFFECTS: Final = frozenset({Opcode.STORE, Opcode.LIVE_OUT})


def check(dfg: DFG) -> list[str]:
    """Every broken invariant of `dfg`, one sentence each; empty if the graph is well formed.

    Types: words are untyped bits, so an integer operation may read a float's bits and a logic
    operation may read and make predicates; what never makes sense is a predicate read as a float,
    a float as a predicate, or a float of one format as one of another.
    """
    structure = [*_identifiers(dfg), *_endpoints(dfg)]
    if structure:  # the other rules look nodes up by id
        return structure
    return [problem for rule in _RULES for problem in rule(dfg)]


def _identifiers(dfg: DFG) -> Iterator[str]:
    for node_id, count in Counter(node.id for node in dfg.nodes).items():
        if count > 1:
            yield f"{count} nodes have id {node_id}"


def _endpoints(dfg: DFG) -> Iterator[str]:
    known = {node.id for node in dfg.nodes}
    for edge in dfg.edges:
        for what, end in (("src", edge.src), ("dst", edge.dst), ("init", edge.init)):
            if end is not None and end not in known:
                yield f"{_show(edge)}: its {what} {end} is no node"


def _nodes_have_their_fields(dfg: DFG) -> Iterator[str]:
    for node in dfg.nodes:
        if (node.op is Opcode.CONST) != (node.const is not None):
            yield f"node {node.id} ({node.op.value}): exactly a const node has a word"
        elif node.const is not None and not 0 <= node.const < WORD_LIMIT:
            yield f"node {node.id}: constant {node.const} is not a 32-bit word"
        if node.op in {Opcode.LIVE_IN, Opcode.LIVE_OUT, Opcode.GENERIC} and not node.name:
            yield f"node {node.id} ({node.op.value}) has no name"
        if not node.is_memory and (node.shift or node.offset):
            yield f"node {node.id} ({node.op.value}): only memory operations have shift and offset"
        if not 0 <= node.shift < _SHIFT_LIMIT:
            yield f"node {node.id}: shift {node.shift} is not in 0 .. {_SHIFT_LIMIT - 1}"


def _widths_are_legal(dfg: DFG) -> Iterator[str]:
    for node in dfg.nodes:
        if node.width not in _WIDTHS:
            yield f"node {node.id}: an access of {node.width} bytes; a width is 1, 2 or 4"
        if not node.is_memory and node.width != _WIDTHS[-1]:
            yield f"node {node.id} ({node.op.value}): only memory operations have a width"
        if node.signed and (node.op is not Opcode.LOAD or node.width == _WIDTHS[-1]):
            yield f"node {node.id} ({node.op.value}): only a load of less than a word is signed"


def _ports_exist(dfg: DFG) -> Iterator[str]:
    foreign = _is_foreign(dfg)
    for edge in dfg.edges:
        node = dfg.by_id[edge.dst]
        if not edge.is_data:
            if edge.port != ORDER:
                yield f"{_show(edge)}: the port of {edge.kind.value} edges is {ORDER}"
        elif not _port_is_legal(node, edge.port, foreign=foreign):
            yield f"{_show(edge)}: {node.op.value} has no port {edge.port}"


def _is_foreign(dfg: DFG) -> bool:
    if any(node.op is Opcode.GENERIC for node in dfg.nodes):
        return True
    based = any(edge.port == BASE for edge in dfg.edges)
    return not based and any(node.is_memory for node in dfg.nodes)


def _port_is_legal(node: Node, port: int, *, foreign: bool) -> bool:
    if node.op is Opcode.GENERIC or (foreign and node.is_memory):
        return port >= 0 and (port != BASE or node.is_memory)
    if port == BASE:
        return node.is_memory
    if port == PRED:
        return node.uses_fu
    return 0 <= port < node.info.arity


def _ports_have_one_producer(dfg: DFG) -> Iterator[str]:
    feeds = Counter((edge.dst, edge.port) for edge in dfg.edges if edge.is_data)
    for (node_id, port), count in feeds.items():
        if count > 1:
            yield f"node {node_id}: {count} edges feed port {port}"


def _ports_are_fed(dfg: DFG) -> Iterator[str]:
    foreign = _is_foreign(dfg)
    fed = {(edge.dst, edge.port) for edge in dfg.edges if edge.is_data}
    for node in dfg.nodes:
        if node.op is Opcode.GENERIC or (foreign and node.is_memory):
            continue
        ports = [*range(node.info.arity), *([BASE] if node.is_memory else [])]
        missing = [port for port in ports if (node.id, port) not in fed]
        for port in missing:
            name = "its base port" if port == BASE else f"port {port}"
            yield f"node {node.id} ({node.op.value}): nothing feeds {name}"


def _types_agree(dfg: DFG) -> Iterator[str]:
    foreign = _is_foreign(dfg)
    for edge in dfg.edges:
        if not edge.is_data:
            continue
        wanted = _port_type(dfg.by_id[edge.dst], edge.port)
        for source in (edge.src, edge.init):
            if source is None:
                continue
            given = dfg.by_id[source].info.result
            if given is Type.NONE:
                # Some foreign graphs chain a store's completion as a value.
                if not foreign:
                    yield f"{_show(edge)}: {dfg.by_id[source].op.value} {source} has no result"
            elif never_meet(given, wanted):
                yield f"{_show(edge)}: {given.value} read as {wanted.value}"


def _port_type(node: Node, port: int) -> Type:
    if port == PRED:
        return Type.PRED
    if 0 <= port < node.info.arity:
        return node.info.operands[port]
    return Type.ANY


def _distances_and_inits(dfg: DFG) -> Iterator[str]:
    for edge in dfg.edges:
        if edge.distance < 0:
            yield f"{_show(edge)}: its distance {edge.distance} is negative"
        if edge.init is None:
            continue
        if edge.distance == 0 or not edge.is_data:
            yield f"{_show(edge)}: only a data edge of distance 1 or more has an init"
        if dfg.by_id[edge.init].op not in _INIT_SOURCES:
            yield f"{_show(edge)}: its init {edge.init} is neither a constant nor a live-in"


def _no_cycle_of_distance_0(dfg: DFG) -> Iterator[str]:
    cycle = zero_cycle(dfg)
    if cycle:
        shown = [_called(dfg.by_id[node]) for node in cycle[:_SHOWN]]
        around = [*shown, *(["..."] if len(cycle) > _SHOWN else []), shown[0]]
        yield (
            f"a cycle of distance 0 holds back nodes {' -> '.join(around)}: none of them can be "
            "first; the edge that crosses to the next iteration has distance 1 or more"
        )


def _called(node: Node) -> str:
    name = node.name if node.op is Opcode.GENERIC else node.op.value
    return printable(f"{node.id} ({name}{f', {node.label}' if node.label else ''})")


def _sources_and_bases(dfg: DFG) -> Iterator[str]:
    for edge in dfg.edges:
        src, dst = dfg.by_id[edge.src], dfg.by_id[edge.dst]
        if dst.is_source:
            yield f"{_show(edge)}: {dst.op.value} has no input"
        if not edge.is_data and src.is_source:
            yield f"{_show(edge)}: {src.op.value} happens at no time, so nothing can follow it"
        if src.op is Opcode.IV and edge.distance:
            yield f"{_show(edge)}: the controller keeps no iv of an earlier iteration"
        if dst.op is Opcode.LIVE_OUT and src.is_source:
            yield f"{_show(edge)}: a live-out reads an operation, not {src.op.value}"
        if dst.op is Opcode.LIVE_OUT and edge.is_data and edge.distance:
            yield f"{_show(edge)}: a live-out reads its own iteration's result"
        if edge.port == BASE and (src.op not in _INIT_SOURCES or edge.distance):
            yield f"{_show(edge)}: a base address is a constant or a live-in"


def _variables_have_one_word(dfg: DFG) -> Iterator[str]:
    """Several live-outs of a variable, one for each of its homes, deliver one word."""
    sources: dict[str, set[int]] = defaultdict(set)
    for node in dfg.nodes:
        if node.op is Opcode.LIVE_OUT:
            sources[node.name] |= {e.src for e in dfg.edges if e.dst == node.id and e.is_data}
    for name, words in sources.items():
        if len(words) > 1:
            yield f"{len(words)} different words are written to {printable(name)}"


def _control_marks(dfg: DFG) -> Iterator[str]:
    for mark in Control:
        marked = [node.id for node in dfg.nodes if node.control is mark]
        if len(marked) > 1:
            yield f"nodes {', '.join(map(str, marked))} are all marked {mark.value}"
    for node in dfg.nodes:
        if node.control is not None and (not node.uses_fu or node.info.result is Type.NONE):
            yield f"node {node.id} ({node.op.value}) has no result to mark {node.control.value}"
        elif node.control is not None and never_meet(node.info.result, Type.PRED):
            yield f"node {node.id} ({node.op.value}) is marked {node.control.value}, but is a float"
        if node.unless_exit and node.op not in _EFFECTS and node.op is not Opcode.LOAD:
            yield f"node {node.id} ({node.op.value}): only memory and live-outs are unless_exit"
    has_exit = any(node.control is Control.EXIT for node in dfg.nodes)
    if has_exit and any(node.control in {Control.BRANCH, Control.TRIP} for node in dfg.nodes):
        yield "a graph with an exit is a loop: it has no branch or trip node"


def _control_edges(dfg: DFG) -> Iterator[str]:
    for edge in dfg.edges:
        if edge.kind is not EdgeKind.CONTROL:
            continue
        if dfg.by_id[edge.src].control is not Control.EXIT:
            yield f"{_show(edge)}: a control edge leaves the exit node"
        if dfg.by_id[edge.dst].op not in _EFFECTS:
            yield f"{_show(edge)}: a control edge enters a store or live-out"


def _show(edge: Edge) -> str:
    return f"edge {edge.src} -> {edge.dst} (port {edge.port}, distance {edge.distance})"


_RULES: Final[tuple[Callable[[DFG], Iterator[str]], ...]] = (
    _nodes_have_their_fields,
    _widths_are_legal,
    _ports_exist,
    _ports_have_one_producer,
    _ports_are_fed,
    _types_agree,
    _distances_and_inits,
    _no_cycle_of_distance_0,
    _sources_and_bases,
    _variables_have_one_word,
    _control_marks,
    _control_edges,
)

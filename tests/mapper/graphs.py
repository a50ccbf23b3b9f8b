"""DFGs written by hand for the mapper's tests."""

from __future__ import annotations

from dataclasses import replace

from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.machine.opcodes import BASE, ORDER, PRED, Opcode


class GraphBuilder:
    """Appends nodes and edges with ids in creation order."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.nodes: list[Node] = []
        self.edges: list[Edge] = []

    def source(self, op: Opcode, *, const: int | None = None, name: str = "") -> int:
        self.nodes.append(Node(len(self.nodes), op, const=const, name=name))
        return len(self.nodes) - 1

    def const(self, word: int) -> int:
        return self.source(Opcode.CONST, const=word)

    def op(self, op: Opcode, *operands: int, pred: int | None = None, name: str = "") -> int:
        node = self.source(op, name=name)
        self.edges += [Edge(src, node, port) for port, src in enumerate(operands)]
        if pred is not None:
            self.edges.append(Edge(pred, node, PRED))
        return node

    def load(self, name: str, index: int) -> int:
        node = self.op(Opcode.LOAD, index, name=name)
        self.edges.append(Edge(self.source(Opcode.LIVE_IN, name=f"&{name}"), node, BASE))
        return node

    def store(self, name: str, index: int, value: int, pred: int | None = None) -> int:
        node = self.op(Opcode.STORE, index, value, pred=pred, name=name)
        self.edges.append(Edge(self.source(Opcode.LIVE_IN, name=f"&{name}"), node, BASE))
        return node

    def carry(self, src: int, dst: int, port: int, init: int, distance: int = 1) -> None:
        self.edges.append(Edge(src, dst, port, distance, init))

    def order(self, src: int, dst: int, distance: int = 0) -> None:
        self.edges.append(Edge(src, dst, ORDER, distance, None, EdgeKind.ORDER))

    def mark(self, node: int, **changes: object) -> None:
        self.nodes[node] = replace(self.nodes[node], **changes)

    def build(self) -> DFG:
        return DFG(self.name, tuple(self.nodes), tuple(self.edges))


def chain(length: int, op: Opcode = Opcode.ADD) -> DFG:
    """A straight chain of `length` operations on the induction value."""
    g = GraphBuilder(f"chain{length}")
    value = g.source(Opcode.IV)
    one = g.const(1)
    for _ in range(length):
        value = g.op(op, value, one)
    return g.build()


def accumulator(op: Opcode = Opcode.FADD) -> DFG:
    """load -> accumulate -> live-out."""
    g = GraphBuilder("accumulator")
    value = g.load("x", g.source(Opcode.IV))
    total = g.op(op, value)
    g.carry(total, total, 1, g.const(0))
    g.op(Opcode.LIVE_OUT, total, name="%sum")
    return g.build()


def blending() -> DFG:
    """One Gaussian blended into one pixel: 9 loads, a polynomial exp, alpha test, recurrences."""
    g = GraphBuilder("blending")
    iv, px, py = g.source(Opcode.IV), *(g.source(Opcode.LIVE_IN, name=n) for n in ("px", "py"))
    names = ("x", "y", "a", "b", "c", "opacity", "red", "green", "blue")
    x, y, a, b, c, opacity, red, green, blue = (g.load(name, iv) for name in names)
    dx, dy = g.op(Opcode.FSUB, x, px), g.op(Opcode.FSUB, y, py)
    xx, yy, xy = g.op(Opcode.FMUL, dx, dx), g.op(Opcode.FMUL, dy, dy), g.op(Opcode.FMUL, dx, dy)
    power = g.op(Opcode.FMUL, a, xx)
    power = g.op(Opcode.FMA, c, yy, power)
    power = g.op(Opcode.FMA, b, xy, power)
    alpha = g.op(Opcode.FMUL, opacity, exponential(g, power))
    alpha = g.op(Opcode.FMIN, alpha, g.const(0x3F7D70A4))
    visible = g.op(Opcode.FCMP_OLE, g.const(0x3B808081), alpha)
    negative = g.op(Opcode.FCMP_OLE, power, g.const(0))
    keep = g.op(Opcode.AND, visible, negative)
    alpha = g.op(Opcode.SELECT, keep, alpha, g.const(0))
    left = g.op(Opcode.FSUB, g.const(0x3F800000), alpha)
    transmittance = g.op(Opcode.FMUL, left)
    g.carry(transmittance, transmittance, 1, g.const(0x3F800000))
    weight = g.op(Opcode.FMUL, alpha)
    g.carry(transmittance, weight, 1, g.const(0x3F800000))
    for colour, name in ((red, "%r"), (green, "%g"), (blue, "%b")):
        total = g.op(Opcode.FMA, weight, colour)
        g.carry(total, total, 2, g.const(0))
        g.op(Opcode.LIVE_OUT, total, name=name)
    return g.build()


def exponential(g: GraphBuilder, x: int) -> int:
    """exp(x) as 12 operations: range reduction, a polynomial of degree 5, exponent insertion."""
    scaled = g.op(Opcode.FMA, x, g.const(0x3FB8AA3B), g.const(0x4B400000))
    whole = g.op(Opcode.FSUB, scaled, g.const(0x4B400000))
    rest = g.op(Opcode.FMA, whole, g.const(0xBF317218), x)
    series = g.op(Opcode.FMA, rest, g.const(0x3C088889), g.const(0x3D2AAAAB))
    for word in (0x3E2AAAAB, 0x3F000000, 0x3F800000, 0x3F800000):
        series = g.op(Opcode.FMA, series, rest, g.const(word))
    exponent = g.op(Opcode.SHL, scaled, g.const(23))
    result = g.op(Opcode.ADD, series, exponent)
    tiny = g.op(Opcode.FCMP_OLT, x, g.const(0xC2AE0000))
    return g.op(Opcode.SELECT, tiny, g.const(0), result)

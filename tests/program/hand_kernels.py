"""Small kernels scheduled, placed and routed by hand; docs/machine.md gives their cycle counts."""

from __future__ import annotations

from dataclasses import dataclass, field

from vividc.arch import Fabric, load_text
from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.dfg.regions import RETURN_VARIABLE, Kernel, Region
from vividc.errors import SourceLoc
from vividc.machine.opcodes import BASE, ORDER, PRED, Opcode
from vividc.machine.params import DType, Param
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.program import Program, encode

O = Opcode  # noqa: E741 - one letter keeps the graphs readable
FILE = "kernels/hand.py"


def fabric(name: str = "mesh-2x2", **changes: str) -> Fabric:
    """A preset with some of its top-level keys changed, as YAML."""
    lines = [
        "name: hand",
        f"extends: {name}",
        *(f"{key}: {value}" for key, value in changes.items()),
    ]
    return load_text("\n".join(lines) + "\n")


@dataclass
class Hand:
    """A region in the making: nodes with their places, edges with their routes."""

    fabric: Fabric
    ii: int
    nodes: list[Node] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    places: dict[int, Place] = field(default_factory=dict)
    routes: dict[int, tuple[Step, ...]] = field(default_factory=dict)

    def source(self, op: Opcode, **attributes: object) -> int:
        """A constant, live-in or induction value."""
        node = Node(len(self.nodes), op, **attributes)
        self.nodes.append(node)
        return node.id

    def const(self, word: int) -> int:
        """A constant word."""
        return self.source(O.CONST, const=word)

    def live_in(self, name: str) -> int:
        """An input or a variable."""
        return self.source(O.LIVE_IN, name=name)

    def iv(self) -> int:
        """The iteration counter."""
        return self.source(O.IV)

    def op(self, op: Opcode, pe: int, time: int, **attributes: object) -> int:
        """A placed node; its source line is its id + 1."""
        node = Node(len(self.nodes), op, loc=SourceLoc(FILE, len(self.nodes) + 1), **attributes)
        self.nodes.append(node)
        self.places[node.id] = Place(pe, time)
        return node.id

    def feed(
        self, src: int, dst: int, port: int = 0, *, via: str = "", first: int | None = None
    ) -> None:
        """Edge to `port`; `first`: the source read in iteration 0, with distance 1.

        `via` lists where the word is, a cycle each: "1" the link into PE 1, "r2" register 2 there.
        """
        index = len(self.edges)
        self.edges.append(Edge(src, dst, port, 0 if first is None else 1, first))
        if self.nodes[src].is_source:
            return
        time = self.places[src].time + self.fabric.latency(self.nodes[src])
        pe = self.places[src].pe
        steps = []
        for word in via.split():
            if word.startswith("r"):
                steps.append(Step("reg", pe, int(word[1:]), time))
            else:
                link = next(k for k in self.fabric.links_from[pe] if k.dst == int(word))
                pe = link.dst
                steps.append(Step("link", pe, link.id, time))
            time += 1
        self.routes[index] = tuple(steps)

    def control(self, src: int, dst: int, distance: int) -> None:
        """A CONTROL edge."""
        self.edges.append(Edge(src, dst, ORDER, distance, kind=EdgeKind.CONTROL))

    def dfg(self, name: str) -> DFG:
        """The graph."""
        return DFG(name, tuple(self.nodes), tuple(self.edges))

    def mapping(self) -> Mapping:
        """The mapping."""
        return Mapping(self.ii, self.places, self.routes)


ARRAYS = (Param("x", DType.F32, 1), Param("y", DType.F32, 1))
N = Param("n", DType.I32)


def program(
    name: str,
    params: tuple[Param, ...],
    regions: list[tuple[Region, Hand]],
    returns: DType | None = None,
) -> Program:
    """Encode the regions on the fabric of the first."""
    kernel = Kernel(name, params, tuple(region for region, _ in regions), returns, FILE)
    mappings = {index: hand.mapping() for index, (_, hand) in enumerate(regions)}
    return encode(kernel, regions[0][1].fabric, mappings)


def trip_region(fab: Fabric, key: str = "n", after: int = 1) -> tuple[Region, Hand]:
    """Straight, 2 cycles (1 for the mov, 1 control latency): the trip count is an input."""
    hand = Hand(fab, 2)
    hand.feed(hand.live_in(key), hand.op(O.MOV, 0, 0, control=Control.TRIP))
    return Region("trip", "straight", hand.dfg("trip"), next=after), hand


def memory_op(
    hand: Hand, op: Opcode, pe: int, time: int, array: str, index: int, **attributes: object
) -> int:
    """A load or store of `array` at source node `index`, 4-byte elements."""
    node = hand.op(op, pe, time, name=array, shift=2, **attributes)
    hand.feed(index, node, 0)
    hand.feed(hand.live_in(f"&{array}"), node, BASE)
    return node


def saxpy(fab: Fabric) -> Program:
    """y[i] += 2 x[i] for i < n at II 1 on a 2x2 mesh: iteration span 4, four stages."""
    hand = Hand(fab, 1)
    iv, two = hand.iv(), hand.const(0x40000000)
    x = memory_op(hand, O.LOAD, 0, 0, "x", iv)
    y = memory_op(hand, O.LOAD, 3, 0, "y", iv)
    total = hand.op(O.FMA, 1, 1)
    hand.feed(two, total, 0)
    hand.feed(x, total, 1, via="1")
    hand.feed(y, total, 2, via="1")
    store = memory_op(hand, O.STORE, 2, 3, "y", iv)
    hand.feed(total, store, 1, via="0 2")
    loop = Region("loop", "loop", hand.dfg("loop"), counted=True)
    return program("saxpy", (*ARRAYS, N), [trip_region(fab), (loop, hand)])


def dot(fab: Fabric) -> Program:
    """Return the sum of x[i] y[i]; fma latency 4, so II 4 (recurrence through `out`)."""
    start = Hand(fab, 2)
    trip = start.op(O.MOV, 0, 0, control=Control.TRIP)
    start.feed(start.live_in("n"), trip)
    zero = start.op(O.MOV, 1, 0)
    start.feed(start.const(0), zero)
    start.feed(zero, start.op(O.LIVE_OUT, 1, 1, name="%acc"))

    hand = Hand(fab, 4)
    iv = hand.iv()
    x = memory_op(hand, O.LOAD, 0, 0, "x", iv)
    y = memory_op(hand, O.LOAD, 3, 0, "y", iv)
    acc = hand.op(O.FMA, 1, 1)
    hand.feed(x, acc, 0, via="1")
    hand.feed(y, acc, 1, via="1")
    hand.feed(acc, acc, 2, first=hand.const(0))
    hand.feed(acc, hand.op(O.LIVE_OUT, 1, 5, name="%acc"))

    end = Hand(fab, 2)
    value = end.op(O.MOV, 1, 0)
    end.feed(end.live_in("%acc"), value)
    end.feed(value, end.op(O.LIVE_OUT, 1, 1, name=RETURN_VARIABLE))
    regions = [
        (Region("start", "straight", start.dfg("start"), next=1), start),
        (Region("loop", "loop", hand.dfg("loop"), next=2, counted=True), hand),
        (Region("end", "straight", end.dfg("end")), end),
    ]
    return program("dot", (*ARRAYS, N), regions, DType.F32)


def find(fab: Fabric, *, counted: bool = False) -> Program:
    """Copy x[i] to y[i] until x[i] == key; return that i. II 1, the exit acts in cycle i + 3.

    The copy is `unless_exit`; its word waits one cycle in a register of PE 3 for the exit.
    """
    hand = Hand(fab, 1)
    iv = hand.iv()
    x = memory_op(hand, O.LOAD, 0, 0, "x", iv)
    found = hand.op(O.ICMP_EQ, 1, 1, control=Control.EXIT)
    hand.feed(x, found, 0, via="1")
    hand.feed(hand.live_in("key"), found, 1)
    store = memory_op(hand, O.STORE, 3, 3, "y", iv, unless_exit=True)
    hand.feed(x, store, 1, via="1 3 r0")
    hand.control(found, store, 0)
    where = hand.op(O.MOV, 2, 1)
    hand.feed(iv, where)
    out = hand.op(O.LIVE_OUT, 2, 2, name=RETURN_VARIABLE)
    hand.feed(where, out)
    hand.control(found, out, 1)
    loop = Region("search", "loop", hand.dfg("search"), counted=counted)
    params = (Param("x", DType.I32, 1), Param("y", DType.I32, 1), Param("key", DType.I32))
    if not counted:
        return program("find", params, [(loop, hand)], DType.I32)
    return program("find_n", (*params, N), [trip_region(fab), (loop, hand)], DType.I32)


def positive(fab: Fabric) -> Program:
    """y[i] = x[i] where x[i] > 0 (a predicated store), for i < n; II 1, span 3."""
    hand = Hand(fab, 1)
    iv = hand.iv()
    x = memory_op(hand, O.LOAD, 0, 0, "x", iv)
    test = hand.op(O.ICMP_SLT, 1, 1)
    hand.feed(hand.const(0), test, 0)
    hand.feed(x, test, 1, via="1")
    store = memory_op(hand, O.STORE, 3, 2, "y", iv)
    hand.feed(x, store, 1, via="2 3")
    hand.feed(test, store, PRED, via="3")
    loop = Region("loop", "loop", hand.dfg("loop"), counted=True)
    params = (Param("x", DType.I32, 1), Param("y", DType.I32, 1), N)
    return program("positive", params, [trip_region(fab), (loop, hand)])


def pairs(fab: Fabric, distance: int) -> Program:
    """y[i] = x[i] + x[i + distance] for i < n; II 1, span 4, two loads and a store a cycle."""
    hand = Hand(fab, 1)
    iv = hand.iv()
    low = memory_op(hand, O.LOAD, 0, 0, "x", iv)
    high = memory_op(hand, O.LOAD, 3, 0, "x", iv, offset=4 * distance)
    total = hand.op(O.ADD, 1, 1)
    hand.feed(low, total, 0, via="1")
    hand.feed(high, total, 1, via="1")
    store = memory_op(hand, O.STORE, 2, 3, "y", iv)
    hand.feed(total, store, 1, via="0 2")
    loop = Region("loop", "loop", hand.dfg("loop"), counted=True)
    params = (Param("x", DType.I32, 1), Param("y", DType.I32, 1), N)
    return program("pairs", params, [trip_region(fab), (loop, hand)])


def choose(fab: Fabric) -> Program:
    """Return 1 if n < 10, else 2: a branch between two straight regions."""
    test = Hand(fab, 2)
    small = test.op(O.ICMP_SLT, 0, 0, control=Control.BRANCH)
    test.feed(test.live_in("n"), small, 0)
    test.feed(test.const(10), small, 1)
    regions = [(Region("test", "straight", test.dfg("test"), next=1, branch=2), test)]
    for name, word in (("large", 2), ("small", 1)):
        hand = Hand(fab, 2)
        value = hand.op(O.MOV, 0, 0)
        hand.feed(hand.const(word), value)
        hand.feed(value, hand.op(O.LIVE_OUT, 0, 1, name=RETURN_VARIABLE))
        regions.append((Region(name, "straight", hand.dfg(name)), hand))
    return program("choose", (N,), regions, DType.I32)

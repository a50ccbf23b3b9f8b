"""What is known of graphs from other stages of a plan. Equal ones come with other names: a stage
numbers its variables anew, and other regions leave other words in constant stores.
"""

from __future__ import annotations

from collections.abc import Hashable
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field, replace

from vividc.dfg.ir import DFG
from vividc.errors import MappingFailed
from vividc.machine.opcodes import Opcode
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.mapping import Mapping
from vividc.mapper.resources.banks import Meets

_VARIABLES = (Opcode.LIVE_IN, Opcode.LIVE_OUT)


@dataclass(frozen=True)
class Earlier:
    """What is known of graphs from other kernels for the same fabric.

    Attributes
    ----------
    loops
        The newest result of each loop, by the graph without its name.
    searched
        The newest result of each loop, by `posed`: what a search would find again.
    again
        What came of negotiating it anew, by `posed` and how that was done.
    straight
        The schedule of a straight region, or why it has none, by `posed` and `straight_key`.
    hopeless
        Straight regions that nothing could place, by the graph without its name.
    """

    loops: dict[DFG, MapResult] = field(default_factory=dict)
    searched: dict[Hashable, MapResult] = field(default_factory=dict)
    again: dict[Hashable, Mapping | None] = field(default_factory=dict)
    straight: dict[Hashable, Mapping | MappingFailed] = field(default_factory=dict)
    hopeless: dict[DFG, MappingFailed] = field(default_factory=dict)


def unnamed(dfg: DFG) -> DFG:
    """The graph without its name."""
    return replace(dfg, name="")


def numbered(dfg: DFG) -> DFG:
    """The graph without names, its variables numbered in the order in which they come."""
    numbers = _numbers(dfg)
    nodes = (
        replace(node, name=numbers[node.name]) if node.op in _VARIABLES else node
        for node in dfg.nodes
    )
    return replace(dfg, name="", nodes=tuple(nodes))


def posed(problem: MapProblem) -> Hashable:
    """The problem as far as a mapper looks at it: of words that others hold in a constant store it
    matters how many there are, and which of them the graph has, too.
    """
    dfg = problem.dfg
    numbers = _numbers(dfg)
    words = {("const", node.const): node.const for node in dfg.nodes if node.op is Opcode.CONST}
    known = words | {("live_in", name): number for name, number in numbers.items()}
    held = (
        (pe, len(keys), frozenset(known[key] for key in keys if key in known))
        for pe, keys in sorted(problem.resident.items())
    )
    return numbered(dfg), tuple(held), tuple(sorted(problem.allowed.items()))


def straight_key(meets: Meets, frugal: bool) -> Hashable:
    """How a straight region is scheduled."""
    often = sorted((access, tuple(sorted(others.items()))) for access, others in meets.items())
    return tuple(often), frugal


def _numbers(dfg: DFG) -> ReadOnly[str, str]:
    names = dict.fromkeys(node.name for node in dfg.nodes if node.op in _VARIABLES)
    return {name: f"%{number}" for number, name in enumerate(names)}

"""What is known of graphs from other stages of a plan. Equal ones come with other names: a stage
numbers its variables anew, and other regions leave other words in constant stores.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

from vividc.dfg.alike import names, numbered, numbers
from vividc.dfg.ir import DFG
from vividc.errors import MappingFailed
from vividc.machine.opcodes import Opcode
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.mapping import Mapping
from vividc.mapper.resources.banks import Meets


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
    crowded
        Straight regions, without their names, that had no room but with a frugal schedule.
    hopeless
        Straight regions that nothing could place, by the graph without its name.
    """

    loops: dict[DFG, MapResult] = field(default_factory=dict)
    searched: dict[Hashable, MapResult] = field(default_factory=dict)
    again: dict[Hashable, Mapping | None] = field(default_factory=dict)
    straight: dict[Hashable, Mapping | MappingFailed] = field(default_factory=dict)
    crowded: set[DFG] = field(default_factory=set)
    hopeless: dict[DFG, MappingFailed] = field(default_factory=dict)


def posed(problem: MapProblem) -> Hashable:
    """The problem as far as a mapper looks at it: of words that others hold in a constant store it
    matters how many there are, and which of them the graph has, too.
    """
    dfg = problem.dfg
    every = names(dfg)
    words = {("const", node.const): node.const for node in dfg.nodes if node.op is Opcode.CONST}
    known = words | {("live_in", name): number for name, number in numbers(every).items()}
    held = (
        (pe, len(keys), frozenset(known[key] for key in keys if key in known))
        for pe, keys in sorted(problem.resident.items())
    )
    allowed = tuple(sorted(problem.allowed.items()))
    drain = None if problem.drain is None else problem.drain.renamed(known)
    fill = None if problem.fill is None else problem.fill.renamed(known)
    return numbered(dfg, every), tuple(held), allowed, drain, fill


def straight_key(meets: Meets, frugal: bool) -> Hashable:
    """How a straight region is scheduled."""
    often = sorted((access, tuple(sorted(others.items()))) for access, others in meets.items())
    return tuple(often), frugal

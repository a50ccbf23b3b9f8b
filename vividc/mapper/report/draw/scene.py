"""What a picture of a mapping shows: who issues, drives and holds what in each slot."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass
from typing import Final

from vividc.arch.fabric import PE, Fabric
from vividc.dfg.ir import DFG, Node
from vividc.errors import VividcError
from vividc.host.plot import OKABE_ITO, tint
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.mapper.resources.fu_slots import fu_slots, kept, moved

IDLE: Final = "#ffffff"
MOVE: Final = tint(OKABE_ITO["grey"], 0.45)
_PALE: Final = 0.35
_GROUPS: Final = (
    (("memory"), (LatencyClass.LOAD, LatencyClass.STORE), tint(OKABE_ITO["green"], 0.55)),
    (
        "floating point",
        (
            *(LatencyClass.FADD, LatencyClass.FMUL, LatencyClass.FMA),
            *(LatencyClass.DOT, LatencyClass.CONVERT),
        ),
        tint(OKABE_ITO["sky"], 0.7),
    ),
    ("integer", (LatencyClass.INT, LatencyClass.IMUL), tint(OKABE_ITO["orange"], 0.6)),
    ("compare, select", (LatencyClass.COMPARE, LatencyClass.SELECT), OKABE_ITO["yellow"]),
    ("live-out", (LatencyClass.SINK,), tint(OKABE_ITO["purple"], 0.6)),
)
_OTHER: Final = ("other", tint(OKABE_ITO["grey"], 0.6))


@dataclass(frozen=True)
class Scene:
    """A mapping by slot.

    Attributes
    ----------
    issues
        Nodes that start at (PE, slot); more than one only for live-outs beside an operation.
    driven
        (link, id of the node whose word it carries) of each slot in which the link is driven.
    held
        (kind, index, id of the node) of every other place of a word, at (PE, slot) where it is
        readable: registers, and output registers that a fabric routes through. Of a rotating file,
        the index is the register's name as in `Step`, and there once for each iteration whose word
        is held: each is in a register of its own.
    moved, kept
        See `fu_slots`.
    """

    dfg: DFG
    fabric: Fabric
    mapping: Mapping
    issues: ReadOnly[tuple[int, int], tuple[tuple[Node, Place], ...]]
    driven: ReadOnly[int, tuple[tuple[int, int], ...]]
    held: ReadOnly[tuple[int, int], tuple[tuple[str, int, int], ...]]
    moved: ReadOnly[tuple[int, int], tuple[int, ...]]
    kept: ReadOnly[tuple[int, int], Node]

    @property
    def stages(self) -> int:
        """Stages of the schedule."""
        return 1 + max(
            (place.time // self.mapping.ii for place in self.mapping.places.values()), default=0
        )

    @property
    def fabric_has_plain_pes(self) -> bool:
        """Whether load/store units are worth marking: some PEs have none."""
        return not all(pe.has_memory for pe in self.fabric.pes)

    def marked(self, pe: PE) -> bool:
        """Whether the PE is marked as one with a load/store unit."""
        return pe.has_memory and self.fabric_has_plain_pes

    def usage(self) -> str:
        """How full the array is, in words."""
        ii, fabric = self.mapping.ii, self.fabric
        registers = sum(pe.registers for pe in fabric.pes)
        in_registers = sum(
            1 for words in self.held.values() for kind, _, _ in words if kind == "reg"
        )
        parts = (
            (f"{fu_slots(self.dfg, fabric, self.mapping)}", len(fabric.pes), "FU"),
            (f"{sum(map(len, self.driven.values()))}", len(fabric.links), "link"),
            (f"{in_registers}", registers, "register"),
        )
        return ", ".join(f"{used} of {ii * count} {what} slots" for used, count, what in parts)


def scene_of(dfg: DFG, fabric: Fabric, mapping: Mapping) -> Scene:
    """The mapping by slot.

    Raises
    ------
    VividcError
        The mapping names a node, edge, PE or link that the graph or the fabric does not have.
    """
    _check(dfg, fabric, mapping)
    issues: dict[tuple[int, int], list[tuple[Node, Place]]] = defaultdict(list)
    for node_id, place in sorted(mapping.places.items()):
        issues[place.pe, place.time % mapping.ii].append((dfg.by_id[node_id], place))
    driven: dict[int, dict[tuple[int, int], None]] = defaultdict(dict)
    held: dict[tuple[int, int], set[tuple[str, int, int, int]]] = defaultdict(set)
    for edge, steps in sorted(mapping.routes.items()):
        value = dfg.edges[edge].src
        for step in steps:
            if step.kind == "link":
                driven[(step.time - 1) % mapping.ii][step.index, value] = None
            else:
                ago = step.time // mapping.ii if fabric.pes[step.pe].rotating else 0
                held[step.pe, step.time % mapping.ii].add((step.kind, step.index, value, ago))
    return Scene(
        dfg,
        fabric,
        mapping,
        {key: tuple(value) for key, value in issues.items()},
        {key: tuple(sorted(value)) for key, value in driven.items()},
        {key: tuple(place[:3] for place in sorted(value)) for key, value in held.items()},
        moved(dfg, fabric, mapping),
        kept(dfg, fabric, mapping),
    )


def colour_of(node: Node) -> str:
    """The fill of an operation, by its latency class."""
    return next(
        (colour for _, members, colour in _GROUPS if node.latency_class in members), _OTHER[1]
    )


def pale(node: Node) -> str:
    """The fill where a node keeps an FU that it began to use earlier."""
    return tint(colour_of(node), _PALE)


def groups_of(dfg: DFG) -> tuple[tuple[str, str], ...]:
    """(name, colour) of the groups that occur in the graph, for a legend."""
    present = {colour_of(node) for node in dfg.placed}
    every = [*((name, colour) for name, _, colour in _GROUPS), _OTHER]
    return tuple((name, colour) for name, colour in every if colour in present)


def operation_name(node: Node) -> str:
    """The operation's name; a foreign operation has its own."""
    return node.name if node.op is Opcode.GENERIC else node.op.value


def describe(node: Node, place: Place, fabric: Fabric) -> str:
    """All about a placed node, for a tooltip."""
    name = f" {node.name}" if node.name and node.op is not Opcode.GENERIC else ""
    where = f", {node.loc}" if node.loc is not None else ""
    return (
        f"#{node.id} {operation_name(node)}{name}{where}: cycle {place.time} on PE {place.pe}, "
        f"latency {fabric.latency(node)}"
    )


def _check(dfg: DFG, fabric: Fabric, mapping: Mapping) -> None:
    known = dfg.by_id
    odd = [f"node {node}" for node in mapping.places if node not in known]
    odd += [f"PE {p.pe}" for p in mapping.places.values() if not 0 <= p.pe < len(fabric.pes)]
    odd += [f"edge {edge}" for edge in mapping.routes if not 0 <= edge < len(dfg.edges)]
    odd += [text for steps in mapping.routes.values() for s in steps if (text := _odd(s, fabric))]
    if mapping.ii < 1:
        odd.append(f"II {mapping.ii}")
    if odd:
        raise VividcError(
            f"the mapping names {odd[0]}, which {dfg.name!r} or {fabric.name!r} does not have",
            loc="plot",
            hint="draw a mapping with the graph and the fabric it was made for",
        )


def _odd(step: Step, fabric: Fabric) -> str:
    if step.kind == "link" and not 0 <= step.index < len(fabric.links):
        return f"link {step.index}"
    return "" if 0 <= step.pe < len(fabric.pes) else f"PE {step.pe}"

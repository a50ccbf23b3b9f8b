"""Which bank each array should start in, so that the loads and stores of one cycle meet in no bank.

In a modulo schedule, an access of stage s sees the iteration index s less than one of stage 0 in
the same cycle. Accesses that step through their arrays alike therefore stay a fixed number of banks
apart, and the start of the arrays decides it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from vividc.arch.fabric import Fabric, Scratchpad
from vividc.dfg.ir import DFG, Node
from vividc.dfg.regions import Kernel
from vividc.machine.opcodes import BASE, Opcode
from vividc.machine.words import WORD_BYTES
from vividc.mapper.mapping import Mapping as RegionMapping


@dataclass(frozen=True, slots=True)
class _Stream:
    """Accesses of `array` in slot `slot` of region `region`: byte (start + lead + step * cycle-
    group).
    """

    region: int
    slot: int
    array: str
    step: int
    lead: int


def choose_banks(
    kernel: Kernel, fabric: Fabric, mappings: Mapping[int, RegionMapping]
) -> dict[str, int]:
    """The start bank of each array parameter and each array of the kernel's own, by name.

    Greedy in parameter order: the bank with the fewest meetings with the arrays before, and of
    those the one that follows on from the array before. Accesses whose addresses are not known to
    step are left out.
    """
    banks = fabric.scratchpad.banks
    streams = [
        stream
        for index, region in enumerate(kernel.regions)
        if region.kind == "loop"
        for stream in _streams(index, region.dfg, mappings[index])
    ]
    starts: dict[str, int] = {}
    arrays = [param.name for param in kernel.params if param.ndim]
    arrays += [local.name for local in kernel.locals]
    for position, name in enumerate(arrays):
        order = [(position + offset) % banks for offset in range(banks)]
        starts[name] = min(
            order, key=lambda bank: _meetings(streams, starts, name, bank, fabric.scratchpad)
        )
    return starts


def _streams(index: int, dfg: DFG, mapping: RegionMapping) -> Iterator[_Stream]:
    for node in dfg.nodes:
        if not node.is_memory or not _steps_from_array_start(dfg, node):
            continue
        step = 1 << node.shift
        stage, slot = divmod(mapping.places[node.id].time, mapping.ii)
        yield _Stream(index, slot, node.name, step, node.offset - stage * step)


def _steps_from_array_start(dfg: DFG, node: Node) -> bool:
    word, base = dfg.operand(node.id, 0), dfg.operand(node.id, BASE)
    if word is None or base is None:
        return False
    source = dfg.by_id[base.src]
    by_iteration = dfg.by_id[word.src].op is Opcode.IV and word.distance == 0
    return by_iteration and source.op is Opcode.LIVE_IN and source.name == f"&{node.name}"


def _meetings(
    streams: list[_Stream],
    starts: Mapping[str, int],
    name: str,
    bank: int,
    scratchpad: Scratchpad,
) -> int:
    mine = [stream for stream in streams if stream.array == name]
    return sum(
        scratchpad.may_meet((bank - starts[other.array]) * WORD_BYTES + own.lead - other.lead)
        for own in mine
        for other in streams
        if other.array in starts
        and (own.region, own.slot, own.step) == (other.region, other.slot, other.step)
    )

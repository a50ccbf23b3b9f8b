"""What must hold of a region's schedule before it is encoded: times, control results, effects."""

from __future__ import annotations

from collections.abc import Iterator

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Control, Node
from vividc.dfg.regions import Region, is_variable
from vividc.errors import InternalError
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping


def check_region(region: Region, mapping: Mapping, fabric: Fabric) -> None:
    """Raise `InternalError` for the first rule of docs/machine.md that the schedule breaks."""
    for fault in _faults(region, mapping, fabric):
        raise InternalError(f"region {region.name}: {fault}")


def stages_of(region: Region, mapping: Mapping) -> int:
    """Live bits the region needs."""
    times = [mapping.places[node.id].time for node in region.dfg.placed]
    return max(times, default=0) // mapping.ii + 1


def span_of(region: Region, mapping: Mapping, fabric: Fabric) -> int:
    """Cycles from an iteration's first issue to its last completion, control latency and FUs that
    are still busy included.
    """
    if region.kind == "straight":
        return mapping.ii
    return max((_idle(node, mapping, fabric) for node in region.dfg.placed), default=1)


def control_node(region: Region, control: Control) -> Node | None:
    """The node whose result the controller uses as `control`, if any."""
    for node in region.dfg.nodes:
        if node.control is control:
            return node
    return None


def _end(node: Node, mapping: Mapping, fabric: Fabric) -> int:
    """First cycle in which everything that `node` causes has happened."""
    time = mapping.places[node.id].time
    if node.op is Opcode.LIVE_OUT:
        return time + 1
    extra = fabric.controller.control_latency if node.control is not None else 0
    return time + fabric.latency(node) + extra


def _idle(node: Node, mapping: Mapping, fabric: Fabric) -> int:
    """First cycle in which `node` neither causes anything nor keeps its FU."""
    busy = fabric.occupancy(node) if node.uses_fu else 1
    return max(_end(node, mapping, fabric), mapping.places[node.id].time + busy)


def _faults(region: Region, mapping: Mapping, fabric: Fabric) -> Iterator[str]:
    if mapping.ii < 1:
        yield f"its II is {mapping.ii}"
        return
    for node in region.dfg.placed:
        yield from _place_faults(node, mapping, fabric)
    if stages_of(region, mapping) > fabric.controller.max_stages:
        yield f"{stages_of(region, mapping)} stages do not fit"
    yield from _control_faults(region, mapping, fabric)
    if region.kind == "straight":
        for node in region.dfg.placed:
            if _idle(node, mapping, fabric) > mapping.ii:
                yield f"node {node.id} is not done after the region's {mapping.ii} cycles"
    yield from _variable_faults(region, mapping)
    yield from _exit_faults(region, mapping, fabric)


def _place_faults(node: Node, mapping: Mapping, fabric: Fabric) -> Iterator[str]:
    place = mapping.places.get(node.id)
    if place is None or place.time < 0 or not 0 <= place.pe < len(fabric.pes):
        raise InternalError(f"node {node.id} has no place on the fabric")
    if not fabric.supports(place.pe, node):
        yield f"PE {place.pe} cannot execute node {node.id} ({node.op.value})"
    if node.uses_fu and fabric.latency(node) < 1:
        yield f"node {node.id} ({node.op.value}) has latency {fabric.latency(node)}"
    if node.unless_exit and node.op not in (Opcode.LOAD, Opcode.STORE, Opcode.LIVE_OUT):
        yield f"node {node.id} ({node.op.value}) has no effect that an exit could suppress"


def _control_faults(region: Region, mapping: Mapping, fabric: Fabric) -> Iterator[str]:
    ready = [
        (mapping.places[node.id].time + fabric.latency(node)) % mapping.ii
        for node in region.dfg.operations
        if node.control is not None
    ]
    if len(set(ready)) < len(ready):
        yield "two results reach the controller in one cycle"
    marks = [node.control for node in region.dfg.nodes if node.control is not None]
    if len(set(marks)) < len(marks):
        yield "two nodes for one use by the controller"
    allowed = {Control.EXIT} if region.kind == "loop" else {Control.BRANCH, Control.TRIP}
    if not set(marks) <= allowed:
        yield f"a {region.kind} region has a control node of another kind"
    if region.kind == "loop" and not region.counted and Control.EXIT not in marks:
        yield "the loop never ends"
    if (Control.BRANCH in marks) is not (region.branch is not None):
        yield "a branch needs both a node and a target"


def _variable_faults(region: Region, mapping: Mapping) -> Iterator[str]:
    """A variable is read as it was before the region, so no read comes after the region's write."""
    written = {
        (node.name, mapping.places[node.id].pe): mapping.places[node.id].time
        for node in region.dfg.nodes
        if node.op is Opcode.LIVE_OUT
    }
    for edge in region.dfg.edges:
        if not edge.is_data:
            continue
        reader = mapping.places[edge.dst]
        for source, again in ((edge.src, region.kind == "loop"), (edge.init, False)):
            node = region.dfg.by_id[source] if source is not None else None
            if node is None or node.op is not Opcode.LIVE_IN or not is_variable(node.name):
                continue
            time = written.get((node.name, reader.pe))
            if time is not None and (again or reader.time > time):
                yield f"node {edge.dst} reads {node.name} after the region has written it"


def _exit_faults(region: Region, mapping: Mapping, fabric: Fabric) -> Iterator[str]:
    """Effects wait for the exits of earlier iterations, `unless_exit` ones also for their own."""
    exit_node = control_node(region, Control.EXIT)
    if exit_node is None:
        return
    acts = _end(exit_node, mapping, fabric)
    for node in region.dfg.placed:
        if node.op not in (Opcode.STORE, Opcode.LIVE_OUT):
            continue
        allowed_from = acts if node.unless_exit else acts - mapping.ii
        if mapping.places[node.id].time < allowed_from:
            yield f"the effect of node {node.id} comes before the exit can stop it"

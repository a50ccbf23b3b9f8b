"""Straight regions that have no schedule, and why."""

from __future__ import annotations

from vividc.dfg.ir import Node
from vividc.errors import MappingFailed
from vividc.mapper.problem import MapProblem


def refuse_impossible(problem: MapProblem) -> None:
    """Refuses distances, and nodes that no PE executes."""
    for edge in problem.dfg.edges:
        if edge.distance:
            raise MappingFailed(
                f"{problem.dfg.name}: edge {edge.src} -> {edge.dst} has distance {edge.distance}",
                hint="only loop regions have distances",
            )
    for node in problem.dfg.placed:
        if not problem.candidates(node):
            raise MappingFailed(
                f"no PE permitted to {show(node)} executes {_needed(node)}",
                loc=node.loc,
            )


def _needed(node: Node) -> str:
    lanes = " on 16 or 8 bits (`sliced`)" if node.info.sliced else ""
    return f"{node.latency_class.value}{lanes}"


def refuse_too_long(problem: MapProblem, length: int) -> None:
    """Refuses more cycles than a PE has contexts."""
    contexts = problem.fabric.controller.contexts
    if length > contexts:
        raise MappingFailed(
            f"{problem.dfg.name}: its schedule takes {length} cycles, "
            f"but a PE has {contexts} contexts",
            hint="split the kernel, or use a fabric with more contexts",
        )


def failure_of(problem: MapProblem, failure: Stuck | None) -> MappingFailed:
    """What is told when no trial succeeds."""
    if failure is None:
        return MappingFailed(f"{problem.dfg.name}: there was no time for a trial")
    return MappingFailed(
        f"{problem.dfg.name}: {show(failure.node)} cannot be placed: {failure.reason}",
        loc=failure.node.loc,
        hint="use a fabric with more registers or constants, or split the region",
    )


def show(node: Node) -> str:
    """A node in a message."""
    return f"node {node.id} ({node.op.value})"


class Stuck(Exception):
    """The greedy schedule is stuck; another trial may succeed."""

    def __init__(self, node: Node, reason: str) -> None:
        self.node = node
        self.reason = reason
        super().__init__(reason)

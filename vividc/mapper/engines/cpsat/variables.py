"""The Boolean variables of time, place and route, each named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ortools.sat.python.cp_model import CpModel, IntVar

from vividc.mapper.engines.cpsat.problem import LinkAt, NodeAt, Prepared
from vividc.mapper.problem import ConstantKey


@dataclass(frozen=True, slots=True)
class Variables:
    """All variables of one model; keys as in `Prepared`.

    Attributes
    ----------
    start
        [node, pe, time]: the node issues there and then.
    link
        [word, link, time]: the word is readable at the end of the link.
    held, written, read
        [word, pe, time]: a register holds the word; it was written in the cycle before; an RF read
        port reads it.
    constant
        [pe, key]: the constant store of the PE keeps the entry. Only where capacity could be
        exceeded.
    output, move
        [word, pe, time]: the output register of the PE holds the word; its FU moves the word. Only
        where output registers take part in routes.
    hop
        [word, link, time, depth]: the link is the depth-th that the word passes in the cycle before
        `time`. Only where a word may pass several.
    stage
        Cyclic timeline only: stage of each node.
    """

    start: Mapping[NodeAt, IntVar]
    link: Mapping[LinkAt, IntVar]
    held: Mapping[NodeAt, IntVar]
    written: Mapping[NodeAt, IntVar]
    read: Mapping[NodeAt, IntVar]
    constant: Mapping[tuple[int, ConstantKey], IntVar]
    stage: Mapping[int, IntVar]
    output: Mapping[NodeAt, IntVar]
    move: Mapping[NodeAt, IntVar]
    hop: Mapping[tuple[int, int, int, int], IntVar]


def new_variables(model: CpModel, problem: Prepared, *, routes: bool = True) -> Variables:
    """Create every variable, in a deterministic order; without `routes` those of time and place
    only.
    """
    if not routes:
        names = {key: f"start[{key[0]},{key[1]},{key[2]}]" for key in problem.starts}
        start = {key: model.new_bool_var(name) for key, name in names.items()}
        constants, stages = _constants(model, problem), _stages(model, problem)
        return Variables(start, {}, {}, {}, {}, constants, stages, {}, {}, {})

    def booleans(name: str, keys: tuple[NodeAt, ...]) -> dict[NodeAt, IntVar]:
        return {key: model.new_bool_var(f"{name}[{key[0]},{key[1]},{key[2]}]") for key in keys}

    return Variables(
        start=booleans("start", problem.starts),
        link=booleans("link", problem.on_links),
        held=booleans("held", problem.in_registers),
        written=booleans("written", problem.in_registers),
        read=booleans("read", problem.in_registers),
        constant=_constants(model, problem),
        stage=_stages(model, problem),
        output=booleans("output", problem.in_outputs),
        move=booleans("move", problem.moves),
        hop=_hops(model, problem),
    )


def _hops(model: CpModel, problem: Prepared) -> dict[tuple[int, int, int, int], IntVar]:
    most = problem.fabric.routing.hops
    if most <= 1:
        return {}
    return {
        (word, link, time, depth): model.new_bool_var(f"hop[{word},{link},{time},{depth}]")
        for word, link, time in problem.on_links
        for depth in range(1, most + 1)
    }


def _constants(model: CpModel, problem: Prepared) -> dict[tuple[int, ConstantKey], IntVar]:
    entries: dict[tuple[int, ConstantKey], IntVar] = {}
    for pe in problem.fabric.pes:
        resident = problem.task.resident.get(pe.id, frozenset())
        keys = dict.fromkeys(
            key
            for node in problem.nodes
            if pe.id in problem.candidates[node.id]
            for key in problem.task.constants_of(node)
            if key not in resident
        )
        if len(keys) + len(resident) <= pe.constants:
            continue
        for key in keys:
            entries[pe.id, key] = model.new_bool_var(f"constant[{pe.id},{key[0]}:{key[1]}]")
    return entries


def _stages(model: CpModel, problem: Prepared) -> dict[int, IntVar]:
    if not problem.cyclic:
        return {}
    return {
        node.id: model.new_int_var(0, problem.last_stage, f"stage[{node.id}]")
        for node in problem.nodes
    }

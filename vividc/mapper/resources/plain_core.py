"""The part of a fabric that works as in ViViD, for routers that know nothing else."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

from vividc.arch.fabric import Fabric, Routing
from vividc.host.once import once_each
from vividc.mapper.mapping import Mapping, Step
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.registers import Lifetime, allocate

_StepKey = tuple[int, int, int]
"""(producer, PE, cycle) of a word in a register."""


def plain_core(fabric: Fabric) -> Fabric | None:
    """The fabric without its options, if what is left is a machine whose mappings it can run but
    for the names of rotating registers; None if an option takes something away.

    Links that words may pass several of in a cycle can be passed one by one, and output registers
    that hold can be read at once.
    """
    if fabric.is_plain:
        return fabric
    busy = any(cycles > 1 for cycles in fabric.occupancies.values())
    if not fabric.routing.hops or busy or any(pe.written_by_fu for pe in fabric.pes):
        return None
    pes = tuple(replace(pe, rotating=False) for pe in fabric.pes)
    return replace(fabric, routing=Routing(), pes=pes)


def unrotated(fabric: Fabric) -> Fabric:
    """The fabric with register files that do not rotate: the MRRG knows all options but that one.
    Its mappings are mappings to the fabric but for the names of registers (`named_anew`).
    """
    return _made_unrotated(fabric) if any(pe.rotating for pe in fabric.pes) else fabric


@once_each
def _made_unrotated(fabric: Fabric) -> Fabric:
    pes = tuple(replace(pe, rotating=False) for pe in fabric.pes)
    return replace(fabric, pes=pes)


def named_anew(problem: MapProblem, mapping: Mapping) -> Mapping | None:
    """A mapping to the plain core with registers of rotating files named as these need it; None if
    the words do not fit so.
    """
    if not any(pe.rotating for pe in problem.fabric.pes):
        return mapping
    lifetimes: dict[int, list[tuple[Lifetime, list[_StepKey]]]] = defaultdict(list)
    for keys in _lifetimes(problem, mapping):
        word, pe, first = keys[0]
        lifetimes[pe].append((Lifetime(word, first, keys[-1][2]), keys))
    names: dict[_StepKey, int] = {}
    for pe, here in lifetimes.items():
        file = problem.fabric.pes[pe]
        chosen = allocate(
            [lifetime for lifetime, _ in here], mapping.ii, file.registers, rotating=file.rotating
        )
        if chosen is None:
            return None
        for (_, keys), name in zip(here, chosen, strict=True):
            names |= dict.fromkeys(keys, name)
    routes = {
        index: tuple(_named(step, problem.dfg.edges[index].src, names) for step in route)
        for index, route in mapping.routes.items()
    }
    return replace(mapping, routes=routes)


def _lifetimes(problem: MapProblem, mapping: Mapping) -> list[list[_StepKey]]:
    """Cycles in a row in which a word is in one register."""
    held: dict[tuple[int, int, int], int] = {}
    for index, route in mapping.routes.items():
        for step in route:
            if step.kind == "reg":
                held[problem.dfg.edges[index].src, step.pe, step.time] = step.index
    runs: list[list[_StepKey]] = []
    for key in sorted(held):
        before = (key[0], key[1], key[2] - 1)
        if runs and runs[-1][-1] == before and held[before] == held[key]:
            runs[-1].append(key)
        else:
            runs.append([key])
    return runs


def _named(step: Step, word: int, names: dict[_StepKey, int]) -> Step:
    if step.kind != "reg":
        return step
    return replace(step, index=names[word, step.pe, step.time])

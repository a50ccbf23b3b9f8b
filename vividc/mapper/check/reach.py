"""Where words can get on a fabric, for the check of bounds: derived from docs/machine.md alone."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from vividc.arch.fabric import Fabric


def readable_from(fabric: Fabric) -> list[set[int]]:
    """For each PE, the PEs that can ever read a word made there.

    Links carry words on and on, or FUs move them between the output registers that they share;
    else a word is read where it was made, and by neighbours that share its output register.
    """
    routing = fabric.routing
    next_to: dict[int, set[int]] = {pe.id: set() for pe in fabric.pes}
    if routing.hops or routing.shared:
        for link in fabric.links:
            next_to[link.src].add(link.dst)
    if not routing.hops and not (routing.shared and routing.moves):
        return [{pe.id} | next_to[pe.id] for pe in fabric.pes]
    return [_all_behind(pe.id, next_to) for pe in fabric.pes]


def _all_behind(start: int, next_to: dict[int, set[int]]) -> set[int]:
    behind, fresh = {start}, {start}
    while fresh:
        fresh = {to for item in fresh for to in next_to[item]} - behind
        behind |= fresh
    return behind


def connected(items: Collection[int], pairs: Iterable[tuple[int, int]]) -> list[set[int]]:
    """The items in groups that pairs join, either way round."""
    next_to: dict[int, set[int]] = {item: set() for item in items}
    for one, other in pairs:
        next_to[one].add(other)
        next_to[other].add(one)
    groups: list[set[int]] = []
    for item in sorted(items):
        if not any(item in group for group in groups):
            groups.append(_all_behind(item, next_to))
    return groups

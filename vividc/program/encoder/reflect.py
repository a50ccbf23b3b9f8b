"""A program for one tile as the program of its mirror image: every PE's words move to the PE that
stands in its place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vividc.arch.fabric import Fabric
from vividc.arch.yaml.reflect import is_isomorphism
from vividc.errors import InternalError
from vividc.program.program import Program
from vividc.program.tables import Home
from vividc.program.words.entry import Entry, Issue, Operand, Sel, Select, faults
from vividc.program.words.layout import word_layout
from vividc.program.words.pack import pack


def reflected_program(program: Program, fabric: Fabric, places: tuple[int, ...]) -> Program:
    """The program on `fabric`, with PE `p` of the program's fabric standing at `places[p]`.

    A mapping is legal by what PEs have, by which of them are joined and by times, none of which an
    isomorphism changes: the result is as legal as `program`, and every word of it is checked
    against its PE. It takes the same cycles and gives the same memory.

    Raises
    ------
    InternalError
        `places` is no isomorphism of the fabrics, or a PE cannot do what its words ask for.
    """
    if not is_isomorphism(program.fabric, fabric, places):
        raise InternalError(f"{fabric.name} is not a mirror image of {program.fabric.name}")
    layout = word_layout(fabric)
    words = np.zeros_like(program.words)
    for context, row in enumerate(program.entries):
        for pe, entry in enumerate(row):
            moved = _entry(entry, pe, program.fabric, fabric, places)
            wrong = faults(moved, fabric, places[pe])
            if wrong:
                raise InternalError(f"PE {places[pe]} of {fabric.name} lacks {wrong[0]}")
            words[context, places[pe]] = pack(layout, moved)
    order = np.argsort(places)
    return replace(
        program,
        fabric=fabric,
        words=words,
        images=program.images[order],
        images_set=program.images_set[order],
        launch=tuple(replace(row, pe=places[row.pe]) for row in program.launch),
        return_home=_home(program.return_home, places),
        return_high=_home(program.return_high, places),
        debug=tuple(replace(row, pe=places[row.pe]) for row in program.debug),
    )


def _home(home: Home | None, places: tuple[int, ...]) -> Home | None:
    return None if home is None else Home(places[home.pe], home.entry)


def _entry(entry: Entry, pe: int, fabric: Fabric, other: Fabric, places: tuple[int, ...]) -> Entry:
    incoming = _ports_in(pe, fabric, other, places)

    def moved(select: Select) -> Select:
        return Select(Sel.LINK, incoming[select.index]) if select.kind is Sel.LINK else select

    capture = entry.capture
    return replace(
        entry,
        issue=None if entry.issue is None else _issue(entry.issue, incoming),
        links=_links(tuple(map(moved, entry.links)), pe, fabric, other, places),
        writes=tuple(replace(write, select=moved(write.select)) for write in entry.writes),
        capture=None if capture is None else replace(capture, select=moved(capture.select)),
    )


def _issue(issue: Issue, incoming: tuple[int, ...]) -> Issue:
    def moved(operand: Operand) -> Operand:
        if operand.select.kind is not Sel.LINK:
            return operand
        return replace(operand, select=Select(Sel.LINK, incoming[operand.select.index]))

    a, b, c = issue.operands
    operands = (moved(a), moved(b), moved(c))
    return replace(issue, operands=operands, predicate=moved(issue.predicate))


def _ports_in(pe: int, fabric: Fabric, other: Fabric, places: tuple[int, ...]) -> tuple[int, ...]:
    """For each incoming link of `pe` its place among those of the PE that stands for it."""
    sources = [link.src for link in other.links_to[places[pe]]]
    return tuple(sources.index(places[link.src]) for link in fabric.links_to[pe])


def _links(
    drives: tuple[Select, ...], pe: int, fabric: Fabric, other: Fabric, places: tuple[int, ...]
) -> tuple[Select, ...]:
    targets = [link.dst for link in other.links_from[places[pe]]]
    moved = [Select(Sel.NONE)] * len(drives)
    for link, drive in zip(fabric.links_from[pe], drives, strict=False):
        moved[targets.index(places[link.dst])] = drive
    return tuple(moved)

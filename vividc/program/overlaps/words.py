"""What the words of a region that belong to two at once are made of, and how they are parted."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from vividc.machine.opcodes import MEMORY, OPCODES
from vividc.program.dataflow import Constant, FlowOp, RegionFlow
from vividc.program.words.entry import NOTHING, Entry, Issue, Operand, Sel, Select, Write

Contexts = list[list[Entry]]
"""Entries by context and PE."""


class Contradiction(Exception):
    """What is wrong with words that belong to two regions."""


def regular(flow: RegionFlow | None, what: str) -> RegionFlow:
    if flow is None:
        raise Contradiction(f"{what} are of no regular form")
    return flow


def demand(holds: bool, otherwise: str) -> None:
    if not holds:
        raise Contradiction(otherwise)


def entries_read(op: FlowOp) -> Iterator[Constant]:
    """Entries of constant stores that an operation reads, in whatever iteration."""
    for read in (*op.reads, *(() if op.predicate is None else (op.predicate,))):
        if isinstance(read.source, Constant):
            yield read.source
        if read.first is not None:
            yield read.first
    if op.issue.op in MEMORY:
        yield Constant(op.pe, op.issue.base)


def _operands(issue: Issue) -> tuple[Operand, ...]:
    return (*issue.operands[: OPCODES[issue.op].arity], issue.predicate)


def driven(entry: Entry) -> Iterator[Select]:
    """What drives links and registers."""
    for select in (*entry.links, *(write.select for write in entry.writes)):
        if select.kind is not Sel.NONE:
            yield select


def registers_written(entries: Sequence[Entry]) -> list[tuple[int, int]]:
    """(PE, register) of each write in a context."""
    return [
        (pe, write.register)
        for pe, entry in enumerate(entries)
        for write in entry.writes
        if write.select.kind is not Sel.NONE
    ]


def registers_read(entry: Entry, first: int | None = None) -> Iterator[int]:
    """The registers whose words count; `first`: the stage of a loop's first iteration, which reads
    an entry of the constant store in place of what it would carry.
    """
    selects = [*driven(entry)]
    if entry.issue is not None:
        is_first = entry.issue.stage == first
        operands = _operands(entry.issue)
        selects += [one.select for one in operands if one.first is None or not is_first]
    if entry.capture is not None:
        selects.append(entry.capture.select)
    for select in selects:
        if select.kind is Sel.RF:
            yield entry.reads[select.index]


Times = Mapping[tuple[int, int, bool, int], int]
"""By slot, PE, whether it is a link, and port: the cycle of an iteration in which it is driven."""


def times_of_moves(flow: RegionFlow) -> Times:
    """Of a loop's words that are passed on."""
    return {
        (move.slot, move.pe, move.is_link, move.port): flow.ops[move.op].time + move.age
        for move in flow.moves
    }


def part_of(
    entry: Entry,
    stage_of: Callable[[int], int | None],
    is_there: Callable[[bool, int], bool],
) -> Entry:
    """What an entry of a loop holds of some iterations.

    Parameters
    ----------
    stage_of
        The stage that an operation of a stage has there; None: its iteration is not among them.
    is_there
        Whether that of a link (True) or a write port, by its number, is.
    """
    issue, capture = entry.issue, entry.capture
    issued = None if issue is None else stage_of(issue.stage)
    captured = None if capture is None else stage_of(capture.stage)
    return Entry(
        None if issue is None or issued is None else replace(issue, stage=issued),
        tuple(s if is_there(True, port) else NOTHING for port, s in enumerate(entry.links)),
        entry.reads,
        tuple(w if is_there(False, port) else Write() for port, w in enumerate(entry.writes)),
        None if capture is None or captured is None else replace(capture, stage=captured),
    )


def without(merged: Entry, left: Entry) -> Entry:
    """An entry without a part, which it must have."""
    whole, part = _by_register(merged), _by_register(left)
    links = zip(whole.links, part.links, strict=True)
    has_links = all(p.kind is Sel.NONE or p == w for w, p in links)
    driven = {write for write in part.writes if write.select.kind is not Sel.NONE}
    demand(
        (part.issue is None or part.issue == whole.issue)
        and (part.capture is None or part.capture == whole.capture)
        and has_links
        and driven <= set(whole.writes),
        "the words do not hold what the loop does meanwhile",
    )
    return replace(
        merged,
        issue=merged.issue if part.issue is None else None,
        capture=merged.capture if part.capture is None else None,
        links=tuple(
            select if other.kind is Sel.NONE else NOTHING
            for select, other in zip(merged.links, part.links, strict=True)
        ),
        writes=tuple(
            Write() if named in driven else write
            for write, named in zip(merged.writes, whole.writes, strict=True)
        ),
    )


def _by_register(entry: Entry) -> Entry:
    """An entry whose selections name registers and not read ports."""

    def named(select: Select) -> Select:
        return Select(Sel.RF, entry.reads[select.index]) if select.kind is Sel.RF else select

    issue, capture = entry.issue, entry.capture
    if issue is not None:
        a, b, c = (replace(o, select=named(o.select)) for o in issue.operands)
        predicate = replace(issue.predicate, select=named(issue.predicate.select))
        issue = replace(issue, operands=(a, b, c), predicate=predicate)
    return Entry(
        issue,
        tuple(named(select) for select in entry.links),
        entry.reads,
        tuple(replace(write, select=named(write.select)) for write in entry.writes),
        None if capture is None else replace(capture, select=named(capture.select)),
    )

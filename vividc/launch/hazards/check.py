"""Refuses graphs whose result would depend on timing."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

import numpy as np

from vividc.errors import ArgumentError
from vividc.launch.flat import Ints, flat
from vividc.launch.hazards.races import END, PLACE, START, STEP, WRITES, first_race
from vividc.launch.memory import Buffers
from vividc.launch.steps import Execute, Pieces, Step, Transfer, kind_of


def check_order(steps: Sequence[Step], waits: Sequence[tuple[int, ...]], buffers: Buffers) -> None:
    """Any two steps that use the same bytes, one of them writing, must be ordered.

    Parameters
    ----------
    waits
        Steps that each step waits for.
    buffers
        The arrays of the transfers.

    Raises
    ------
    ArgumentError
        Two steps are not.
    """
    uses = np.concatenate((_of_scratchpads(steps), _of_dram(steps, buffers)))
    race = first_race(uses[uses[:, END] > uses[:, START]], *flat(waits))
    if race is None:
        return
    early, late, place = race
    where = f"the scratchpad of tile {place}" if place >= 0 else "one array"
    raise ArgumentError(
        f"step {late} ({kind_of(steps[late])}) and step {early} ({kind_of(steps[early])}) use the "
        f"same bytes of {where}, and their order is not given",
        hint=f"give step {late} `after=[{early}]`, or other places",
    )


def _of_scratchpads(steps: Sequence[Step]) -> Ints:
    """What each step uses of scratchpads (see `first_race`); tile t is place t."""
    rows: list[int] = []
    own: dict[int, frozenset[str]] = {}
    for number, step in enumerate(steps):
        if isinstance(step, Execute):
            program = step.program
            if id(program) not in own:
                own[id(program)] = frozenset(local.name for local in program.locals)
            for place in _extents(step, own[id(program)]):
                rows += (step.tile, *place[:2], number, place[2])
        elif isinstance(step, Transfer):
            start, end = step.extent(step.size)
            for tile in step.tiles:
                rows += (tile, start, end, number, not step.to_dram)
            if step.told_at is not None:
                rows += (step.tiles[0], *step.told_at, number, False)
    return np.array(rows, dtype=np.int64).reshape(-1, 5)


def _extents(step: Execute, own: frozenset[str]) -> Iterator[tuple[int, int, bool]]:
    """First byte, end and whether it is written, of each array of a run, and of what it stores."""
    for name, (start, end) in step.extents.items():
        yield start, end, name in own
    for start, end in step.stores.values():
        yield start, end, True


def _of_dram(steps: Sequence[Step], buffers: Buffers) -> Ints:
    """What each step uses of arrays in DRAM; array n is place -1 - n."""
    spans: list[Ints] = [np.empty((0, 2), dtype=np.int64)]
    users: list[tuple[int, int, bool]] = []
    transfers = [(n, step) for n, step in enumerate(steps) if isinstance(step, Transfer)]
    written = {step.pieces.buffer for _, step in transfers if step.to_dram}
    for number, step in transfers:
        pieces = _moved(step, written, buffers)
        for some, writes in ((pieces, step.to_dram), (step.index_pieces, False)):
            if some is not None:
                spans.append(some.spans)
                users.append((-1 - some.buffer, number, writes))
    counts = [len(part) for part in spans[1:]]
    used, by = np.concatenate(spans), np.array(users, dtype=np.int64).reshape(-1, 3)
    uses = np.empty((len(used), 5), dtype=np.int64)
    uses[:, START], uses[:, END] = used[:, 0], used.sum(axis=1)
    uses[:, (PLACE, STEP, WRITES)] = np.repeat(by, counts, axis=0)
    return uses


def _moved(step: Transfer, written: Container[int], buffers: Buffers) -> Pieces:
    """What a transfer may use of the array that it moves: by a list that no step writes, the rows
    that are there; by any other, all. Of an array that is only read it does not matter.
    """
    listed, table = step.indices, step.pieces.buffer
    if listed is None or table not in written or buffers.number(listed) in written:
        return step.pieces
    rows = np.unique(listed.astype(np.int64))
    return buffers.rows(step.view, rows[(rows >= 0) & (rows < len(step.view))], 1)

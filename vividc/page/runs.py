"""A run as data for the page: a window cycle by cycle, and how busy everything was in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from vividc.errors import ArgumentError, SimulationError, VividcError
from vividc.page.source import Data
from vividc.program import Program
from vividc.sim.run import simulate
from vividc.sim.stats import RegionStats
from vividc.sim.view import Recording, record
from vividc.sim.view.recording import NOTHING

WINDOW: Final = (0, 400)
"""Cycles that are recorded unless others are asked for: 300 kB of a page on a 4x4 array."""
MOST_CYCLES: Final = 5000


def run_data(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    window: tuple[int, int] = WINDOW,
) -> Data:
    """Run a program and return what the page shows of it; nothing of the caller's changes.

    A run that ends with an error is shown up to there.

    Raises
    ------
    VividcError
        The window is too long, or the run ends before it.
    ArgumentError
        The arguments do not fit.
    """
    first, end = window
    if end - first > MOST_CYCLES:
        raise VividcError(
            f"{end - first:,} cycles are more than a page takes, {MOST_CYCLES:,}",
            loc="--cycles",
            hint="name the cycles of interest: --cycles FIRST:END",
        )
    recording = record(program, args, kwargs, window=window)
    if recording.end <= first and recording.stopped is None:
        raise ArgumentError(
            f"the run ends before cycle {first:,}",
            loc="--cycles",
            hint="name cycles of the run: --cycles FIRST:END",
        )
    return {**_whole(program, args, kwargs), **_window(program, recording)}


def _whole(program: Program, args: Sequence[object], kwargs: Mapping[str, object]) -> Data:
    """The statistics of the run up to its end."""
    own = [_copied(value) for value in args], {k: _copied(value) for k, value in kwargs.items()}
    try:
        result = simulate(program, *own[0], **own[1])  # type: ignore[arg-type]
    except SimulationError as error:
        return {"cycles": None, "error": str(error), "regions": []}
    return {
        "cycles": result.cycles,
        "error": "",
        "value": "" if result.value is None else repr(result.value),
        "switch_cycles": result.stats["switch_cycles"],
        "reload_cycles": result.stats["reload_cycles"],
        "regions": [_region(region) for region in result.stats["regions"]],
    }


def _copied(value: object) -> object:
    return value.copy() if isinstance(value, np.ndarray) else value


def _region(stats: RegionStats) -> Data:
    return {
        "entries": stats["entries"],
        "iterations": stats["iterations"],
        "cycles": stats["cycles"],
        "stalls": sum(stats["stalls"].values()),
        "utilization": round(stats["utilization"], 4),
    }


def _window(program: Program, recording: Recording) -> Data:
    links, banks = len(program.fabric.links), program.fabric.scratchpad.banks
    issues: Counter[int] = Counter()
    accesses: Counter[int] = Counter()
    samples = []
    for number, cycle in enumerate(recording.cycles.tolist()):
        region, slot = int(recording.regions[number]), int(recording.slots[number])
        words = recording.words[number, :links].tolist()
        driven = [[link, word] for link, word in enumerate(words) if word != NOTHING]
        touched = [word % banks for word in recording.touched[number]]
        issued = []
        for one in recording.issued[number]:
            row = program.debug_row(region, slot, one.pe, "issue")
            issued.append([one.pe, None if row is None else row.node, one.iteration])
        issues.update(one.pe for one in recording.issued[number])
        accesses.update(touched)
        samples.append([cycle, region, slot, issued, driven, touched])
    carried = (recording.words[:, :links] != NOTHING).sum(axis=0).tolist()
    return {
        "first": recording.first,
        "end": recording.end,
        "stopped": recording.stopped or "",
        "samples": samples,
        "stalled": (np.flatnonzero(recording.stalled()) + recording.first).tolist(),
        "issues": [issues[pe] for pe in range(len(program.fabric.pes))],
        "carried": carried,
        "accesses": [accesses[bank] for bank in range(banks)],
    }

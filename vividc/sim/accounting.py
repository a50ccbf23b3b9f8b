"""Where cycles and words went: by use, by class and precision of operations, in bytes by level."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.machine.kinds import kind_of
from vividc.machine.opcodes import Opcode
from vividc.program import WORD_BYTES, RegionRow
from vividc.sim.engine import Activity, RegionRun, Run
from vividc.sim.native.plan.counts import Sums, together

USES: Final = ("steady", "prologue_epilogue", "straight", "bank_stall")
_LEVELS: Final = {
    "scratchpad_read": "scratchpad_reads",
    "scratchpad_written": "scratchpad_writes",
    "links": "link_words",
    "registers_read": "register_reads",
    "registers_written": "register_writes",
    "constants_read": "constant_reads",
    "constants_written": "constant_writes",
}


def cycles_by_use(row: RegionRow, region: RegionRun) -> dict[str, int]:
    """The cycles of a region by what they were for; they add up to `region.cycles`.

    K iterations of a loop take (K - 1) II + span cycles: K II of them are "steady", the rest is
    "prologue_epilogue", of all its runs together. "straight": a straight region. "bank_stall": the
    tile stood still.
    """
    return _uses(row, region, _steady(row, region))


def _uses(row: RegionRow, region: RegionRun, steady: int) -> dict[str, int]:
    cycles = dict.fromkeys(USES, 0)
    cycles["bank_stall"] = region.bank_stalls
    own = region.cycles - region.bank_stalls
    if row.kind == "straight":
        cycles["straight"] = own
        return cycles
    cycles["steady"] = steady
    cycles["prologue_epilogue"] = own - steady
    return cycles


def _steady(row: RegionRow, region: RegionRun) -> int:
    return min(region.iterations * row.ii, region.cycles - region.bank_stalls)


@dataclass(frozen=True, slots=True)
class Work:
    """What runs of one program did: `cycles` by use, issues by opcode, and words that moved."""

    cycles: Mapping[str, int]
    issued: Mapping[str, int]
    activity: Activity


def work_of(table: Sequence[RegionRow], runs: Sequence[Run]) -> Work:
    """Add up what runs did of a program with such regions."""
    cycles: Counter[str] = Counter(dict.fromkeys(USES, 0))
    issued: Counter[str] = Counter()
    moved: list[Activity] = []
    for rows, steady in _counted(table, runs):
        for row, region, at_ii in zip(table, rows, steady, strict=True):
            if region.entries:
                cycles.update(_uses(row, region, at_ii))
                issued.update(region.issued)
                moved.append(region.activity)
    return Work(cycles, issued, Activity.total(moved))


def _counted(
    table: Sequence[RegionRow], runs: Sequence[Run]
) -> Iterator[tuple[Sequence[RegionRun], Sequence[int]]]:
    """What was counted in each region, and how much of it was steady: of all runs of native code
    together, and of each other one.
    """
    native: list[Sums] = []
    for run in runs:
        if isinstance(run.counts, Sums):
            native.append(run.counts)
        else:
            rows = run.regions
            yield rows, [_steady(row, region) for row, region in zip(table, rows, strict=True)]
    if native:
        yield together(native, [row.ii for row in table])


def by_kind(issued: Mapping[str, int]) -> dict[str, dict[str, int]]:
    """Issues by latency class, and within it by precision, both in alphabetical order."""
    kinds: dict[str, Counter[str]] = {}
    for opcode, count in issued.items():
        name, precision = kind_of(Opcode(opcode))
        kinds.setdefault(name, Counter())[precision] += count
    return {name: dict(sorted(kinds[name].items())) for name in sorted(kinds)}


def bytes_by_level(activity: Activity) -> dict[str, int]:
    """Bytes that moved at each level: whole words, also for accesses of less than a word, as a
    bank, a link or a register moves no less.
    """
    return {name: WORD_BYTES * getattr(activity, count) for name, count in _LEVELS.items()}


def summed(tables: Iterable[Mapping[str, int]]) -> dict[str, int]:
    """The sum of tables, key by key, in the order in which the keys turn up."""
    total: dict[str, int] = {}
    for table in tables:
        for name, count in table.items():
            total[name] = total.get(name, 0) + count
    return total

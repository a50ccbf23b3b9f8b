"""Where cycles and words went: by use, by class and precision of operations, in bytes by level."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Final

from vividc.machine.kinds import kind_of
from vividc.machine.opcodes import Opcode
from vividc.program import WORD_BYTES, RegionRow
from vividc.sim.engine import Activity, RegionRun

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
    cycles = dict.fromkeys(USES, 0)
    cycles["bank_stall"] = region.bank_stalls
    own = region.cycles - region.bank_stalls
    if row.kind == "straight":
        cycles["straight"] = own
        return cycles
    cycles["steady"] = min(region.iterations * row.ii, own)
    cycles["prologue_epilogue"] = own - cycles["steady"]
    return cycles


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

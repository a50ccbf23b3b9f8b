"""Configuration words, region table, memory layout: one versioned bundle.

In order: `memory` (where arrays lie), `design` (graphs and mappings as text), `tables` (regions,
launch, reports), `bundle` (the `.vivid` file), `program`, `reloads` (of those longer than the
configuration memory), `dataflow` (where each word comes from),
`overlaps/` (words that belong to two regions), `faults` (contradictions in one) and
`reading`, `kept` (in the cache); `words/` (the configuration word), `encoder/` (from mappings to
words), `disasm`.
"""

from vividc.dfg.regions import loop_behind
from vividc.machine.params import HIGH_SUFFIX, MAX_DIMENSION, DType, LocalArray, Param, joined
from vividc.machine.words import WORD_BYTES
from vividc.program.disasm import disassemble
from vividc.program.encoder.encode import encode
from vividc.program.memory import pitch_words, pitches_of, place_arrays, trapped
from vividc.program.program import CUT_SHORT, Program
from vividc.program.reading import from_bytes, load
from vividc.program.tables import (
    BoundReport,
    DebugRow,
    Home,
    LaunchRow,
    Option,
    Provenance,
    RefutationReport,
    RegionReport,
    RegionRow,
)
from vividc.program.words.decode import decode, unpack
from vividc.program.words.entry import Capture, Entry, Issue, Operand, Sel, Select, Use, Write
from vividc.program.words.layout import Field, WordLayout, word_layout
from vividc.program.words.pack import pack

__all__ = [
    "CUT_SHORT",
    "HIGH_SUFFIX",
    "MAX_DIMENSION",
    "WORD_BYTES",
    "BoundReport",
    "Capture",
    "DType",
    "DebugRow",
    "Entry",
    "Field",
    "Home",
    "Issue",
    "LaunchRow",
    "LocalArray",
    "Operand",
    "Option",
    "Param",
    "Program",
    "Provenance",
    "RefutationReport",
    "RegionReport",
    "RegionRow",
    "Sel",
    "Select",
    "Use",
    "WordLayout",
    "Write",
    "decode",
    "disassemble",
    "encode",
    "from_bytes",
    "joined",
    "load",
    "loop_behind",
    "pack",
    "pitch_words",
    "pitches_of",
    "place_arrays",
    "trapped",
    "unpack",
    "word_layout",
]

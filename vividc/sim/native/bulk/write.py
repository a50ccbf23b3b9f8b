"""A loop region in the form of tables (see `tables`) as LLVM IR.

A loop over bodies, in it one over slots, in it one over the entries of each section. The state lies
in the context's spill words, so that a suspended loop finds all of it where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BYTES
from vividc.sim.native.bulk.tables import LANES, VECTORS, BulkTables, Kind, Section
from vividc.sim.native.bulk.vectors import FLAGS, VECTOR_DECLARATIONS, WORDS, multiply_add, splat
from vividc.sim.native.plan.layout import BOUND_OF_WIDTH, Place, Status
from vividc.sim.native.write.body import Key, Surroundings
from vividc.sim.native.write.ending import COUNTERS, End, finish, finish_empty
from vividc.sim.native.write.frame import Frame
from vividc.sim.native.write.operations import lower
from vividc.sim.native.write.text import FALSE, Code

_SERIAL: Final = 1 << 16
"""More than the accesses of a cycle."""
_CARRIED: Final = ("body", "row", "stalls", "reads", "writes")
"""Words of a suspended loop, before its arrays."""

DECLARATIONS: Final = (
    VECTOR_DECLARATIONS
    + f"declare void @llvm.masked.store.v{LANES}i32.p0({WORDS}, ptr, i32, {FLAGS})\n"
    "declare void @llvm.memmove.p0.p0.i64(ptr, ptr, i64, i1)\n"
    "declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)\n"
)


@dataclass(frozen=True)
class _Places:
    """Of the arrays among the spill words, in 32-bit words."""

    banks: int
    constants: int
    rows: int
    kept: int
    end: int

    @staticmethod
    def of(tables: BulkTables, banks: int) -> _Places:
        first = 2 * len(_CARRIED)
        constants = first + 2 * (banks + 1)
        rows = constants + tables.constant_words + LANES
        kept = rows + tables.row_words
        return _Places(
            first, constants, rows, kept, kept + len(tables.kept) * tables.kept_words + LANES
        )


def bulk_words(tables: BulkTables, banks: int) -> int:
    """Words of the context that a loop needs."""
    return _Places.of(tables, banks).end // 2 + 1


def write_bulk(frame: Frame, around: Surroundings, tables: BulkTables, first: int) -> None:
    """Write a loop, to its end; `first` is its first word among all tables."""
    _Bulk(frame, around, tables, first).write()
    frame.code.start("empty")
    finish_empty(frame)


class _Bulk:
    def __init__(self, frame: Frame, around: Surroundings, tables: BulkTables, first: int) -> None:
        self._frame = frame
        self._code: Code = frame.code
        self._tables = tables
        self._around = around
        self._places = _Places.of(tables, frame.machine.banks)
        self._ii = frame.flow.row.ii
        self._first = first
        self._state = self._words = ""
        self._now: dict[str, str] = {}

    def write(self) -> None:
        """Write all of it except the path around a loop without iterations."""
        code, frame = self._code, self._frame
        self._state = code.at("%context", "i64", frame.machine.layout.spill)
        address = frame.get(Place.TABLES)
        pointer = code.value(f"inttoptr i64 {address} to ptr")
        self._words = code.at(pointer, "i32", self._first)
        before = code.value(f"sub i64 {frame.trip}, 1")
        cycles = code.value(f"mul i64 {before}, {self._ii}")
        end = code.value(f"add i64 {cycles}, {frame.flow.row.span}")
        resumed = code.value(f"icmp ne i64 {frame.get(Place.RESUME)}, 0")
        code.do(f"br i1 {resumed}, label %header, label %fresh")
        code.start("fresh")
        self._begin()
        code.do("br label %header")
        self._bodies(end)

    def _begin(self) -> None:
        code = self._code
        for number, name in enumerate(_CARRIED):
            code.store("i64", str(self._tables.reach if name == "row" else 0), self._state, number)
        size = 8 * (self._frame.machine.banks + 1)
        place = self._array(self._places.banks)
        code.do(f"call void @llvm.memset.p0.i64(ptr {place}, i8 0, i64 {size}, i1 false)")
        for constant, index in self._tables.constants.items():
            code.store(
                "i32", self._around.constants[constant], self._state, self._places.constants + index
            )

    def _array(self, place: int) -> str:
        return self._code.at(self._state, "i32", place)

    def _bodies(self, end: str) -> None:
        code, frame = self._code, self._frame
        code.start("header")
        values = {
            name: code.load("i64", self._state, number) for number, name in enumerate(_CARRIED)
        }
        frame.set(Place.RESUME, "0")
        time = code.value(f"mul i64 {values['body']}, {self._ii}")
        more = code.value(f"icmp slt i64 {time}, {end}")
        code.do(f"br i1 {more}, label %go, label %finish")
        code.start("go")
        now = code.value(f"add i64 {time}, {values['stalls']}")
        now = code.value(f"add i64 {now}, {frame.base}")
        over = code.value(f"icmp sgt i64 {now}, {frame.get(Place.CYCLE_LIMIT)}")
        code.do(f"br i1 {over}, label %limit, label %within")
        code.start("within")
        late = code.value(f"icmp sgt i64 {now}, {frame.get(Place.BUDGET)}")
        code.do(f"br i1 {late}, label %suspend, label %work")
        code.start("suspend")
        frame.set(Place.RESUME, "1")
        frame.set(Place.NOW, now)
        code.do(f"ret i32 {Status.SUSPENDED:d}")
        code.start("work")
        self._body(values, time)
        code.do("br label %header")
        code.start("finish")
        sums: dict[Key, str] = {(name,): "0" for name in COUNTERS}
        sums |= {(name,): values[name] for name in ("stalls", "reads", "writes")}
        finish(frame, End(frame.trip, end, "", sums, ""))

    def _body(self, values: Mapping[str, str], time: str) -> None:
        """The slots of one body; the window moves where it is at its end."""
        code = self._code
        carried = {name: values[name] for name in ("stalls", "reads", "writes")}
        row = self._slide(values["row"])

        def one_slot(slot: str, inside: dict[str, str]) -> dict[str, str]:
            serial = code.value(f"add i64 {time}, {slot}")
            at = code.value(f"add i64 {row}, {slot}")
            return self._slot(slot, serial, at, values["body"], inside)

        kinds = dict.fromkeys(carried, "i64") | {"fault": "i1"}
        after = repeat(code, "0", str(self._ii), kinds, carried | {"fault": FALSE}, one_slot)
        code.do(f"br i1 {after['fault']}, label %fault, label %sound")
        code.start("sound")
        after["body"] = code.value(f"add i64 {values['body']}, 1")
        after["row"] = code.value(f"add i64 {row}, {self._ii}")
        for number, name in enumerate(_CARRIED):
            code.store("i64", after[name], self._state, number)

    def _slide(self, row: str) -> str:
        """The row of the body's first cycle, with the rows that are read before it."""
        code, tables = self._code, self._tables
        full = code.value(f"icmp eq i64 {row}, {tables.rows}")
        before = code.block
        code.do(f"br i1 {full}, label %slide, label %room")
        code.start("slide")
        size = WORD_BYTES * tables.reach * tables.pes
        start = self._places.rows + (tables.rows - tables.reach) * tables.pes
        self._move(self._places.rows, start, size)
        for number in range(len(tables.kept)):
            place = self._places.kept + number * tables.kept_words
            self._move(place + tables.rows - tables.reach, place, WORD_BYTES * tables.reach)
        code.do("br label %room")
        code.start("room")
        return code.value(f"phi i64 [ {row}, %{before} ], [ {tables.reach}, %slide ]")

    def _move(self, target: int, source: int, size: int) -> None:
        to, start = self._array(target), self._array(source)
        self._code.do(
            f"call void @llvm.memmove.p0.p0.i64(ptr {to}, ptr {start}, i64 {size}, i1 false)"
        )

    # One slot

    def _slot(
        self, slot: str, serial: str, row: str, body: str, inside: dict[str, str]
    ) -> dict[str, str]:
        code, tables = self._code, self._tables
        rows = code.value(f"mul i64 {row}, {tables.pes}")
        aged = code.value(f"sub i64 {tables.rows - 1}, {row}")
        floor = code.value(f"mul i64 {serial}, {_SERIAL}")
        self._now = {
            Kind.ROW.name: self._from(self._array(self._places.rows), rows),
            Kind.DIAGONAL.name: self._from(self._array(self._places.kept), aged),
            Kind.CONSTANT.name: self._array(self._places.constants),
            "banks": self._array(self._places.banks),
            "floor": floor,
            "body": body,
        }
        values = inside | {"busiest": floor}
        for section in tables.sections:
            values = self._section(section, slot, values)
        beyond = code.value(f"sub i64 {values.pop('busiest')}, {floor}")
        beyond = code.value(f"sub i64 {beyond}, 1")
        stall = code.value(f"call i64 @llvm.smax.i64(i64 {beyond}, i64 0)")
        values["stalls"] = code.value(f"add i64 {values['stalls']}, {stall}")
        return values

    def _from(self, pointer: str, index: str) -> str:
        return self._code.value(f"getelementptr i32, ptr {pointer}, i64 {index}")

    def _section(self, section: Section, slot: str, values: dict[str, str]) -> dict[str, str]:
        code, variant = self._code, section.variant
        starts = self._from(self._words, code.value(f"add i64 {slot}, {section.starts}"))
        first = code.value(f"sext i32 {code.load('i32', starts)} to i64")
        last = code.value(f"sext i32 {code.load('i32', starts, 1)} to i64")
        entries = code.at(self._words, "i32", section.entries)

        def one(index: str, inside: dict[str, str]) -> dict[str, str]:
            offset = code.value(f"mul i64 {index}, {variant.width}")
            entry = self._from(entries, offset)
            if variant.op is Opcode.LOAD:
                return self._load(section, entry, inside)
            if variant.op is Opcode.STORE:
                return self._store(section, entry, inside)
            if variant.op in VECTORS:
                self._multiply(section, entry)
            else:
                self._scalar(section, entry)
            return inside

        if not variant.is_memory:
            repeat(code, first, last, {}, {}, one)
            return values
        changed = ("reads" if variant.op is Opcode.LOAD else "writes", "busiest", "fault")
        kinds = {name: "i1" if name == "fault" else "i64" for name in changed}
        after = repeat(code, first, last, kinds, {name: values[name] for name in changed}, one)
        return values | after

    def _field(self, entry: str, number: int) -> str:
        """A field of an entry, i64."""
        return self._code.value(f"sext i32 {self._code.load('i32', entry, number)} to i64")

    def _operand(self, kind: Kind, entry: str, number: int) -> str:
        """Word of operand `number`."""
        code = self._code
        if kind is Kind.COUNTER:
            stage = self._field(entry, 1 + number)
            iteration = code.value(f"sub i64 {self._now['body']}, {stage}")
            return code.value(f"trunc i64 {iteration} to i32")
        return code.load("i32", self._from(self._now[kind.name], self._field(entry, 1 + number)))

    def _scalar(self, section: Section, entry: str) -> None:
        code, variant = self._code, section.variant
        words = [self._operand(kind, entry, k) for k, kind in enumerate(variant.kinds)]
        word = lower(code, variant.op, words)
        code.store("i32", word, self._from(self._now[Kind.ROW.name], self._field(entry, 0)))

    def _multiply(self, section: Section, entry: str) -> None:
        code, variant = self._code, section.variant
        words = [self._vector(kind, entry, k) for k, kind in enumerate(variant.kinds)]
        word = multiply_add(code, variant.op, words)
        mask = code.load("i32", entry, 1 + len(words))
        flags = code.value(f"trunc i32 {mask} to i{LANES}")
        lanes = code.value(f"bitcast i{LANES} {flags} to {FLAGS}")
        place = self._from(self._now[Kind.ROW.name], self._field(entry, 0))
        code.do(
            f"call void @llvm.masked.store.v{LANES}i32.p0({WORDS} {word}, ptr {place}, "
            f"i32 {WORD_BYTES}, {FLAGS} {lanes})"
        )

    def _vector(self, kind: Kind, entry: str, number: int) -> str:
        """Words of operand `number`, lane by lane."""
        code = self._code
        if kind is Kind.COUNTER:
            first = self._operand(kind, entry, number)
            one = code.value(f"insertelement {WORDS} poison, i32 {first}, i64 0")
            zeros = splat("0")
            all_of = code.value(f"shufflevector {WORDS} {one}, {WORDS} poison, {WORDS} {zeros}")
            lanes = ", ".join(f"i32 {lane}" for lane in range(LANES))
            return code.value(f"sub {WORDS} {all_of}, <{lanes}>")
        place = self._from(self._now[kind.name], self._field(entry, 1 + number))
        return code.value(f"load {WORDS}, ptr {place}, align {WORD_BYTES}")

    # Memory

    def _access(self, section: Section, entry: str) -> tuple[str, str, str]:
        """Address, whether the access happens, and whether it is live and outside its array."""
        code, variant = self._code, section.variant
        after = 1 + len(variant.kinds)
        index = self._operand(variant.kinds[0], entry, 0)
        if variant.shift:
            index = code.value(f"shl i32 {index}, {variant.shift}")
        base = self._from(self._now[Kind.CONSTANT.name], self._field(entry, after))
        address = code.value(f"add i32 {code.load('i32', base)}, {index}")
        address = code.value(f"add i32 {address}, {code.load('i32', entry, after + 1)}")
        iteration = code.value(f"sub i64 {self._now['body']}, {self._field(entry, after + 2)}")
        live = code.value(f"icmp ult i64 {iteration}, {self._frame.trip}")
        first, *bounds = self._around.extents[variant.array]
        offset = code.value(f"sub i32 {address}, {first}")
        bound = bounds[BOUND_OF_WIDTH[WORD_BYTES] - 1]
        within = code.value(f"icmp ult i32 {offset}, {bound}")
        low = code.value(f"and i32 {address}, {WORD_BYTES - 1}")
        inside = code.both(within, code.value(f"icmp eq i32 {low}, 0"))
        happens = code.both(live, inside)
        return address, happens, code.both(live, code.negated(inside))

    def _load(self, section: Section, entry: str, inside: dict[str, str]) -> dict[str, str]:
        code = self._code
        address, happens, missed = self._access(section, entry)
        place = self._byte(code.choose(happens, "i32", address, "0"))
        word = code.value(f"load i32, ptr {place}, align {WORD_BYTES}")
        word = code.choose(happens, "i32", word, "0")
        code.store("i32", word, self._from(self._now[Kind.ROW.name], self._field(entry, 0)))
        if section.variant.kept:
            number = section.variant.width - 1
            kept = self._from(self._now[Kind.DIAGONAL.name], self._field(entry, number))
            code.store("i32", word, kept)
        return self._counted("reads", address, happens, missed, inside)

    def _store(self, section: Section, entry: str, inside: dict[str, str]) -> dict[str, str]:
        code = self._code
        address, happens, missed = self._access(section, entry)
        slack = str(self._frame.machine.memory_bytes)
        place = self._byte(code.choose(happens, "i32", address, slack))
        word = self._operand(section.variant.kinds[1], entry, 1)
        code.do(f"store i32 {word}, ptr {place}, align {WORD_BYTES}")
        return self._counted("writes", address, happens, missed, inside)

    def _byte(self, address: str) -> str:
        index = self._code.extended(address)
        return self._code.value(f"getelementptr i8, ptr %memory, i64 {index}")

    def _counted(
        self, name: str, address: str, happens: str, missed: str, inside: dict[str, str]
    ) -> dict[str, str]:
        """A bank counts the accesses of a cycle above a number that grows with the cycles, so that
        none is ever set back.
        """
        code, floor = self._code, self._now["floor"]
        word = code.value(f"lshr i32 {address}, 2")
        bank = code.value(f"urem i32 {word}, {self._frame.machine.banks}")
        bank = code.extended(bank)
        place = code.value(f"getelementptr i64, ptr {self._now['banks']}, i64 {bank}")
        seen = code.value(f"call i64 @llvm.smax.i64(i64 {code.load('i64', place)}, i64 {floor})")
        seen = code.counted(seen, happens)
        code.store("i64", seen, place)
        busiest = f"call i64 @llvm.smax.i64(i64 {inside['busiest']}, i64 {seen})"
        return {
            name: code.counted(inside[name], happens),
            "busiest": code.value(busiest),
            "fault": code.either(inside["fault"], missed),
        }


Step = Callable[[str, dict[str, str]], dict[str, str]]


def repeat(
    code: Code,
    first: str,
    last: str,
    kinds: Mapping[str, str],
    start: Mapping[str, str],
    step: Step,
) -> dict[str, str]:
    """A loop over first <= index < last, i64; the carried values after it.

    Parameters
    ----------
    kinds, start
        Type and initial value of each carried value.
    step
        Writes the loop's body for an index and carried values, and returns their next values.
    """
    label = code.fresh("repeat")
    before = code.block
    code.do(f"br label %{label}")
    code.start(label)
    phis = len(code.lines)
    index = f"%{label}.index"
    values = {name: f"%{label}.{name}" for name in kinds}
    code.lines += [""] * (1 + len(kinds))
    more = code.value(f"icmp slt i64 {index}, {last}")
    code.do(f"br i1 {more}, label %{label}.do, label %{label}.done")
    code.start(f"{label}.do")
    after = step(index, dict(values))
    following = code.value(f"add i64 {index}, 1")
    code.do(f"br label %{label}")
    latch = code.block
    code.lines[phis] = f"  {index} = phi i64 [ {first}, %{before} ], [ {following}, %{latch} ]"
    for number, (name, kind) in enumerate(kinds.items()):
        incoming = f"[ {start[name]}, %{before} ], [ {after[name]}, %{latch} ]"
        code.lines[phis + 1 + number] = f"  {values[name]} = phi {kind} {incoming}"
    code.start(f"{label}.done")
    return values

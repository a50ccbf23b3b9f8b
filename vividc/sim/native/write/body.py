"""One body of a region as LLVM IR: II cycles of whatever is live.

Three kinds of body exist. A *straight* region runs one, in which all is live. A loop has a
*general* one, which asks for each stage whether its iteration is live, and a *steady* one for when
all are. Operations without effects are computed in any case: nothing live reads a dead result.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BYTES
from vividc.program import Use
from vividc.program.dataflow import Constant, Counter, FlowCapture, FlowOp, Read, Result
from vividc.sim.native.plan.layout import BOUND_OF_WIDTH, Layout
from vividc.sim.native.plan.schedule import Schedule
from vividc.sim.native.write.operations import lower
from vividc.sim.native.write.text import FALSE, TRUE, Code

Mode = Literal["straight", "general", "steady"]
Key = tuple[str | int, ...]
"""Of a value that bodies hand on: ("result", operation, bodies ago), ("stalls",), ..."""


@dataclass(frozen=True)
class Machine:
    """What bodies need to know of the tile."""

    layout: Layout
    memory_bytes: int
    banks: int


@dataclass
class Surroundings:
    """Values that are the same in all bodies of a region's run.

    Attributes
    ----------
    constants
        Constant-store entries that the region reads and does not write.
    extents
        First byte, and the three bounds, of each array.
    """

    constants: Mapping[Constant, str]
    extents: Mapping[str, tuple[str, ...]]


@dataclass
class Access:
    """A memory operation of a slot: whether it touches a bank, and where."""

    touches: str
    address: str


@dataclass
class Body:
    """Writes one body.

    Parameters
    ----------
    values
        Carried values at the start; `finish` gives those at the end.
    number
        Number of the body, i64.
    limit, exited, resolved
        Iterations from this one on are dead; the one that ended the loop; the last one known to go
        on or end. As at the start of the body.
    """

    code: Code
    machine: Machine
    plan: Schedule
    mode: Mode
    around: Surroundings
    values: dict[Key, str]
    number: str = "0"
    limit: str = ""
    exited: str = ""
    resolved: str = ""
    fault: str = FALSE
    branch: str = ""
    trip: str = ""
    _now: dict[int, str] = field(default_factory=dict)
    _iterations: dict[int, str] = field(default_factory=dict)
    _live: dict[int, str] = field(default_factory=dict)
    _first: dict[int, str] = field(default_factory=dict)

    def slot(self, number: int) -> None:
        """Everything of one slot."""
        accesses = []
        for index in self.plan.ops[number]:
            op = self.plan.flow.ops[index]
            if op.issue.op is Opcode.STORE:
                accesses.append(self._store(op))
                continue
            if op.issue.op is Opcode.LOAD:
                access, word = self._load(op)
                accesses.append(access)
            else:
                word = self._computed(op)
            self._now[index] = word
            self._inform(op, word)
        if len(accesses) > 1:
            self._stall(accesses)
        for capture in self.plan.captures[number]:
            self._capture(capture)

    def finish(self) -> dict[Key, str]:
        """The carried values at the end."""
        for index, depth in enumerate(self.plan.depth):
            for age in range(depth, 1, -1):
                self.values["result", index, age] = self.values["result", index, age - 1]
            if depth:
                self.values["result", index, 1] = self._now[index]
        return self.values

    # Liveness

    def _iteration(self, stage: int) -> str:
        """Number of the iteration in a stage, i64."""
        if stage not in self._iterations:
            self._iterations[stage] = (
                self.code.value(f"sub i64 {self.number}, {stage}") if stage else self.number
            )
        return self._iterations[stage]

    def _is_live(self, stage: int) -> str:
        if self.mode != "general":
            return TRUE
        if stage not in self._live:
            # As unsigned numbers, iterations before the first are beyond every limit.
            iteration = self._iteration(stage)
            self._live[stage] = self.code.value(f"icmp ult i64 {iteration}, {self.limit}")
        return self._live[stage]

    def _is_first(self, stage: int) -> str:
        if self.mode != "general":
            return TRUE if self.mode == "straight" else FALSE
        if stage not in self._first:
            self._first[stage] = self.code.value(f"icmp eq i64 {self._iteration(stage)}, 0")
        return self._first[stage]

    def _exits(self, stage: int) -> str:
        """Whether the iteration in a stage is known to have ended the loop."""
        if self.mode != "general" or not self.exited:
            return FALSE
        return self.code.value(f"icmp eq i64 {self._iteration(stage)}, {self.exited}")

    # Operands and operations

    def _read(self, read: Read, time: int) -> str:
        stage = self.plan.stage(time)
        first = FALSE if read.first is None else self._is_first(stage)
        if first == TRUE:
            assert read.first is not None
            return self._constant(read.first)
        later = self._source(read.source, time, stage)
        if first == FALSE:
            return later
        assert read.first is not None
        return self.code.choose(first, "i32", self._constant(read.first), later)

    def _source(self, source: Constant | Counter | Result, time: int, stage: int) -> str:
        if isinstance(source, Constant):
            return self._constant(source)
        if isinstance(source, Result):
            lag = self.plan.lag(time, source.age)
            return self.values["result", source.op, lag] if lag else self._now[source.op]
        if self.mode == "straight":
            return "0"
        return self.code.value(f"trunc i64 {self._iteration(stage)} to i32")

    def _constant(self, constant: Constant) -> str:
        carried = self.values.get(("constant", constant.pe, constant.entry))
        return self.around.constants[constant] if carried is None else carried

    def _predicate(self, op: FlowOp) -> str:
        if op.predicate is None:
            return TRUE
        return self.code.value(f"icmp ne i32 {self._read(op.predicate, op.time)}, 0")

    def _computed(self, op: FlowOp) -> str:
        words = [self._read(read, op.time) for read in op.reads]
        word = lower(self.code, op.issue.op, words)
        return self.code.choose(self._predicate(op), "i32", word, words[-1])

    def _inform(self, op: FlowOp, word: str) -> None:
        if op.issue.use is Use.BRANCH:
            self.branch = word
        elif op.issue.use is Use.TRIP:
            self.trip = word

    def _capture(self, capture: FlowCapture) -> None:
        code = self.code
        stage = self.plan.stage(capture.time)
        happens = self._is_live(stage)
        if capture.unless_exit:
            happens = code.both(happens, code.negated(self._exits(stage)))
        word = self._source(capture.source, capture.time, stage)
        target = capture.target
        key: Key = ("constant", target.pe, target.entry)
        self.values[key] = code.choose(happens, "i32", word, self.values[key])
        self._count(("constant_writes",), happens)
        if capture.from_register:
            self._count(("capture_reads",), happens)
        bit = self.machine.layout.bits.get(target)
        if bit is not None:
            valid: Key = ("valid", bit)
            self.values[valid] = code.choose(happens, "i32", "1", self.values[valid])

    def _count(self, key: Key, condition: str) -> None:
        self.values[key] = self.code.counted(self.values[key], condition)

    # Memory

    def _address(self, op: FlowOp) -> str:
        code, issue = self.code, op.issue
        index = self._read(op.reads[0], op.time)
        if issue.shift:
            index = code.value(f"shl i32 {index}, {issue.shift}")
        base = self._constant(Constant(op.pe, issue.base))
        address = code.value(f"add i32 {base}, {index}")
        return code.value(f"add i32 {address}, {issue.offset}") if issue.offset else address

    def _in_array(self, op: FlowOp, address: str) -> str:
        first, *bounds = self.around.extents[op.array]
        bound = bounds[BOUND_OF_WIDTH[op.issue.width] - 1]
        offset = self.code.value(f"sub i32 {address}, {first}")
        inside = self.code.value(f"icmp ult i32 {offset}, {bound}")
        return self.code.both(inside, self._aligned(op, address))

    def _aligned(self, op: FlowOp, address: str) -> str:
        if op.issue.width == 1:
            return TRUE
        low = self.code.value(f"and i32 {address}, {op.issue.width - 1}")
        return self.code.value(f"icmp eq i32 {low}, 0")

    def _load(self, op: FlowOp) -> tuple[Access, str]:
        code, issue = self.code, op.issue
        active = code.both(self._is_live(self.plan.stage(op.time)), self._predicate(op))
        address = self._address(op)
        inside = self._in_array(op, address)
        missed = code.both(active, code.negated(inside))
        if self.plan.flow.exit is None:
            self.fault = code.either(self.fault, missed)
            reads = code.both(active, inside)
        else:
            self._miss(op, missed)
            bound = self.machine.memory_bytes - issue.width + 1
            exists = code.value(f"icmp ult i32 {address}, {bound}")
            reads = code.both(active, code.both(exists, self._aligned(op, address)))
        place = self._pointer(code.choose(reads, "i32", address, "0"))
        bits = 8 * issue.width
        word = code.value(f"load i{bits}, ptr {place}, align {issue.width}")
        if issue.width < WORD_BYTES:
            extend = "sext" if issue.signed else "zext"
            word = code.value(f"{extend} i{bits} {word} to i32")
        self._count(("reads",), reads)
        return Access(reads, address), code.choose(reads, "i32", word, "0")

    def _miss(self, op: FlowOp, missed: str) -> None:
        """A load outside its array: an error, now or when its iteration turns out to count."""
        code = self.code
        stage = self.plan.stage(op.time)
        iteration = self._iteration(stage)
        if op.issue.unless_exit:
            missed = code.both(missed, code.negated(self._exits(stage)))
            counts = code.value(f"icmp sle i64 {iteration}, {self.resolved}")
        else:
            counts = code.value(f"icmp sle i64 {self._iteration(stage + 1)}, {self.resolved}")
        self.fault = code.either(self.fault, code.both(missed, counts))
        key: Key = ("open", "unless_exit" if op.issue.unless_exit else "always")
        earliest = code.value(f"call i64 @llvm.smin.i64(i64 {iteration}, i64 {self.values[key]})")
        self.values[key] = code.choose(missed, "i64", earliest, self.values[key])

    def _store(self, op: FlowOp) -> Access:
        code, issue = self.code, op.issue
        stage = self.plan.stage(op.time)
        active = code.both(self._is_live(stage), self._predicate(op))
        if issue.unless_exit:
            active = code.both(active, code.negated(self._exits(stage)))
        address = self._address(op)
        inside = self._in_array(op, address)
        self.fault = code.either(self.fault, code.both(active, code.negated(inside)))
        writes = code.both(active, inside)
        place = self._pointer(code.choose(writes, "i32", address, str(self.machine.memory_bytes)))
        bits = 8 * issue.width
        word = self._read(op.reads[1], op.time)
        if issue.width < WORD_BYTES:
            word = code.value(f"trunc i32 {word} to i{bits}")
        code.do(f"store i{bits} {word}, ptr {place}, align {issue.width}")
        self._count(("writes",), writes)
        return Access(writes, address)

    def _pointer(self, address: str) -> str:
        index = self.code.extended(address)
        return self.code.value(f"getelementptr i8, ptr %memory, i64 {index}")

    def _stall(self, accesses: list[Access]) -> None:
        """The tile stands still for as long as the busiest bank has further accesses."""
        code = self.code
        banks = [self._bank(access, number) for number, access in enumerate(accesses)]
        longest = ""
        for number, bank in enumerate(banks[:-1]):
            behind = [code.value(f"icmp eq i32 {bank}, {other}") for other in banks[number + 1 :]]
            waiting = [code.value(f"zext i1 {meets} to i32") for meets in behind]
            total = waiting[0]
            for one in waiting[1:]:
                total = code.value(f"add i32 {total}, {one}")
            longest = (
                code.value(f"call i32 @llvm.smax.i32(i32 {longest}, i32 {total})")
                if longest
                else total
            )
        stall = code.extended(longest)
        self.values[("stalls",)] = code.value(f"add i64 {self.values[('stalls',)]}, {stall}")

    def _bank(self, access: Access, number: int) -> str:
        """Bank of an access; one that does not happen has one of its own."""
        word = self.code.value(f"lshr i32 {access.address}, 2")
        bank = self.code.value(f"urem i32 {word}, {self.machine.banks}")
        return self.code.choose(access.touches, "i32", bank, str(-1 - number))

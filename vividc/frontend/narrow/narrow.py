"""From LLVM's integers of 64 bits and doubles to the machine's words of 32 bits.

Integers: a value is represented by its low word. Sums, products, left shifts and logic need no more
of their operands, so they stay exact; comparisons, right shifts, divisions and conversions need the
whole value. Where ranges prove that the word determines it (sign-extended or zero-extended), that
is all; else its high word is computed, too (`demand_high`, `wide.rules`).

Doubles run in float32. `Narrowed.demoted` names the lines where this may change a result. A
conversion of a float to a 64-bit integer is taken to fit in 32 bits, and saturates: its lines are
`Narrowed.saturated`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.advice import Advice
from vividc.frontend.llvm.calls import (
    RAISE_PREFIX,
    RETURNED,
    TRAP_PREFIX,
    USER_PREFIX,
    hint_of_raise,
)
from vividc.frontend.narrow import (
    bits as narrow_bits,
)
from vividc.frontend.narrow import (
    float as narrow_float,
)
from vividc.frontend.narrow import (
    formats as narrow_format,
)
from vividc.frontend.narrow import (
    integer as narrow_int,
)
from vividc.frontend.narrow.emit import ALIASES, Emitter, word_type
from vividc.frontend.narrow.wide.phis import high_phis
from vividc.frontend.narrow.wide.rules import saturates_wide, translate_wide
from vividc.frontend.narrow.wide.words import Words
from vividc.frontend.ranges.interval import S32, U32, contains
from vividc.frontend.ranges.known import ranges_of
from vividc.frontend.ranges.ranges import Ranges
from vividc.host import time_limit
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import WIDE_DTYPES, DType, base_of
from vividc.ssa.ir import Block, Branch, Function, Input, Instr, Phi, Value


@dataclass(frozen=True, slots=True)
class Narrowed:
    """The kernel in words, and the lines where a result may differ from numba's."""

    function: Function
    demoted: tuple[SourceLoc | None, ...]
    saturated: tuple[SourceLoc | None, ...]


def narrow(function: Function) -> Narrowed:
    """Translate a function whose memory accesses are resolved.

    Raises
    ------
    KernelError
        A construct that the array cannot run, or an integer that has no rule in two words.
    """
    returns = function.returns
    narrower = _Narrower(function, ranges_of(function), returns)
    blocks = tuple(narrower.block(block, returns) for block in function.blocks)
    words = narrower.with_high_words(blocks)
    emitter = narrower.emitter
    return Narrowed(
        replace(function, blocks=words, inputs=(), result=""),
        tuple(dict.fromkeys(emitter.demoted)),
        tuple(dict.fromkeys(emitter.saturated)),
    )


class _Narrower:
    """Translates block by block. Results are numbered beforehand: a phi may name a later one."""

    def __init__(self, function: Function, ranges: Ranges, returns: DType | None) -> None:
        self._function = function
        self._names = {block.name: f"b{index}" for index, block in enumerate(function.blocks)}
        ids = {id_: index for index, id_ in enumerate(_results(function))}
        self.emitter = Emitter(function, ranges, ids, returned=returns in WIDE_DTYPES)

    def block(self, block: Block, returns: DType | None) -> Block:
        """One block."""
        time_limit.step("it was lowered")
        emitter = self.emitter
        emitter.start(block.name)
        phis = tuple(
            Phi(
                emitter.ids[phi.id],
                word_type(phi.type),
                tuple((self._names[pred], emitter.value(v)) for pred, v in phi.incoming),
                phi.loc,
            )
            for phi in block.phis
        )
        for op in block.instrs:
            if not translate_wide(emitter, op):
                _translate(emitter, op)
        branch = self._branch(block, returns)
        return Block(self._names[block.name], phis, tuple(emitter.instrs), branch)

    def with_high_words(self, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
        """The blocks with the phis of high words and what their predecessors compute for them."""
        changed = {block.name: block for block in blocks}
        for high in high_phis(self.emitter, self._names):
            for source, instrs in high.computed.items():
                block = changed[self._names[source]]
                changed[block.name] = replace(block, instrs=(*block.instrs, *instrs))
            block = changed[self._names[high.block]]
            changed[block.name] = replace(block, phis=(*block.phis, high.phi))
        return tuple(changed.values())

    def _branch(self, block: Block, returns: DType | None) -> Branch:
        leave = block.branch
        if leave.unreachable:
            raise KernelError("the kernel can reach code that has no meaning", loc=leave.loc)
        targets = [self._names[target] for target in leave.successors]
        if not targets:
            return self._return(leave, returns)
        if leave.cond is None:
            return Branch(targets[0], loc=leave.loc)
        return Branch(targets[0], self.emitter.value(leave.cond), targets[1], loc=leave.loc)

    def _return(self, leave: Branch, returns: DType | None) -> Branch:
        if leave.value is None or returns is None:
            return Branch(loc=leave.loc)
        low = self.emitter.value(leave.value)
        high: Value | None = None
        if returns in WIDE_DTYPES and not self._returns_words(returns):
            high = self._high(leave)
        return Branch(value=low, high=high, loc=leave.loc)

    def _returns_words(self, returns: DType) -> bool:
        """Whether every returned value is its word, read as the type says."""
        fits = S32 if returns is DType.I64 else U32
        return all(
            contains(fits, self.emitter.range_at(block.branch.value, block.name))
            for block in self._function.blocks
            if block.branch.value is not None
        )

    def _high(self, leave: Branch) -> Value:
        assert leave.value is not None
        return Words(self.emitter, Instr(-1, "ret", "i64", (), loc=leave.loc)).high(leave.value)


def _results(function: Function) -> list[int]:
    """Results that become instructions or phis of their own."""
    return [
        item.id
        for block in function.blocks
        for item in block.items
        if isinstance(item, Phi) or (item.has_result and (item.op not in ALIASES or _masks(item)))
    ]


def _masks(op: Instr) -> bool:
    """A conversion that computes: to or from less than a word."""
    return narrow_int.computes(op)


def _translate(emitter: Emitter, op: Instr) -> None:
    if op.op == "bitcast" and "float" not in (op.type, op.source):
        raise KernelError(f"the bits of a {op.source}", loc=op.loc, hint=_NUMBERS)
    if op.op in ALIASES and not _masks(op):
        return
    if op.op == "call":
        _call(emitter, op)
    elif op.op == "load":
        _memory(emitter, op, Opcode.LOAD, (op.operands[0],))
    elif op.op == "store":
        _memory(emitter, op, Opcode.STORE, (op.operands[1], op.operands[0]))
    elif op.op == "select":
        emitter.emit(op, Opcode.SELECT, tuple(emitter.value(arg) for arg in op.operands))
    elif op.op in narrow_float.RULES:
        narrow_float.RULES[op.mnemonic](emitter, op)
    elif op.op in narrow_int.RULES:
        narrow_int.RULES[op.mnemonic](emitter, op)
    else:
        raise KernelError(f"LLVM's `{op.op}` cannot run on the array", loc=op.loc)


def _memory(emitter: Emitter, op: Instr, opcode: Opcode, operands: tuple[Value, ...]) -> None:
    instr = Instr(
        emitter.id_of(op),
        opcode,
        word_type(op.type) if opcode is Opcode.LOAD else Type.NONE,
        (Input(base_of(op.array)), *(emitter.value(operand) for operand in operands)),
        array=op.array,
        shift=op.shift,
        offset=op.offset,
        width=op.width,
        signed=op.signed,
        subscript=op.subscript,
        loc=op.loc,
    )
    emitter.instrs.append(instr)


def refuse_calls(function: Function) -> None:
    """Refuse a kernel that calls what the array cannot run; a raise may yet prove unreachable."""
    for block in function.blocks:
        for op in block.instrs:
            if op.op != "call" or _is_told(op) or saturates_wide(op):
                continue
            if _call_rule(op) is None:
                raise _refused(op)


def _is_told(op: Instr) -> bool:
    """A call that only tells of a raise, or of what is returned."""
    return op.pred.startswith((RAISE_PREFIX, USER_PREFIX, TRAP_PREFIX, RETURNED))


def _call(emitter: Emitter, op: Instr) -> None:
    rule = _call_rule(op)
    if rule is None:
        raise _refused(op)
    rule(emitter, op)


_TYPES = re.compile(r"(\.[a-z]+\d+)+$")


def _stem(callee: str) -> str:
    if not callee.startswith("llvm."):
        return callee
    return _TYPES.sub("", callee.removeprefix("llvm."))


def _call_rule(op: Instr) -> narrow_int.Rule | None:
    stem = _stem(op.pred)
    tables = (narrow_float.CALLS, narrow_int.CALLS, narrow_bits.CALLS, narrow_format.CALLS)
    return next((table[stem] for table in tables if stem in table), None)


_NUMBERS = Advice("use float32 and int32", c="use float and int32_t")
_RUNTIME = re.compile("NRT_|numba_gil|_?Py[A-Z]?[A-Za-z]*_")
_MEMORY = "an array has a constant size, or is a parameter"
_OUTPUT = "a kernel stores its results into arrays"
_LEAVE = "return, with a flag stored or returned"
_INSTEAD = {
    **dict.fromkeys(("malloc", "calloc", "realloc", "free", "aligned_alloc"), _MEMORY),
    **dict.fromkeys(("puts", "putchar", "fputs", "fputc", "fwrite", "fflush"), _OUTPUT),
    **dict.fromkeys(("exit", "abort", "_exit", "__assert_fail"), _LEAVE),
    **dict.fromkeys(("rand", "random", "srand", "time", "clock"), "pass its numbers in an array"),
}
"""What to write instead of a function of C's library."""


def _refused(op: Instr) -> KernelError:
    callee = op.pred
    if callee.startswith(RAISE_PREFIX):
        what = callee.removeprefix(RAISE_PREFIX).removesuffix(": ")
        return KernelError(f"the kernel can raise {what}", loc=op.loc, hint=hint_of_raise(what))
    if callee.startswith("numba_") and not callee.startswith("numba_gil"):
        reason = f"a call of numba's `{callee.removeprefix('numba_')}`, which the array cannot run"
        return KernelError(reason, loc=op.loc, hint="write it with loops and arithmetic")
    if _RUNTIME.match(callee):
        hint = "print and objects are for the host: a kernel stores its results into arrays"
        return KernelError("the kernel calls the Python runtime", loc=op.loc, hint=hint)
    if callee.startswith("llvm.stacksave"):
        reason = "something that numba keeps in memory of a size which only the run knows"
        return KernelError(reason, loc=op.loc, hint="write the loop over the elements")
    hint = _INSTEAD.get(callee, "supported: abs, min, max, pow and the functions of docs/math.md")
    reason = f"a call of `{_stem(callee)}`, which the array cannot run"
    return KernelError(reason, loc=op.loc, hint=hint)

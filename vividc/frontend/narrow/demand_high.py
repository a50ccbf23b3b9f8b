"""Which 64-bit integers need their high word computed: those that something reads beyond the word,
and that the word does not determine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from vividc.frontend.ranges.interval import S32, U32, Interval, contains
from vividc.frontend.ranges.ranges import Ranges
from vividc.machine.words import WORD_BITS
from vividc.ssa.ir import Branch, Function, Instr, Int, Key, Named, Phi, Value, result_type

WIDE = "i64"
COMPARING_CALLS = frozenset({"smin", "smax", "umin", "umax", "abs", "scmp", "ucmp"})
WHOLE_CALLS = frozenset(
    {
        "usub.sat",
        "uadd.sat",
        "ssub.sat",
        "sadd.sat",
        "fshl",
        "fshr",
        "ctpop",
        "ctlz",
        "cttz",
        "bswap",
        "bitreverse",
    }
)
_RING = frozenset({"add", "sub", "or", "xor"})
_TO_FLOAT = frozenset({"sitofp", "uitofp"})


def stem(callee: str) -> str:
    """`llvm.usub.sat.i64` -> `usub.sat`."""
    return callee.removeprefix("llvm.").rsplit(".", 1)[0] if callee.startswith("llvm.") else callee


@dataclass(frozen=True, slots=True)
class WordFacts:
    """What is known of words in one block.

    Attributes
    ----------
    ranges
        Intervals of all integers.
    demand
        Low bits of each result that anything reads.
    types
        LLVM type of each local.
    block
        Where the questions are asked.
    """

    ranges: Ranges
    demand: dict[Key, int]
    types: dict[Key, str]
    block: str

    def range(self, operand: Value) -> Interval:
        """Values of an operand in the block."""
        return self.ranges.at(operand, self.block)

    def signed(self, *operands: Value) -> bool:
        """Whether sign-extending the words gives the values."""
        return all(contains(S32, self.range(operand)) for operand in operands)

    def unsigned(self, *operands: Value) -> bool:
        """Whether zero-extending the words gives the values."""
        return all(contains(U32, self.range(operand)) for operand in operands)

    def fit(self, *operands: Value) -> bool:
        """Whether the words, all read as signed or all as unsigned, are the values."""
        return self.signed(*operands) or self.unsigned(*operands)

    def type_of(self, *operands: Value) -> str:
        """LLVM type of the first operand that is no constant."""
        keys = [operand.key for operand in operands if isinstance(operand, Named)]
        return self.types.get(keys[0], "") if keys else ""


def reads_high(op: Instr, facts: WordFacts, *, wanted: bool) -> tuple[Value, ...]:
    """Operands of which `op` reads both words: () where their low words do.

    Parameters
    ----------
    wanted
        Whether the high word of the result is wanted, too.
    """
    if op.op == "call":
        return _of_call(op, facts, wanted=wanted)
    if (op.source if op.op in _TO_FLOAT else op.type) != WIDE:
        return ()
    rule = _WHOLE.get(op.mnemonic)
    if rule is not None:
        return rule(op, facts, wanted)
    return tuple(_of_low_bits(op)) if wanted else ()


def _of_low_bits(op: Instr) -> Iterator[Value]:
    """Operations whose low word depends on low words only."""
    if op.op == "and":
        yield from (arg for arg, other in _both_ways(op) if not _has_no_high(other))
    elif op.op == "mul" or op.op in _RING:
        yield from op.operands
    elif op.op == "select":
        yield from op.operands[1:]
    elif op.op == "freeze":
        yield from op.operands
    elif op.op == "shl":
        amount = op.operands[1]
        if not isinstance(amount, Int) or amount.value < WORD_BITS:
            yield op.operands[0]


def _both_ways(op: Instr) -> tuple[tuple[Value, Value], ...]:
    a, b = op.operands
    return (a, b), (b, a)


def _has_no_high(operand: Value) -> bool:
    return isinstance(operand, Int) and 0 <= operand.value < 1 << WORD_BITS


def _of_comparison(op: Instr, facts: WordFacts, _: bool) -> tuple[Value, ...]:
    return () if facts.fit(*op.operands) else op.operands


def _of_shift_right(op: Instr, facts: WordFacts, wanted: bool) -> tuple[Value, ...]:
    value, amount = op.operands
    if wanted:
        return (value,)
    if isinstance(amount, Int):
        bits = min(facts.demand.get(op.id, 0), WORD_BITS)
        return () if amount.value + bits <= WORD_BITS or facts.fit(value) else (value,)
    if op.op == "lshr" and facts.range(value)[0] < 0:
        return (value,)
    return () if facts.fit(value) else (value,)


def _of_division(op: Instr, facts: WordFacts, wanted: bool) -> tuple[Value, ...]:
    if wanted:
        return op.operands
    signed = op.mnemonic[0] == "s"
    fits = (facts.unsigned(arg) or (signed and facts.signed(arg)) for arg in op.operands)
    return () if all(fits) else op.operands


def _of_call(op: Instr, facts: WordFacts, *, wanted: bool) -> tuple[Value, ...]:
    name = stem(op.pred)
    values = op.operands[: 1 if name in ("abs", "ctlz", "cttz") else 2]
    if name in COMPARING_CALLS:
        compared = op.type if name not in ("scmp", "ucmp") else facts.type_of(*values)
        if compared != WIDE:
            return ()
        return op.operands[: len(values)] if wanted or not _compares(name, facts, values) else ()
    if name in WHOLE_CALLS and op.type == WIDE:
        if name == "usub.sat" and not wanted and facts.unsigned(*values):
            return ()
        return values
    return ()


def _compares(name: str, facts: WordFacts, values: tuple[Value, ...]) -> bool:
    """Whether the comparison is one of words."""
    if name in ("abs", "scmp"):
        return facts.signed(*values)
    # Sign extension keeps the unsigned order, too.
    return name != "ucmp" and facts.fit(*values)


def _of_conversion(op: Instr, facts: WordFacts, _: bool) -> tuple[Value, ...]:
    """Whole, unless the integer converted to a float is a word."""
    fits = facts.unsigned(*op.operands) or (op.op == "sitofp" and facts.signed(*op.operands))
    return () if fits else op.operands


_WHOLE: dict[str, Callable[[Instr, WordFacts, bool], tuple[Value, ...]]] = {
    "icmp": _of_comparison,
    "lshr": _of_shift_right,
    "ashr": _of_shift_right,
    "sdiv": _of_division,
    "udiv": _of_division,
    "srem": _of_division,
    "urem": _of_division,
    # Python's, rounded down.
    "sfloordiv": _of_division,
    "sfloorrem": _of_division,
    "ufloordiv": _of_division,
    "ufloorrem": _of_division,
    "sitofp": _of_conversion,
    "uitofp": _of_conversion,
}


def high_words(
    function: Function, ranges: Ranges, demand: dict[Key, int], *, returned: bool
) -> frozenset[Key]:
    """Keys of the results, phis and parameters whose high word must be computed.

    Parameters
    ----------
    returned
        Whether the kernel returns an integer of 64 bits.
    """
    return _Search(function, ranges, demand).run(returned=returned)


class _Search:
    """Backwards from what reads whole integers."""

    def __init__(self, function: Function, ranges: Ranges, demand: dict[Key, int]) -> None:
        self._function = function
        self._ranges = ranges
        self._demand = demand
        self._types = types_of(function)
        self._found: set[Key] = set()
        self._pending: list[Key] = []

    def run(self, *, returned: bool) -> frozenset[Key]:
        for block in self._function.blocks:
            facts = self.facts(block.name)
            for op in block.instrs:
                self._want(reads_high(op, facts, wanted=False), facts)
            if returned:
                self._want(_returned(block.branch), facts)
        while self._pending:
            self._trace(self._pending.pop())
        return frozenset(self._found)

    def facts(self, block: str) -> WordFacts:
        return WordFacts(self._ranges, self._demand, self._types, block)

    def _trace(self, key: Key) -> None:
        definition = self._function.definitions.get(key)
        if isinstance(definition, Phi):
            for pred, value in definition.incoming:
                self._want((value,), self.facts(pred))
        elif definition is not None:
            facts = self.facts(self._function.block_of[key])
            self._want(reads_high(definition, facts, wanted=True), facts)

    def _want(self, operands: tuple[Value, ...], facts: WordFacts) -> None:
        for operand in operands:
            if not isinstance(operand, Named) or operand.key in self._found:
                continue
            if not facts.fit(operand):
                self._found.add(operand.key)
                self._pending.append(operand.key)


def _returned(leave: Branch) -> tuple[Value, ...]:
    return (leave.value,) if leave.value is not None else ()


def types_of(function: Function) -> dict[Key, str]:
    """LLVM type of each parameter, phi and result."""
    types: dict[Key, str] = dict(function.inputs)
    for block in function.blocks:
        types |= {item.id: result_type(item) for item in block.items}
    return types

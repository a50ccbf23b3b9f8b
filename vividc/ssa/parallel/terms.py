"""From SSA values to `parallel.Term`: which values an index can have, as far as the loops and
conditions around an access bound it.
"""

from __future__ import annotations

from collections.abc import Sequence

from vividc.machine.opcodes import Opcode
from vividc.machine.parallel import (
    ANY,
    CHOICE,
    CLAMPS,
    CONST,
    COUNTER,
    INDEX,
    INPUT,
    STEPS,
    UNION,
    Term,
)
from vividc.machine.words import WORD_BITS, WORD_BYTES, signed
from vividc.ssa.analysis.counters import bounded, header_test
from vividc.ssa.analysis.induction import Induction, induction_of
from vividc.ssa.analysis.polynomial import Polynomial
from vividc.ssa.flow import Loop, dominators, find_loops, immediate_dominators, predecessors
from vividc.ssa.ir import Block, Const, Function, Input, Instr, Phi, Ref, Value
from vividc.ssa.parallel.wide_counters import Pair, WideCounter, is_word, wide_counter

Fact = tuple[int, bool]
"""A condition's id, and how it was decided."""

_ARITHMETIC = frozenset(
    {
        Opcode.MOV,
        Opcode.ADD,
        Opcode.SUB,
        Opcode.MUL,
        Opcode.MULHU,
        Opcode.AND,
        Opcode.OR,
        Opcode.XOR,
        Opcode.SHL,
        Opcode.LSHR,
        Opcode.ASHR,
        Opcode.SMIN,
        Opcode.SMAX,
        Opcode.SDIV,
        Opcode.UDIV,
        Opcode.SREM,
        Opcode.UREM,
    }
)
_PREDICATES = frozenset(op for op in Opcode if op.value.startswith(("icmp", "fcmp")))
_DECIDED = frozenset(op for op in Opcode if op.value.startswith("icmp"))


class TermTable:
    """The terms of one function, each made once.

    Parameters
    ----------
    index
        Id of the parallel loop's variable.
    """

    def __init__(self, function: Function, index: int) -> None:
        self.terms: list[Term] = []
        self._function = function
        self._index = index
        self._numbers: dict[Term, int] = {}
        self._known: dict[tuple[Value, frozenset[Fact]], int] = {}
        self._open: set[tuple[Value, frozenset[Fact]]] = set()
        self._blocks = {block.name: block for block in function.blocks}
        self._home = {i.id: b for b in function.blocks for i in b.items}
        self._values = {i.id: i for b in function.blocks for i in b.items}
        self._loops = {loop.header: loop for loop in find_loops(function)}
        found = {name: wide_counter(function, loop) for name, loop in self._loops.items()}
        self._wide = {name: wide for name, wide in found.items() if wide is not None}
        self._wide_tests = {wide.test: wide for wide in self._wide.values()}
        self._facts = _facts_of_blocks(function)
        self._dominators = dominators(function)

    def facts(self, block: str) -> frozenset[Fact]:
        """What is decided wherever a block runs."""
        return self._facts.get(block, frozenset())

    def of(self, value: Value, facts: frozenset[Fact] = frozenset()) -> int:
        """Number of the term of a value, given what is decided."""
        key = (value, facts)
        if key in self._known:
            return self._known[key]
        if key in self._open:
            return self._add(Term(ANY, word=WORD_BITS))
        self._open.add(key)
        number = self._of(value, facts)
        self._open.remove(key)
        self._known[key] = number
        return number

    def sum_of(self, polynomial: Polynomial, facts: frozenset[Fact] = frozenset()) -> int:
        """Number of the term of a polynomial in values."""
        total = self._add(Term(CONST, word=polynomial.coefficient()))
        for monomial, factor in polynomial.terms.items():
            if not monomial:
                continue
            part = self.of(monomial[0], facts)
            for value in monomial[1:]:
                part = self._add(Term(Opcode.MUL.value, (part, self.of(value, facts))))
            if factor != 1:
                by = self._add(Term(CONST, word=factor))
                part = self._add(Term(Opcode.MUL.value, (part, by)))
            total = self._add(Term(Opcode.ADD.value, (total, part)))
        return total

    def anything(self) -> int:
        """The term of which nothing is known."""
        return self._add(Term(ANY, word=WORD_BITS))

    def counters_around(self, block: str, outermost: Loop) -> tuple[int, ...] | None:
        """Terms of the variables of the loops within `outermost` around a block that runs in every
        iteration of all of them; None if it does not, or a loop ends otherwise than by its test.
        """
        around = [
            loop
            for loop in self._loops.values()
            if block in loop.blocks and loop.blocks < outermost.blocks
        ]
        around.sort(key=lambda loop: len(loop.blocks))
        counters = []
        inside = block
        for loop in (*around, outermost):
            if any(inside not in self._dominators[latch] for latch in loop.latches):
                return None
            inside = loop.header
            if loop is outermost:
                break
            counter, wide = self._counter(loop), self._wide.get(loop.header)
            phi = wide.phi if wide is not None else None if counter is None else counter[0].phi
            if phi is None or [source for source, _ in loop.exits] != [loop.header]:
                return None
            counters.append(self.counter_itself(loop.header, phi.id))
        return tuple(counters)

    def counter_itself(self, header: str, phi: int) -> int:
        """Term of a loop's counter, wherever it is looked at."""
        return self._unclamped(self.of(Ref(phi), self.facts(header)))

    def _unclamped(self, number: int) -> int:
        while self.terms[number].op in CLAMPS:
            number = self.terms[number].args[0]
        return number

    def _add(self, term: Term) -> int:
        if term not in self._numbers:
            self._numbers[term] = len(self.terms)
            self.terms.append(term)
        return self._numbers[term]

    def _of(self, value: Value, facts: frozenset[Fact]) -> int:
        value = self._function.settled(value)
        if isinstance(value, Const):
            return self._add(Term(CONST, word=signed(value.word)))
        if isinstance(value, Input):
            number = self._add(Term(INPUT, key=value.key))
        elif value == Ref(self._index):
            number = self._add(Term(INDEX))
        else:
            assert isinstance(value, Ref)
            definition = self._values[value.id]
            number = (
                self._phi(definition, facts)
                if isinstance(definition, Phi)
                else self._instr(definition, facts)
            )
        for fact in sorted(facts):
            number = self._clamped(number, value, *fact)
        return number

    def _instr(self, instr: Instr, facts: frozenset[Fact]) -> int:
        if instr.op is Opcode.LOAD and instr.width < WORD_BYTES and not instr.signed:
            return self._add(Term(ANY, word=8 * instr.width))
        if instr.op in _PREDICATES and instr.op not in _DECIDED:
            return self._add(Term(ANY, word=1))
        if instr.op is Opcode.SELECT and isinstance(instr.operands[0], Ref):
            cond = instr.operands[0].id
            yes = self.of(instr.operands[1], facts | {(cond, True)})
            no = self.of(instr.operands[2], facts | {(cond, False)})
            return self._add(Term(CHOICE, (self.of(instr.operands[0], facts), yes, no)))
        if instr.op not in _ARITHMETIC and instr.op not in _DECIDED:
            return self._add(Term(ANY, word=WORD_BITS))
        args = tuple(self.of(operand, facts) for operand in instr.operands)
        return self._add(Term(instr.op.value, args))

    def _phi(self, phi: Phi, facts: frozenset[Fact]) -> int:
        block = self._home[phi.id]
        loop = self._loops.get(block.name)
        if loop is not None:
            return self._induction(phi, loop, facts)
        parts = tuple(
            self.of(value, facts | self.facts(source) | _edge(self._blocks[source], block.name))
            for source, value in phi.incoming
        )
        return self._add(Term(UNION, parts))

    def _induction(self, phi: Phi, loop: Loop, facts: frozenset[Fact]) -> int:
        wide = self._wide.get(loop.header)
        if wide is not None and wide.phi.id == phi.id:
            around = self.facts(loop.header)
            ends = (self._word_of(pair, around) for pair in (wide.start, wide.limit))
            return self._add(Term(COUNTER, (*ends, self._add(Term(CONST, word=wide.step)))))
        moves = induction_of(self._function, loop.blocks, phi)
        if moves is None or moves.start is None or moves.update.op is not Opcode.ADD:
            return self._add(Term(ANY, word=WORD_BITS))
        counter = self._counter(loop)
        if counter is None:
            return self._inclusive(moves, moves.start, loop)
        if counter[0].start is None:
            return self._add(Term(ANY, word=WORD_BITS))
        base, stride, limit = counter
        around = self.facts(loop.header)
        if phi.id == base.phi.id:
            bounds = (self.of(moves.start, around), self.of(limit, around), self.of(moves.by))
            return self._add(Term(COUNTER, bounds))
        distance = self._distance(counter[0].start, limit, around)
        count = self._count(distance, stride, self._goes_on(loop) in facts)
        return self._add(
            Term(STEPS, (self.of(moves.start, around), self.of(moves.by, around), count))
        )

    def _word_of(self, pair: Pair, facts: frozenset[Fact]) -> int:
        """The term of an integer in two words, which may be anything where it is no word."""
        low, tests = self.of(pair[0], facts), self._tests((pair,), facts)
        return low if tests is None else self._add(Term(CHOICE, (tests, low, self.anything())))

    def _below(self, number: int, wide: WideCounter, facts: frozenset[Fact]) -> int:
        """The term of a counter in two words where its loop goes on."""
        below = self._add(Term("lt", (number, self.of(wide.limit[0], facts))))
        tests = self._tests((wide.start, wide.limit), facts)
        return below if tests is None else self._add(Term(CHOICE, (tests, below, number)))

    def _tests(self, pairs: Sequence[Pair], facts: frozenset[Fact]) -> int | None:
        """The term of whether integers in two words are words; None: they are."""
        by = self._add(Term(CONST, word=WORD_BITS - 1))
        total: int | None = None
        for low, high in (pair for pair in pairs if not is_word(self._function, pair)):
            sign = self._add(Term(Opcode.ASHR.value, (self.of(low, facts), by)))
            one = self._add(Term(Opcode.ICMP_EQ.value, (self.of(high, facts), sign)))
            total = one if total is None else self._add(Term(Opcode.AND.value, (total, one)))
        return total

    def _inclusive(self, moves: Induction, start: Value, loop: Loop) -> int:
        """The counter of a loop that runs once more where it is at its limit: as if steps might be
        longer by one, so that nobody takes it for one whose values are known. One that may wrap may
        be anything, as the term of a counter is then.
        """
        test = header_test(self._function, loop, inclusive=True)
        around = self.facts(loop.header)
        for found, step, limit in () if test is None else bounded(self._function, loop, *test):
            if found.phi.id == moves.phi.id:
                longer = step + (1 if step > 0 else -1)
                steps = tuple(self._add(Term(CONST, word=by)) for by in (step, longer))
                by = self._add(Term(UNION, steps))
                return self._add(
                    Term(COUNTER, (self.of(start, around), self.of(limit, around), by))
                )
        return self._add(Term(ANY, word=WORD_BITS))

    def _goes_on(self, loop: Loop) -> Fact:
        branch = self._blocks[loop.header].branch
        assert isinstance(branch.cond, Ref)
        return branch.cond.id, branch.target in loop.blocks

    def _count(self, distance: int, stride: int, in_body: bool) -> int:
        """Iterations of a loop; one more where its variable is seen after the last."""
        if stride < 0:
            zero = self._add(Term(CONST, word=0))
            distance = self._add(Term(Opcode.SUB.value, (zero, distance)))
        by = abs(stride)
        more = self._add(Term(CONST, word=by - 1 if in_body else 2 * by - 1))
        total = self._add(Term(Opcode.ADD.value, (distance, more)))
        return self._add(Term(Opcode.SDIV.value, (total, self._add(Term(CONST, word=by)))))

    def _distance(self, start: Value, limit: Value, around: frozenset[Fact]) -> int:
        """limit - start; exact if the limit is written as start + something."""
        definition = self._values.get(limit.id) if isinstance(limit, Ref) else None
        if isinstance(definition, Instr) and definition.op is Opcode.ADD:
            left, right = definition.operands
            if start in (left, right):
                return self.of(right if left == start else left, around)
        ends = (self.of(limit, around), self.of(start, around))
        return self._add(Term(Opcode.SUB.value, ends))

    def _counter(self, loop: Loop) -> tuple[Induction, int, Value] | None:
        """The variable that ends the loop, its constant step, and its limit."""
        branch = self._blocks[loop.header].branch
        test = header_test(self._function, loop)
        if test is None and branch.target in loop.blocks and branch.otherwise not in loop.blocks:
            made = None if branch.cond is None else self._instruction(branch.cond)
            test = None if made is None else self._wide_less(made)
        return None if test is None else next(bounded(self._function, loop, *test), None)

    def _less(self, test: Phi | Instr | None) -> tuple[Value, Value] | None:
        """(small, large) of a signed comparison of words, also where it is made in 64 bits."""
        if not isinstance(test, Instr):
            return None
        if test.op is Opcode.ICMP_SLT:
            return test.operands[0], test.operands[1]
        return self._wide_less(test)

    def _wide_less(self, test: Instr) -> tuple[Value, Value] | None:
        """0 < high or (0 == high and index < word), where `high` is the word's sign: the index is
        not negative.
        """
        above, both = self._parts(test, Opcode.OR, Opcode.ICMP_SLT, Opcode.AND)
        level, below = self._parts(both, Opcode.AND, Opcode.ICMP_EQ, Opcode.ICMP_ULT)
        if above is None or level is None or below is None:
            return None
        high = self._instruction(above.operands[1])
        if above.operands != level.operands or above.operands[0] != Const(0) or high is None:
            return None
        is_sign = high.op is Opcode.ASHR and high.operands == (below.operands[1], Const(31))
        return (below.operands[0], below.operands[1]) if is_sign else None

    def _parts(
        self, instr: Instr | None, op: Opcode, first: Opcode, second: Opcode
    ) -> tuple[Instr | None, Instr | None]:
        """The operands of an instruction, if it and they are such."""
        if instr is None or instr.op is not op:
            return None, None
        left, right = (self._instruction(operand) for operand in instr.operands[:2])
        is_such = left is not None and left.op is first and right is not None and right.op is second
        return (left, right) if is_such else (None, None)

    def _instruction(self, value: Value) -> Instr | None:
        definition = self._values.get(value.id) if isinstance(value, Ref) else None
        return definition if isinstance(definition, Instr) else None

    def _clamped(self, number: int, value: Value, cond: int, taken: bool) -> int:
        wide = self._wide_tests.get(cond)
        if wide is not None and taken and value == Ref(wide.phi.id):
            return self._below(number, wide, self.facts(self._home[cond].name))
        test = self._values.get(cond)
        return self._compared(number, value, test, taken) if isinstance(test, Instr) else number

    def _compared(self, number: int, value: Value, test: Instr, taken: bool) -> int:
        """The term of a value of which a test was decided."""
        home = self._home[test.id].name
        less = self._less(test)
        if less is not None and taken and value in less:
            is_first = value == less[0]
            other = self.of(less[1 if is_first else 0], self.facts(home))
            return self._add(Term("lt" if is_first else "gt", (number, other)))
        joins = Opcode.AND if taken else Opcode.OR
        if test.op is joins:
            for part in test.operands:
                if isinstance(part, Ref):
                    number = self._clamped(number, value, part.id, taken)
            return number
        if value not in test.operands or len(test.operands) != 2:  # noqa: PLR2004
            return number
        is_first = value == test.operands[0]
        relation = _relation(test.opcode, taken, is_first)
        if relation is None:
            return number
        other = self.of(test.operands[1 if is_first else 0], self.facts(home))
        return self._add(Term(relation, (number, other)))


def _relation(op: Opcode, taken: bool, is_first: bool) -> str | None:
    """How the value is related to the other operand of a decided comparison."""
    if op is Opcode.ICMP_EQ:
        return "eq" if taken else None
    if op is Opcode.ICMP_NE:
        return None if taken else "eq"
    if op is Opcode.ICMP_ULT:
        return "ult" if taken and is_first else None
    if op is Opcode.ICMP_SLT:
        return ("lt" if is_first else "gt") if taken else ("ge" if is_first else "le")
    if op is Opcode.ICMP_SLE:
        return ("le" if is_first else "ge") if taken else ("gt" if is_first else "lt")
    return None


def _edge(source: Block, target: str) -> frozenset[Fact]:
    branch = source.branch
    if not isinstance(branch.cond, Ref) or branch.target == branch.otherwise:
        return frozenset()
    return frozenset({(branch.cond.id, branch.target == target)})


def _facts_of_blocks(function: Function) -> dict[str, frozenset[Fact]]:
    """Conditions decided on the way to each block: those of the branches that dominate it by one
    of their edges.
    """
    sources, parent = predecessors(function), immediate_dominators(function)
    blocks, facts = function.by_name, dict[str, frozenset[Fact]]()

    def of(name: str) -> frozenset[Fact]:
        if name not in facts:
            inherited = frozenset() if parent[name] == name else of(parent[name])
            reached = [source for source in sources[name] if source in parent]
            own = _edge(blocks[reached[0]], name) if len(reached) == 1 else frozenset()
            facts[name] = inherited | own
        return facts[name]

    for name in parent:
        of(name)
    return facts

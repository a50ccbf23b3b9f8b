"""Static-control parts: nests of counted loops whose accesses have affine subscripts.

A part is a tree of loops and statements. A statement is what a loop's blocks do between two inner
loops: loads, stores and arithmetic; counters, bounds and addresses are forms (`Form`) of the loops'
coordinates and of symbols, and are computed again by whatever is generated from the part. What a
statement leaves for others, and what loops carry, are scalars: arrays with one element an iteration
of the loops around (Feautrier, "Array expansion", 1988; Grosser et al., "Polly", 2012).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.words import signed
from vividc.ssa.analysis.conjunctions import CONTRARY, Conjunctions, only_tested
from vividc.ssa.analysis.counters import Counter, counter_of, lengths
from vividc.ssa.analysis.levels import Level, level_of
from vividc.ssa.analysis.order import Order
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials
from vividc.ssa.edit import block_of, incoming, read_values
from vividc.ssa.flow import Loop, preheader_of
from vividc.ssa.ir import (
    Block,
    Const,
    Function,
    Input,
    Instr,
    Ref,
    Value,
    definition_of,
    is_dimension,
)
from vividc.ssa.polyhedral.forms import COMPARISONS, Form, compared, symbol
from vividc.ssa.polyhedral.subscripts import (
    Access,
    Elements,
    FlatRows,
    element_bytes,
    subscripts_of,
)
from vividc.ssa.rewrite.refusal import Refusal


@dataclass(frozen=True)
class Dimension:
    """A loop: its counter is `value`, of the coordinate `name`, which rises by 1 from the first of
    `bounds` up to below the second.
    """

    header: str
    counter: Counter
    name: str
    value: Form
    bounds: tuple[Form, Form]


@dataclass(frozen=True)
class Statement:
    """What one iteration of `dims` does between inner loops.

    Attributes
    ----------
    instrs
        Loads, stores and arithmetic on data, in order.
    accesses
        Of the loads and stores, by instruction id.
    reads
        Scalars that other statements leave, by the id of the value.
    writes
        Ids of values that others read.
    copies
        What header phis become after it, all at once.
    guards
        Forms that are at least 0 in the iterations that run it, beside the bounds.
    """

    name: str
    dims: tuple[Dimension, ...]
    instrs: tuple[Instr, ...]
    accesses: Mapping[int, Access]
    reads: tuple[int, ...] = ()
    writes: tuple[int, ...] = ()
    copies: tuple[tuple[int, Value], ...] = ()
    guards: tuple[Form, ...] = ()
    shift: Mapping[str, Form] = field(default_factory=dict)
    """Coordinates that are not its own: of a loop's header, which runs before each iteration and
    after the last.
    """

    def placed(self, at: Mapping[str, Form]) -> dict[str, Form]:
        """All coordinates, where its own are these."""
        return {**at, **{name: value.substituted(at) for name, value in self.shift.items()}}

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates, outermost first."""
        return tuple(dim.name for dim in self.dims)


@dataclass(frozen=True)
class Nest:
    """A loop of a part around statements and loops, in order."""

    dim: Dimension
    children: tuple[Nest | Statement, ...]

    def statements(self) -> Iterator[Statement]:
        """All statements inside, in order."""
        for child in self.children:
            if isinstance(child, Statement):
                yield child
            else:
                yield from child.statements()


@dataclass(frozen=True)
class Scop:
    """A static-control part.

    Attributes
    ----------
    entry, exit
        The block that enters the outermost loop, and the one that follows it.
    symbols
        What each symbol's name stands for.
    depth
        Of each scalar: how many coordinates index it.
    indices
        Forms of the integer values that are computed again where they are used.
    elements
        Type of the elements of each array.
    narrow
        A load of each array whose elements are less than a word, if there is one.
    rows
        How long rows are of the kernel's own arrays whose subscripts are two.
    lengths
        Symbols that are dimensions, or prove to be as small.
    """

    function: Function
    nest: Nest
    loop: Loop
    entry: str
    exit: str
    symbols: Mapping[str, Value]
    depth: Mapping[int, int]
    indices: Mapping[int, Form]
    elements: Mapping[str, Type]
    narrow: Mapping[str, Instr]
    rows: Mapping[str, Input] = field(default_factory=dict)
    lengths: frozenset[str] = frozenset()

    @cached_property
    def statements(self) -> tuple[Statement, ...]:
        """All statements, in order."""
        return tuple(self.nest.statements())

    def statement(self, name: str) -> Statement:
        """The statement of this name."""
        return next(one for one in self.statements if one.name == name)

    def dimension(self, statement: str, coordinate: str) -> Dimension:
        """The loop that a coordinate of a statement counts."""
        dims = self.statement(statement).dims
        return next(dim for dim in dims if dim.name == coordinate)


_OPERANDS: Final[Mapping[object, int]] = {Opcode.LOAD: 2, Opcode.STORE: 3}
"""Of accesses that have no predicate."""


class _NotStatic(Exception):
    pass


def find_scop(function: Function, header: str) -> Scop | Refusal:
    """The loop at `header` with all that is in it as a static-control part.

    Loops are canonical (`normalize.canonical_loops`), with latches of their own
    (`levels.with_own_latches`).
    """
    try:
        return _Raising(function, level_of(function, header)).scop()
    except _NotStatic as reason:
        return Refusal(str(reason))


class _Raising:
    def __init__(self, function: Function, level: Level) -> None:
        self.function = function
        self.level = level
        self.inside = level.loop.blocks
        self.polynomials = Polynomials(function, pitches=True)
        self.symbols: dict[str, Value] = {}
        self.names: dict[Value, str] = {}
        self.values: dict[Value, Form] = {}
        self.counted: dict[Value, Form] = {}
        self.depth: dict[int, int] = {}
        self.counters: dict[str, Counter] = {}
        self.inclusive: dict[str, bool] = {}
        self.limits = self.over = frozenset[str]()
        self.guards: tuple[Form, ...] = ()
        self.count = 0
        self.elements = Elements(function)
        self.axes: dict[str, int] = {}
        self.order = Order(function)
        self.rows = FlatRows(function, self.order)
        self._tests = only_tested(function)
        self._lengths = lengths(function, self.order, preheader_of(function, level.loop))

    def scop(self) -> Scop:
        """The part."""
        nest = self._nest(self.level, ())
        nest = with_scalars(nest, self.depth, self._read_after())
        indices = {key.id: value for key, value in self.values.items() if isinstance(key, Ref)}
        return Scop(
            self.function,
            nest,
            self.level.loop,
            preheader_of(self.function, self.level.loop),
            self.level.loop.exits[0][1],
            self.symbols,
            self.depth,
            indices,
            self.elements.types,
            self.elements.narrow,
            self.rows.lengths,
            frozenset(n for n, value in self.symbols.items() if self._is_length(value)),
        )

    def _read_after(self) -> set[int]:
        outside = [block for block in self.function.blocks if block.name not in self.inside]
        read = {v.id for block in outside for v in read_values(block) if isinstance(v, Ref)}
        own = self.level.types.keys() & read
        phis = {phi.id for phi in self.level.header.phis}
        if own - phis or any(Ref(ident) in self.values for ident in own):
            raise _NotStatic("a value of it that it does not carry is read after it")
        return own

    def _nest(self, level: Level, around: tuple[Dimension, ...]) -> Nest:
        loop = level.loop
        if not loop.exits:
            raise _NotStatic("a loop never ends")
        if len(loop.latches) != 1 or loop.exits != ((loop.header, loop.exits[0][1]),):
            raise _NotStatic("a loop has exits in its body")
        limits = self.limits
        dim = self._dimension(level, around)
        dims = (*around, dim)
        carried = [phi for phi in level.header.phis if phi.id != dim.counter.phi.id]
        for phi in carried:
            self.depth[phi.id] = len(around)
        children: list[Nest | Statement] = []
        chunk: list[Instr] = []
        outer = self.guards
        for name, guards in self._guarded(level):
            if guards != self.guards:
                children += self._statement(chunk, dims, ())
                chunk, self.guards = [], guards
            if name not in level.children:
                chunk += self._data(block_of(self.function, name))
                continue
            inner = level.children[name]
            start = self._entering(inner)
            children += self._statement(chunk, dims, start)
            chunk = []
            nest = self._nest(inner, dims)
            children += self._header(inner, dims, {nest.dim.name: nest.dim.bounds[0]})
            children.append(nest)
            self.over |= {nest.dim.name}
        if self.guards != outer:
            children += self._statement(chunk, dims, ())
            chunk, self.guards = [], outer
        copies = tuple((phi.id, incoming(phi, loop.latches[0])) for phi in carried)
        children += self._statement(chunk, dims, copies)
        children += self._header(level, dims, {dim.name: symbol(dim.name).plus(Form((), 1))})
        self.limits = limits
        return Nest(dim, tuple(children))

    def _header(
        self, level: Level, dims: tuple[Dimension, ...], shift: Mapping[str, Form]
    ) -> list[Statement]:
        """What a loop's header does, which runs before it and at the end of each iteration."""
        work = self._data(level.header)
        if not work:
            return []
        if level is self.level:
            raise _NotStatic("the header of the outermost loop does more than count")
        around = len(dims) - (level.header.name == dims[-1].header)
        [made] = self._statement(work, dims, ())
        for instr in work:
            self.depth[instr.id] = around
        return [replace(made, shift=shift)]

    def _guarded(self, level: Level) -> Iterator[tuple[str, tuple[Form, ...]]]:
        """The nodes of a loop's body in order, with the guards of each and of the loop."""
        around = self.guards
        tests = Conjunctions(level)
        for name in level.flow.order:
            if name == level.loop.header:
                continue
            block = level.blocks[name]
            if block.phis and name not in level.children:
                raise _NotStatic("branches of its body leave values")
            conjunction = tests.of(name) or frozenset()
            if CONTRARY in conjunction:
                raise _NotStatic("its body branches")
            own = [form for test in sorted(conjunction, key=str) for form in self._guard(*test)]
            yield name, tuple(dict.fromkeys((*around, *own)))

    def _guard(self, test: Value, holds: bool) -> tuple[Form, ...]:
        """Forms that are at least 0 where a test of counters and bounds holds, or does not."""
        instr = definition_of(self.function, test)
        if not isinstance(instr, Instr) or instr.op not in COMPARISONS:
            raise _NotStatic("its body branches")
        left, right = (self._bound(operand) for operand in instr.operands)
        forms = compared(instr.op, left, right, holds)
        if any(self._is_any(name) for form in forms for name in form.names - self.limits):
            raise _NotStatic("its body branches on a number that may be anything")
        if not forms:
            raise _NotStatic("its body branches where two numbers differ")
        return forms

    def _entering(self, inner: Level) -> tuple[tuple[int, Value], ...]:
        before = preheader_of(self.function, inner.loop)
        counter = self._counter(inner.loop).phi.id
        return tuple((p.id, incoming(p, before)) for p in inner.header.phis if p.id != counter)

    def _counter(self, loop: Loop) -> Counter:
        if loop.header not in self.counters:
            counter = counter_of(self.function, loop)
            self.inclusive[loop.header] = counter is None
            if counter is None:
                counter = counter_of(self.function, loop, inclusive=True)
            if counter is None:
                raise _NotStatic("a loop's iterations are not counted before it starts")
            self.counters[loop.header] = counter
        return self.counters[loop.header]

    def _dimension(self, level: Level, around: tuple[Dimension, ...]) -> Dimension:
        counter = self._counter(level.loop)
        name = f"i{self.count}"
        self.count += 1
        first = self._bound(counter.initial)
        limit = self._bound(counter.limit)
        if self.inclusive[level.loop.header]:
            limit = limit.plus(Form((), 1 if counter.step > 0 else -1))
        if abs(counter.step) != 1:
            raise _NotStatic("a loop has a step other than 1")
        if any(map(self._is_any, first.names)):
            raise _NotStatic("a loop starts at a number that may be anything")
        self.limits = self.limits | limit.names
        if counter.step < 0:
            first, limit = first.times(-1), limit.times(-1)
        value = symbol(name).times(counter.step)
        self.values[Ref(counter.phi.id)] = self.counted[Ref(counter.phi.id)] = value
        return Dimension(level.loop.header, counter, name, value, (first, limit))

    def _is_any(self, name: str) -> bool:
        """Whether it is a number that is no length of an array."""
        return name in self.symbols and not self._is_length(self.symbols[name])

    def _is_length(self, value: Value) -> bool:
        return is_dimension(value) or value in self._lengths

    def _bound(self, value: Value) -> Form:
        """A bound as a form whose sums do not wrap."""
        if isinstance(value, Const):
            return Form((), signed(value.word))
        if value in self.counted and not self.over & self.counted[value].names:
            return self.counted[value]
        instr = definition_of(self.function, value)
        if isinstance(instr, Instr) and instr.op in (Opcode.ADD, Opcode.SUB) and instr.exact:
            left, right = (self._bound(operand) for operand in instr.operands)
            return left.plus(right, 1 if instr.op is Opcode.ADD else -1)
        if isinstance(value, Ref) and self.function.block_of[value.id] in self.inside:
            raise _NotStatic("a bound is computed in it")
        return symbol(self._symbol(value))

    def _symbol(self, value: Value) -> str:
        if value not in self.names:
            self.names[value] = f"p{len(self.names)}"
            self.symbols[self.names[value]] = value
        return self.names[value]

    def _data(self, block: Block) -> list[Instr]:
        """What a block does, counters, tests and addresses aside."""
        return [
            instr
            for instr in block.instrs
            if instr.op in MEMORY or not (self._is_index(instr) or instr.id in self._tests)
        ]

    def _is_index(self, instr: Instr) -> bool:
        if instr.type is not Type.I32:
            return False
        polynomial = self.polynomials.of(Ref(instr.id))
        made = self._affine(polynomial)
        if made is None:
            return self._is_address(polynomial)
        self.values[Ref(instr.id)] = made
        return True

    def _is_address(self, polynomial: Polynomial) -> bool:
        """Whether it is made of counters and of values from outside."""
        found = (value for monomial in polynomial.terms for value in monomial)
        return all(self._is_fixed(value) or value in self.values for value in found)

    def _is_fixed(self, value: Value) -> bool:
        return not isinstance(value, Ref) or self.function.block_of[value.id] not in self.inside

    def _affine(self, polynomial: Polynomial) -> Form | None:
        result = Form()
        for monomial, factor in polynomial.terms.items():
            if not monomial:
                result = result.plus(Form((), factor))
            elif len(monomial) > 1:
                return None
            elif monomial[0] in self.values and not self.over & self.values[monomial[0]].names:
                result = result.plus(self.values[monomial[0]], factor)
            elif self._is_fixed(monomial[0]):
                result = result.plus(symbol(self._symbol(monomial[0])), factor)
            else:
                return None
        return result

    def _statement(
        self, chunk: list[Instr], dims: tuple[Dimension, ...], copies: tuple[tuple[int, Value], ...]
    ) -> list[Statement]:
        if not chunk and not copies:
            return []
        used = [value for instr in chunk for value in instr.operands] + [v for _, v in copies]
        if any(self.over & self.values[value].names for value in used if value in self.values):
            raise _NotStatic("a counter is read behind its loop")
        accesses = {i.id: self._access(i) for i in chunk if i.op in MEMORY}
        name = f"S{self.count}"
        self.count += 1
        for instr in chunk:
            self.depth[instr.id] = len(dims)
        return [Statement(name, dims, tuple(chunk), accesses, copies=copies, guards=self.guards)]

    def _access(self, instr: Instr) -> Access:
        if not isinstance(instr.operands[0], Input) or instr.lane is not None:
            raise _NotStatic("an access has a base that changes")
        if len(instr.operands) > _OPERANDS[instr.op]:
            raise _NotStatic("an access is predicated")
        subscripts = subscripts_of(self.function).of(instr)
        if self.function.block_of[instr.id] not in self.counters:  # a header runs behind its loop
            index = self.polynomials.of(instr.operands[1])
            subscripts = self.rows.taken_apart(instr, index, self._is_in_row) or subscripts
        step = element_bytes(instr)
        moved = [self._affine(one) for one in subscripts or ()]
        forms = [one and one.times(1 << instr.shift).divided(step) for one in moved]
        if not forms or any(one is None for one in forms) or instr.offset % step:
            raise _NotStatic(f"a subscript of {instr.array} is not affine")
        known = [one for one in forms if one is not None]
        known[-1] = known[-1].plus(Form((), instr.offset // step))
        if self.axes.setdefault(instr.array, len(known)) != len(known):
            raise _NotStatic(f"subscripts of {instr.array} are not known everywhere")
        if fault := self.elements.fault(instr):
            raise _NotStatic(fault)
        return Access(instr, instr.array, tuple(known))

    def _is_in_row(self, column: Polynomial, length: Input, access: Instr) -> bool:
        """Whether a column proves to be from 0 to below the length of a row where it is used."""
        if self._affine(column) is None:
            return False
        block = self.function.block_of[access.id]
        return self.order.lacks_below(self.order.of_terms(column), length, block) == ()


def with_scalars(nest: Nest, depth: Mapping[int, int], after: set[int]) -> Nest:
    """The nest with what statements read of each other."""
    read: dict[str, list[int]] = {}
    for statement in nest.statements():
        operands = [v for i in statement.instrs for v in i.operands]
        operands += [value for _, value in statement.copies]
        read[statement.name] = [
            v.id
            for v in dict.fromkeys(operands)
            if isinstance(v, Ref)
            and v.id in depth
            and not any(instr.id == v.id for instr in statement.instrs)
        ]
    elsewhere = {ident for values in read.values() for ident in values} | after

    def rebuilt(node: Nest) -> Nest:
        children: list[Nest | Statement] = []
        for child in node.children:
            if isinstance(child, Nest):
                children.append(rebuilt(child))
                continue
            own = tuple(i.id for i in child.instrs if i.id in elsewhere)
            children.append(replace(child, reads=tuple(read[child.name]), writes=own))
        return Nest(node.dim, tuple(children))

    return rebuilt(nest)

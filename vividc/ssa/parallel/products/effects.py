"""What the statements of a static-control part change, one change at a time, as expressions.

A change is a store, or what a loop carries from one iteration to the next; that is an element of an
array, too, with one element for each iteration of the loops around (`scop.Scop.depth`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode, Type
from vividc.machine.product import CONST, INPUT
from vividc.ssa.ir import Const, Function, Input, Instr, Phi, Ref, Value, definition_of
from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Dimension, Nest, Scop, Statement
from vividc.ssa.polyhedral.subscripts import Access

_TYPES = frozenset({Type.F32, Type.PRED, Type.ANY})
"""Of operands that expressions may have."""


class NoProduct(Exception):
    """Something is no matrix product; its text says why."""


@dataclass(frozen=True)
class Element:
    """An element of an array, or of what a loop carries: then the array's name begins with %."""

    array: str
    subscripts: tuple[Form, ...]


@dataclass(frozen=True)
class Expression:
    """A leaf, as of `product.Term`, or an operation on others; of `element` if it is read."""

    op: str
    args: tuple[Expression, ...] = ()
    element: Element | None = None
    key: str = ""
    word: int = 0

    def elements(self) -> Iterator[Element]:
        """All that it reads."""
        if self.element is not None:
            yield self.element
        for arg in self.args:
            yield from arg.elements()


@dataclass(frozen=True)
class Effect:
    """`target` becomes `value` in each iteration of `statement`, which does nothing else."""

    statement: Statement
    target: Element
    value: Expression
    line: str

    @property
    def dims(self) -> tuple[Dimension, ...]:
        """The loops around it."""
        return self.statement.dims


def with_stores_behind(scop: Scop) -> Scop:
    """A part whose loops' headers, which run before each iteration and after the last, store
    nothing: where only what they store last is seen, that is stored behind the loop.
    """
    return replace(scop, nest=_stores_behind(scop.nest))


def _stores_behind(nest: Nest) -> Nest:
    children: list[Nest | Statement] = []
    for child in nest.children:
        if isinstance(child, Statement):
            children.append(child)
            continue
        inner = _stores_behind(child)
        behind = _header_of(inner, children[-1] if children else None)
        if behind is not None:
            children[-1:] = [Nest(inner.dim, inner.children[:-1]), behind]
        else:
            children.append(inner)
    return Nest(nest.dim, tuple(children))


def _header_of(loop: Nest, before: Nest | Statement | None) -> Statement | None:
    """What a loop's header does, as a statement behind the loop; None: nothing, or not so."""
    last = loop.children[-1] if loop.children else None
    if not isinstance(before, Statement) or not isinstance(last, Statement) or not before.shift:
        return None
    is_such = before.instrs == last.instrs and _only_last_is_seen(loop, last)
    return replace(before, shift={}) if is_such else None


def _only_last_is_seen(loop: Nest, header: Statement) -> bool:
    """Whether what a header does has the same effect if it is done once, behind its loop."""
    own = {access.array for access in header.accesses.values()}
    others = (one for one in loop.statements() if one is not header)
    used = {access.array for one in others for access in one.accesses.values()}
    places = [form for access in header.accesses.values() for form in access.subscripts]
    moves = any(loop.dim.name in form.names for form in places)
    return not moves and own.isdisjoint(used) and all(a.is_store for a in header.accesses.values())


def effects_of(scop: Scop) -> tuple[Effect, ...]:
    """All changes, in the order of the text.

    Raises
    ------
    NoProduct
        One of them is no expression of elements, scalars and constants.
    """
    reader = _Reader(scop)
    return tuple(effect for one in scop.statements for effect in reader.effects(one))


def may_be_apart(
    scop: Scop, effects: tuple[Effect, ...], times: tuple[tuple[str, ...], ...]
) -> bool:
    """Whether all iterations of each change may run before those of the next, each in the order of
    the coordinates `times`.
    """
    by_name: dict[str, list[Statement]] = {}
    for effect in effects:
        by_name.setdefault(effect.statement.name.partition("_")[0], []).append(effect.statement)
    parts = Relations(replace(scop, nest=_with_parts(scop.nest, by_name)))
    longest = max(map(len, times))
    schedule = parts.union({}).identity()
    for number, (effect, names) in enumerate(zip(effects, times, strict=True)):
        place = [Form((), number), *map(symbol, names), *[Form()] * (longest - len(names))]
        schedule = schedule.union(parts.map(effect.statement, "", tuple(place)))
    return parts.respects(schedule)


def _with_parts(nest: Nest, by_name: dict[str, list[Statement]]) -> Nest:
    children: list[Nest | Statement] = []
    for child in nest.children:
        if isinstance(child, Nest):
            children.append(_with_parts(child, by_name))
        else:
            children += by_name.get(child.name, [])
    return Nest(nest.dim, tuple(children))


@dataclass
class _Reader:
    scop: Scop
    homes: dict[int, Statement] = field(init=False)

    def __post_init__(self) -> None:
        self.homes = {i.id: one for one in self.scop.statements for i in one.instrs}
        self.stored = {
            access.array
            for one in self.scop.statements
            for access in one.accesses.values()
            if access.is_store
        }

    @property
    def function(self) -> Function:
        return self.scop.function

    def effects(self, statement: Statement) -> Iterator[Effect]:
        """The changes of a statement, each as a statement."""
        if statement.shift and (statement.copies or self._stores(statement)):
            raise NoProduct("a loop's test stores something")
        made: list[Effect] = []
        for instr in self._stores(statement):
            access = statement.accesses[instr.id]
            target = Element(access.array, access.subscripts)
            made.append(self._effect(statement, len(made), target, instr.operands[2], instr))
        for ident, value in statement.copies:
            target = self._carried(ident)
            if value != Ref(ident):
                made.append(self._effect(statement, len(made), target, value, None))
        self._demand_order(statement, made)
        yield from made

    def _stores(self, statement: Statement) -> list[Instr]:
        return [i for i in statement.instrs if i.op is Opcode.STORE]

    def _carried(self, ident: int) -> Element:
        names = self._phi_coordinates(ident)
        return Element(f"%{ident}", tuple(map(symbol, names)))

    def _phi_coordinates(self, ident: int) -> tuple[str, ...]:
        """Coordinates of the loops around the one that carries it."""
        block = self.function.block_of[ident]
        for one in self.scop.statements:
            for number, dim in enumerate(one.dims):
                if dim.header == block:
                    return one.coordinates[:number]
        raise NoProduct("a value is carried by no loop")

    def _effect(
        self, home: Statement, number: int, target: Element, value: Value, store: Instr | None
    ) -> Effect:
        accesses: dict[int, Access] = {}
        carried: dict[int, None] = {}
        told = self._expression(value, home, accesses, carried)
        copies: tuple[tuple[int, Value], ...] = ()
        if store is None:
            copies = ((int(target.array[1:]), value),)
        else:
            accesses[store.id] = home.accesses[store.id]
        name = f"{home.name}_{number}"
        statement = Statement(name, home.dims, (), accesses, tuple(carried), (), copies)
        loc = definition_of(self.function, value) if store is None else store
        return Effect(statement, target, told, str(getattr(loc, "loc", None) or ""))

    def _expression(
        self, value: Value, home: Statement, accesses: dict[int, Access], carried: dict[int, None]
    ) -> Expression:
        value = self.function.settled(value)
        if isinstance(value, Const):
            return Expression(CONST, word=value.word)
        if isinstance(value, Input):
            return Expression(INPUT, key=value.key)
        item = definition_of(self.function, value)
        if isinstance(item, Phi) and item.id in self.scop.depth:
            carried[item.id] = None
            return Expression("load", element=self._carried(item.id))
        if isinstance(item, Instr) and self._is_before(item):
            args = tuple(self._expression(v, home, accesses, carried) for v in item.operands)
            return Expression(item.opcode.value, args)
        if not isinstance(item, Instr) or item.id not in self.homes:
            raise NoProduct("it uses an index as a number, or what is computed before its loops")
        source = self.homes[item.id]
        if item.op in MEMORY:
            return self._load(item, source, home, accesses)
        if source.shift or not _is_simple(item):
            raise NoProduct(f"it does {item.mnemonic} where only arithmetic on floats may be")
        args = tuple(self._expression(v, home, accesses, carried) for v in item.operands)
        return Expression(item.opcode.value, args)

    def _is_before(self, item: Instr) -> bool:
        """Whether it is float arithmetic before the loops, which can be done again in them."""
        return item.id not in self.homes and item.op not in MEMORY and _is_simple(item)

    def _load(
        self, item: Instr, source: Statement, home: Statement, accesses: dict[int, Access]
    ) -> Expression:
        access = source.accesses[item.id]
        if source is not home and (source.shift or access.array in self.stored):
            raise NoProduct(f"it keeps an element of {access.array}, which its loops write")
        if self.scop.elements[access.array] is not Type.F32:
            raise NoProduct(f"elements of {access.array} are not float32")
        accesses[item.id] = access
        return Expression("load", element=Element(access.array, access.subscripts))

    def _demand_order(self, statement: Statement, made: list[Effect]) -> None:
        """No change reads, after another one, what that has written, as it was before."""
        written: set[str] = set()
        for effect in made:
            read = {element.array for element in effect.value.elements()}
            both = written & read
            if both:
                raise NoProduct(f"it keeps an element of {min(both)}, which it writes")
            written.add(effect.target.array)


def _is_simple(item: Instr) -> bool:
    info = OPCODES[item.opcode]
    is_float = info.result in (Type.F32, Type.PRED) or item.op is Opcode.SELECT
    return is_float and _TYPES.issuperset(info.operands)

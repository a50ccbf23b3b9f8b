"""The loops that isl makes of a schedule, as plain data."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import islpy as isl

from vividc.ssa.polyhedral.forms import ZERO, Form, symbol
from vividc.ssa.polyhedral.orders.search import describe
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.schedule import Along, Group, Grouped, grouped_schedule_of
from vividc.ssa.polyhedral.trees import Loop
from vividc.ssa.polyhedral.values import bounded, integer
from vividc.ssa.rewrite.refusal import Refusal

_COMPARISONS: Final = {"eq": "==", "le": "<=", "lt": "<", "ge": ">=", "gt": ">"}
_JOINED: Final = {"and": "and", "and_then": "and", "or": "or", "or_else": "or"}
_REMAINDERS: Final = ("pdiv_r", "zdiv_r")
_OF_NEGATIVE: Final = ("fdiv_q", "zdiv_r")
_MOST: Final = 1 << 30
_RARE: Final = 0.05
_QUOTIENTS: Final = ("fdiv_q", "pdiv_q", *_REMAINDERS)

_MOST_OPERATIONS: Final = 3_000_000
"""Of isl's for the loops of one tree, some 0.4 s. Those that are chosen take 2,100,000 at most (of
the 60 kernels that are planned longest); tiles in triangles took more than 4,000,000.
"""


@dataclass(frozen=True)
class Run:
    """An iteration of a statement."""

    statement: str
    coordinates: tuple[Form, ...]


@dataclass(frozen=True)
class For:
    """A loop: `name` from the largest of `first`, by `step`, while below the least of `limit`."""

    name: str
    first: tuple[Form, ...]
    limit: tuple[Form, ...]
    step: int
    body: tuple[Code, ...]


@dataclass(frozen=True)
class Test:
    """A comparison with 0, or several joined by `and` or `or`."""

    relation: str
    left: Form = ZERO
    parts: tuple[Test, ...] = ()


@dataclass(frozen=True)
class If:
    """Code under a test, with a name of its own."""

    test: Test
    then: tuple[Code, ...]
    otherwise: tuple[Code, ...] = ()
    name: str = ""


Code = Run | For | If


@dataclass(frozen=True)
class Quotient:
    """`dividend` divided by a constant, rounded down; or the remainder."""

    dividend: Form
    divisor: int
    remainder: bool


@dataclass
class Loops:
    """Code, and what its names of quotients stand for."""

    code: tuple[Code, ...] = ()
    quotients: dict[str, Quotient] = field(default_factory=dict)


class _Odd(Exception):
    pass


def loops_of(tree: Loop, relations: Relations) -> Loops | Refusal:
    """The loops of a tree."""
    if not relations.is_endless:
        with relations.asked(f"loops of {describe(tree)}"), bounded(_MOST_OPERATIONS):
            return _loops_of(tree, relations)
    return Refusal("isl takes too long for loops of it")


def _loops_of(tree: Loop, relations: Relations) -> Loops | Refusal:
    build = isl.AstBuild.from_context(relations.context)
    schedule, grouped = grouped_schedule_of(tree, relations)
    reader = _Reader(grouped)
    try:
        node = build.node_from_schedule(schedule)
    except isl.Error as error:
        if "void expression" not in str(error):  # of some triangles (lu)
            raise
        return Refusal("isl finds no loops for it")
    try:
        code = tuple(reader.code(node, {}))
        code = tuple(_Counted(relations, code, reader.quotients).of(code))
    except _Odd as reason:
        return Refusal(str(reason))
    return Loops(code, reader.quotients)


class _Counted:
    """Names coordinates by the loops that count them where tests and bounds say what the counters
    are: isl writes `if (c0 >= 5) S(5)` in a loop to 5, and a scalar of an iteration has one name.
    """

    def __init__(
        self, relations: Relations, code: tuple[Code, ...], quotients: Mapping[str, Quotient]
    ) -> None:
        self.relations = relations
        self.quotients = quotients
        self.dims = {one.name: one.coordinates for one in relations.scop.statements}
        self.counted: dict[tuple[str, str], dict[Form, None]] = {}
        self._equal: dict[str, bool] = {}
        for run in runs_in(code):
            for dim, form in zip(self.dims[run.statement], run.coordinates, strict=True):
                for name in form.names:
                    self.counted.setdefault((name, dim), {})[form] = None

    def of(
        self, code: Iterable[Code], names: tuple[str, ...] = (), known: tuple[str, ...] = ()
    ) -> Iterator[Code]:
        """Code in loops with these counters, where what isl is told in `known` holds."""
        for item in code:
            if isinstance(item, Run):
                dims = zip(self.dims[item.statement], item.coordinates, strict=True)
                named = tuple(self._named(dim, form, names, known) for dim, form in dims)
                yield replace(item, coordinates=named)
            elif isinstance(item, For):
                inside = (*names, item.name)
                body = tuple(self.of(item.body, inside, (*known, *_within(item))))
                yield replace(item, body=body)
            else:
                test = _text(item.test)
                then = tuple(self.of(item.then, names, (*known, test)))
                otherwise = tuple(self.of(item.otherwise, names, (*known, f"not ({test})")))
                yield replace(item, then=then, otherwise=otherwise)

    def _named(self, dim: str, form: Form, names: tuple[str, ...], known: tuple[str, ...]) -> Form:
        """The form by the innermost counter that it is equal to a form of: in a branch that says
        what this one is, isl writes it by those around.
        """
        for name in reversed([name for name in names if (name, dim) in self.counted]):
            if name in form.names:
                break
            for other in self.counted[name, dim]:
                if self._are_equal(form, other, names, known):
                    return other
        return form

    def _are_equal(
        self, form: Form, other: Form, names: tuple[str, ...], known: tuple[str, ...]
    ) -> bool:
        numbers = {*names, *self.relations.scop.symbols}
        if not other.names <= numbers:
            return False  # it is of other loops
        known_here: dict[str, str] = {}
        for name, quotient in self.quotients.items():  # in the order in which they were read
            if quotient.dividend.names <= {*numbers, *known_here}:
                known_here[name] = f"{name} = {_rounded(quotient)}"
        taken = ", ".join((*names, *known_here))
        conditions = " and ".join((*known, *known_here.values(), f"({form}) != ({other})"))
        apart = f"{self.relations.parameters} -> {{ [{taken}] : {conditions} }}"
        if apart not in self._equal:
            met = isl.Set(apart).intersect_params(self.relations.context)
            self._equal[apart] = bool(met.is_empty())
        return self._equal[apart]


def _within(loop: For) -> Iterator[str]:
    yield from (f"{loop.name} >= ({one})" for one in loop.first)
    yield from (f"{loop.name} < ({one})" for one in loop.limit)


def _text(test: Test) -> str:
    if test.parts:
        return f" {test.relation} ".join(f"({_text(part)})" for part in test.parts)
    return f"{test.left} {'=' if test.relation == '==' else test.relation} 0"


def _rounded(quotient: Quotient) -> str:
    dividend = f"({quotient.dividend})"
    if quotient.remainder:
        return f"{dividend} mod {quotient.divisor}"
    return f"floor({dividend}/{quotient.divisor})"


class _Reader:
    def __init__(self, grouped: Grouped) -> None:
        self.grouped = grouped
        self._is_marked = False
        self.count = 0
        self.quotients: dict[str, Quotient] = {}
        self._known: dict[Quotient, str] = {}

    def code(self, node: isl.AstNode, names: dict[str, Form]) -> Iterator[Code]:
        """What a node of isl's tree says."""
        kind = _name(node.get_type())
        if kind == "block":
            children = node.block_get_children()
            for position in range(children.n_ast_node()):
                yield from self.code(children.get_ast_node(position), names)
        elif kind == "user":
            call = node.user_get_expr()
            count = call.get_op_n_arg()
            arguments = tuple(self.form(call.get_op_arg(n), names) for n in range(1, count))
            name = call.get_op_arg(0).get_id().get_name()
            twins = () if self._is_marked else self.grouped.twins.get(name, ())
            yield from (Run(one, arguments) for one in (name, *twins))
        elif kind == "mark":
            yield from self._mark(node, names)
        elif kind == "if":
            yield from self._if(node, names)
        elif kind == "for":
            yield from self._for(node, names)
        else:
            raise _Odd(f"isl's tree has a node of type {kind}")

    def _mark(self, node: isl.AstNode, names: dict[str, Form]) -> Iterator[Code]:
        """The groups of a statement and its twins."""
        group = self.grouped.marks[node.mark_get_id().get_name()]
        for twin in ("", *group.twins):
            self._is_marked = True
            for first in self.code(node.mark_get_node(), names):
                yield from self._group_of(first, group, twin)
            self._is_marked = False

    def _group_of(self, code: Code, group: Group, twin: str) -> Iterator[Code]:
        """The iterations of a group, from its first, perhaps of a twin."""
        if isinstance(code, If):
            then, otherwise = (
                tuple(run for one in side for run in self._group_of(one, group, twin))
                for side in (code.then, code.otherwise)
            )
            yield replace(code, then=then, otherwise=otherwise)
            return
        if not isinstance(code, Run):
            raise _Odd("iterations of a group are in a loop")
        at = dict(zip(group.coordinates, code.coordinates, strict=True))
        run = replace(code, statement=twin or code.statement)
        yield from self._beside(run, group.along, at)

    def _beside(self, run: Run, along: tuple[Along, ...], at: Mapping[str, Form]) -> Iterator[Code]:
        """The iterations of a group beside one; what is below a limit is in what was before it."""
        if not along:
            yield run
            return
        first, *inner = along
        yield from self._beside(run, tuple(inner), at)
        if first.factor == 1:
            return
        moved = list(run.coordinates)
        moved[first.coordinate] = moved[first.coordinate].plus(Form((), 1))
        more = (replace(first, factor=first.factor - 1), *inner)
        following = self._beside(Run(run.statement, tuple(moved)), more, at)
        if first.limit is None:
            yield from following
            return
        left = first.limit.substituted(at).plus(moved[first.coordinate], -1)
        name = self._branch()
        yield If(Test(">=", left.plus(Form((), -1))), tuple(following), name=name)

    def _branch(self) -> str:
        """The name of the next branch."""
        self.count += 1
        return f"b{self.count - 1}"

    def _if(self, node: isl.AstNode, names: dict[str, Form]) -> Iterator[Code]:
        name = self._branch()
        test = self.test(node.if_get_cond(), names)
        then = tuple(self.code(node.if_get_then_node(), names))
        has_else = node.if_has_else_node()
        otherwise = tuple(self.code(node.if_get_else_node(), names)) if has_else else ()
        yield If(test, then, otherwise, name)

    def _for(self, node: isl.AstNode, names: dict[str, Form]) -> Iterator[Code]:
        name = node.for_get_iterator().get_id().get_name()
        first = self._several(node.for_get_init(), "max", names)
        if node.for_is_degenerate():
            if len(first) != 1:
                raise _Odd("a single iteration at the largest of several")
            yield from self.code(node.for_get_body(), {**names, name: first[0]})
            return
        own = f"c{self.count}"
        self.count += 1
        condition = node.for_get_cond()
        operation = _name(condition.get_op_type())
        if operation not in ("lt", "le"):
            raise _Odd("a loop that ends otherwise than below a limit")
        limit = self._several(condition.get_op_arg(1), "min", names)
        if operation == "le":
            limit = tuple(one.plus(Form((), 1)) for one in limit)
        step = self.form(node.for_get_inc(), names)
        inside = {**names, name: symbol(own)}
        yield For(own, first, limit, step.constant, tuple(self.code(node.for_get_body(), inside)))

    def _several(
        self, expression: isl.AstExpr, joined_by: str, names: dict[str, Form]
    ) -> tuple[Form, ...]:
        if _operation(expression) == joined_by:
            parts = (self._several(one, joined_by, names) for one in _arguments(expression))
            return tuple(one for part in parts for one in part)
        return (self.form(expression, names),)

    def test(self, expression: isl.AstExpr, names: dict[str, Form]) -> Test:
        """A condition."""
        operation = _operation(expression)
        if operation in _JOINED:
            parts = tuple(self.test(one, names) for one in _arguments(expression))
            return Test(_JOINED[operation], parts=parts)
        if operation not in _COMPARISONS:
            raise _Odd(f"a test by {operation}")
        left, right = (self.form(one, names) for one in _arguments(expression))
        return Test(_COMPARISONS[operation], left.plus(right, -1))

    def form(self, expression: isl.AstExpr, names: dict[str, Form]) -> Form:
        """An integer."""
        kind = _name(expression.get_type())
        if kind == "int":
            return Form((), integer(expression.get_val()))
        if kind == "id":
            name = expression.get_id().get_name()
            return names.get(name, symbol(name))
        operation = _operation(expression)
        parts = [self.form(one, names) for one in _arguments(expression)]
        if operation == "minus":
            return parts[0].times(-1)
        left, right = parts if len(parts) == 2 else (ZERO, ZERO)  # noqa: PLR2004 - operands
        if operation in ("add", "sub"):
            return left.plus(right, 1 if operation == "add" else -1)
        if operation == "mul" and not (left.terms and right.terms):
            return left.times(right.constant) if left.terms else right.times(left.constant)
        if operation in _QUOTIENTS and not right.terms:
            return self._quotient(left, right.constant, operation)
        raise _Odd(f"an expression by {operation}")

    def _quotient(self, dividend: Form, divisor: int, operation: str) -> Form:
        """What isl's quotients are; those of numbers that may be negative are taken of numbers that
        are not, larger by a multiple of the divisor.
        """
        more = 0
        if operation in _OF_NEGATIVE and divisor & (divisor - 1):
            more = _MOST // divisor
        made = Quotient(dividend.plus(Form((), more * divisor)), divisor, operation in _REMAINDERS)
        if made not in self._known:
            self._known[made] = f"q{len(self._known)}"
            self.quotients[self._known[made]] = made
        shift = 0 if made.remainder else -more
        return symbol(self._known[made]).plus(Form((), shift))


def _name(kind: object) -> str:
    """The name of a value of isl's enumerations, without the underscore of Python's keywords."""
    return str(getattr(kind, "name", kind)).rstrip("_")


def _operation(expression: isl.AstExpr) -> str:
    is_operation = _name(expression.get_type()) == "op"
    return _name(expression.get_op_type()) if is_operation else ""


def _arguments(expression: isl.AstExpr) -> list[isl.AstExpr]:
    return [expression.get_op_arg(n) for n in range(expression.get_op_n_arg())]


def runs_in(code: Iterable[Code]) -> Iterator[Run]:
    """All iterations of statements, in the order of the text."""
    for item in code:
        if isinstance(item, Run):
            yield item
        else:
            yield from runs_in(
                item.body if isinstance(item, For) else (*item.then, *item.otherwise)
            )


def fors_in(code: Iterable[Code]) -> Iterator[For]:
    """All loops, those around before those inside."""
    for item in code:
        if isinstance(item, For):
            yield item
            yield from fors_in(item.body)
        elif isinstance(item, If):
            yield from fors_in((*item.then, *item.otherwise))


def iterations_of(code: Iterable[Code], around: int = 1) -> dict[str, int]:
    """How many of the source's iterations one of each loop stands for, by name: those that run
    together in it, of the loops around it too.
    """
    found: dict[str, int] = {}
    for item in code:
        if isinstance(item, For):
            found[item.name] = around * item.step
            found |= iterations_of(item.body, found[item.name])
        elif isinstance(item, If):
            found |= iterations_of((*item.then, *item.otherwise), around)
    return found


def expected_trips(loops: Loops, symbols: Mapping[str, float]) -> dict[str, float]:
    """Iterations of each loop, by name, where symbols have these values, and how often the test of
    each branch holds: averages of what lengths near them give, so that a remainder is half of what
    it may be.
    """
    return _Expected(loops, symbols).trips


class _Expected:
    def __init__(self, loops: Loops, symbols: Mapping[str, float]) -> None:
        self.quotients = loops.quotients
        self.values = {name: (value, 0.0) for name, value in symbols.items()}
        self.trips: dict[str, float] = {}
        self._walk(loops.code)

    def _of(self, one: Form) -> tuple[float, float]:
        """A form's mean, and how far it is from that at most."""
        named = [(self._named(name), factor) for name, factor in one.terms]
        mean = one.constant + sum(factor * value for (value, _), factor in named)
        return mean, sum(abs(factor) * spread for (_, spread), factor in named)

    def _named(self, name: str) -> tuple[float, float]:
        quotient = self.quotients.get(name)
        if quotient is None:
            return self.values[name]
        half = (quotient.divisor - 1) / 2
        if quotient.remainder:
            return half, half
        mean, spread = self._of(quotient.dividend)
        return (mean - half) / quotient.divisor, spread / quotient.divisor

    def _whole(self, loop: For) -> int | None:
        """The rest by a step of what limits a loop, if that is without the rest of a length by it:
        of `n - n % 4 + 1` it is 1. Or if the rest is before what it starts at.
        """
        for limit in loop.limit:
            for name, factor in limit.terms:
                quotient = self.quotients.get(name)
                if quotient is None or quotient.divisor % loop.step:
                    continue
                left = limit.plus(symbol(name), -factor)
                if quotient.remainder and factor == -1:
                    left = left.plus(quotient.dividend, -1)
                return left.constant
        taken = (self.quotients.get(name) for one in loop.first for name in one.names)
        is_before = any(q is not None and q.divisor % loop.step == 0 for q in taken)
        return loop.limit[0].constant if is_before else None

    def _walk(self, code: tuple[Code, ...]) -> None:
        for item in code:
            if isinstance(item, For):
                first = max(self._of(one)[0] for one in item.first)
                limit = min(self._of(one)[0] for one in item.limit)
                lacks = (item.step - 1) / 2 if limit > first else 0.0
                if not any(one.terms for one in (*item.first, *item.limit)):
                    lacks = (first - limit) % item.step if limit > first else 0.0
                elif (rest := self._whole(item)) is not None:
                    lacks = (item.first[0].constant - rest) % item.step
                self.trips[item.name] = max(limit - first + lacks, 0.0) / item.step
                self.values[item.name] = (first + limit) / 2, max(limit - first, 0.0) / 2
                self._walk(item.body)
            elif isinstance(item, If):
                self.trips[item.name] = min(max(self._chance(item.test), _RARE), 1.0 - _RARE)
                self._walk(item.then)
                self._walk(item.otherwise)

    def _chance(self, test: Test) -> float:
        """How often a test holds."""
        parts = [self._chance(part) for part in test.parts]
        if test.relation == "and":
            return math.prod(parts)
        if test.relation == "or":
            return 1.0 - math.prod(1.0 - part for part in parts)
        mean, spread = self._of(test.left)
        if test.relation == "==":
            return 1.0 / (2.0 * spread + 1.0) if abs(mean) <= spread else 0.0
        if test.relation in ("<", "<="):
            mean = -mean
        mean += 0.5 if test.relation in ("<=", ">=") else -0.5
        return min(max((mean + spread + 0.5) / (2.0 * spread + 1.0), 0.0), 1.0)

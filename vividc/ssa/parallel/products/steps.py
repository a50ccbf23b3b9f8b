"""Changes of a static-control part as steps: matrix products, and what is done to each element."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from vividc.machine.opcodes import Opcode
from vividc.machine.product import (
    COL,
    INNER,
    ROW,
    Axis,
    Edge,
    Elementwise,
    Product,
    Range,
    Size,
    Step,
    Term,
    View,
)
from vividc.ssa.ir import Const, Input
from vividc.ssa.parallel.products.effects import Effect, Element, Expression, NoProduct
from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.scop import Dimension, Scop

_ADDING = (Opcode.FMA.value, Opcode.FNMA.value)


def order_of(effect: Effect) -> tuple[str, ...]:
    """The coordinates of a change, those that it sums over last."""
    inner = inner_dims(effect)
    names = effect.statement.coordinates
    return (*(n for n in names if n not in inner), *(n for n in names if n in inner))


def inner_dims(effect: Effect) -> tuple[str, ...]:
    """Coordinates that do not choose the element that changes."""
    chosen = {name for one in effect.target.subscripts for name in one.names}
    return tuple(name for name in effect.statement.coordinates if name not in chosen)


def step_of(effect: Effect, scop: Scop) -> Step:
    """A change as a step; its result's first subscript that has a coordinate is of rows.

    Raises
    ------
    NoProduct
        It is neither a product nor done to each element once.
    """
    inner = inner_dims(effect)
    if not inner:
        return _Shape(effect, scop, {}).elementwise()
    if len(inner) > 1:
        raise NoProduct(f"it sums over {len(inner)} loops")
    return _Shape(effect, scop, {inner[0]: INNER}).product()


@dataclass
class _Shape:
    effect: Effect
    scop: Scop
    roles: dict[str, int]

    def __post_init__(self) -> None:
        for one in self.effect.target.subscripts:
            for name in one.names & set(self.effect.statement.coordinates) - self.roles.keys():
                self._take(name)

    def _take(self, name: str) -> None:
        taken = [role for role in (ROW, COL) if role in self.roles.values()]
        if len(taken) > COL:
            raise NoProduct("its result has more than two dimensions")
        self.roles[name] = len(taken)

    def elementwise(self) -> Elementwise:
        """What is done to each element."""
        effect = self.effect
        result = self._view(effect.target)
        ranges, edges = self._ranges()
        return Elementwise(result, self._term(effect.value), ranges[:INNER], edges, effect.line)

    def product(self) -> Product:
        """A sum of products."""
        effect = self.effect
        value = effect.value
        adds = value.op in _ADDING and value.args[2].element == effect.target
        if not adds:
            raise NoProduct("what its inner loop does is not to add a product to a sum")
        left, right = value.args[:2]
        for one, other in ((left, right), (right, left)):
            if ROW in self._used(other) or COL in self._used(one):
                continue
            is_negated = value.op == Opcode.FNMA.value
            factor = Expression(Opcode.FNEG.value, (one,)) if is_negated else one
            ranges, edges = self._ranges()
            result = self._view(effect.target)
            terms = self._term(factor), self._term(other)
            start = Term("load", view=result)
            return Product(*terms, result, ranges, start, edges=edges, line=effect.line)
        raise NoProduct(
            "what it multiplies are not elements of two matrices, one of rows and the inner loop, "
            "one of the inner loop and columns"
        )

    def _used(self, expression: Expression) -> set[int]:
        names = (
            n for element in expression.elements() for f in element.subscripts for n in f.names
        )
        return {self.roles[name] for name in names if name in self.roles}

    def _term(self, one: Expression) -> Term:
        view = None if one.element is None else self._view(one.element)
        return Term(one.op, tuple(map(self._term, one.args)), view, one.key, one.word)

    def _view(self, element: Element) -> View:
        return View(element.array, tuple(map(self._axis, element.subscripts)))

    def _axis(self, subscript: Form) -> Axis:
        own = [(name, factor) for name, factor in subscript.terms if name in self.roles]
        if len(own) > 1:
            raise NoProduct("a subscript is made of several loops' counters")
        name, factor = own[0] if own else ("", 0)
        rest = subscript.plus(symbol(name), -factor) if own else subscript
        return Axis(self.roles.get(name, -1), factor, self._size(rest))

    def _size(self, one: Form) -> Size:
        total, terms = one.constant, dict[str, int]()
        for name, factor in one.terms:
            if name not in self.scop.symbols:
                raise NoProduct("a subscript or bound depends on a counter of another loop")
            value = self.scop.function.settled(self.scop.symbols[name])
            if isinstance(value, Const):
                total += factor * value.word
            elif isinstance(value, Input):
                terms[value.key] = terms.get(value.key, 0) + factor
            else:
                raise NoProduct("a size is computed before its loops")
        return Size(total, tuple(sorted((k, f) for k, f in terms.items() if f)))

    # --- what the coordinates go through ----------------------------------------------------------

    def _ranges(self) -> tuple[tuple[Range, ...], tuple[Edge, ...]]:
        """Of rows, columns and the inner loop: the least box around them, and its edges."""
        ranges = [Range(Size(), Size(1))] * 3
        edges: list[Edge] = []
        boxes: dict[str, tuple[Form, Form]] = {}
        for dim in self.effect.dims:
            boxes[dim.name] = first, limit = self._box(dim, boxes)
            ranges[self.roles[dim.name]] = Range(self._size(first), self._size(limit))
            for bound, sign in zip(dim.bounds, (1, -1), strict=True):
                if not bound.names.isdisjoint(self.roles):
                    inside = symbol(dim.name).plus(bound, -1).times(sign)
                    edges.append(self._edge(dim, inside.plus(Form((), min(sign, 0)))))
        return tuple(ranges), tuple(edges)

    def _box(self, dim: Dimension, boxes: Mapping[str, tuple[Form, Form]]) -> tuple[Form, Form]:
        found = []
        for bound, most in zip(dim.bounds, (False, True), strict=True):
            result = bound
            for name, factor in bound.terms:
                if name in boxes:
                    first, limit = boxes[name]
                    last = limit.plus(Form((), -1))
                    at = last if (factor > 0) is most else first
                    result = result.plus(symbol(name), -factor).plus(at, factor)
            found.append(result)
        return found[0], found[1]

    def _edge(self, dim: Dimension, inside: Form) -> Edge:
        factors = {self.roles[name]: factor for name, factor in inside.terms if name in self.roles}
        if INNER in factors:
            raise NoProduct("how long its sums are depends on their place")
        rest = Form(tuple(t for t in inside.terms if t[0] not in self.roles), inside.constant)
        return Edge(factors.get(ROW, 0), factors.get(COL, 0), self._size(rest))


def folded(steps: list[Step]) -> list[Step]:
    """Steps, what a product starts from and what follows it being part of it."""
    steps = [step for number, step in enumerate(steps) if not _is_overwritten(steps, number)]
    steps = [_copied(steps, number) for number in range(len(steps))]
    number = 0
    while number < len(steps):
        product = steps[number]
        if isinstance(product, Product):
            before = _before(steps, number)
            if before is not None:
                product = replace(product, start=_start(steps[before]))
                steps[number] = product
                del steps[before]
                number -= 1
                continue
            behind = _behind(steps, number)
            if behind is not None:
                steps[number] = _finished(product, behind[1])
                del steps[behind[0]]
                continue
        number += 1
    for number in range(1, len(steps)):
        steps[number - 1 : number + 1] = _squared(steps[number - 1], steps[number])
    return steps


def _squared(one: Step, image: Step) -> tuple[Step, Step]:
    """A triangle and its mirror image in the same square, of which their edges leave the rest."""
    if not isinstance(image, Elementwise) or not image.edges:
        return one, image
    turned = image.swapped()
    is_image = one.result == turned.value.view == image.result
    side = _around(*image.ranges)
    if not is_image or (one.ranges[:INNER], one.edges) != (turned.ranges, turned.edges) or not side:
        return one, image
    rest = one.ranges[INNER:]
    return replace(one, ranges=(side, side, *rest)), replace(image, ranges=(side, side))


def _around(one: Range, other: Range) -> Range | None:
    """The least range around two, if they differ by constants."""
    if (one.first.terms, one.limit.terms) != (other.first.terms, other.limit.terms):
        return None
    firsts = sorted((one.first, other.first), key=lambda size: size.constant)
    limits = sorted((one.limit, other.limit), key=lambda size: size.constant)
    return Range(firsts[0], limits[1])


def _is_overwritten(steps: list[Step], number: int) -> bool:
    """Whether a later step replaces all that a step makes before anything reads it."""
    step = steps[number]
    if isinstance(step, Product):
        return False
    for other in steps[number + 1 :]:
        if step.result.array in arrays_of(other):
            same = (other.result, other.ranges, other.edges) == (
                step.result,
                step.ranges,
                step.edges,
            )
            return same and all(view.array != step.result.array for view in other.views)
    return False


def _copied(steps: list[Step], number: int) -> Step:
    """A step that stores a carried value, as a copy of what an earlier one makes of the same."""
    step = steps[number]
    if isinstance(step, Product) or not any(v.array.startswith("%") for v in step.views):
        return step
    for place in range(number):
        before = steps[place]
        for made in (step, step.swapped()):
            if isinstance(before, Product) or (made.value, made.ranges, made.edges) != (
                before.value,
                before.ranges,
                before.edges,
            ):
                continue
            array = before.result.array
            if all(one.result.array != array for one in steps[place + 1 : number]):
                copy = replace(made, value=Term("load", view=before.result))
                return copy if made is step else copy.swapped()
    return step


def _start(step: Step) -> Term:
    assert isinstance(step, Elementwise)
    return step.value


def _before(steps: list[Step], number: int) -> int | None:
    """The step that sets what a product starts from."""
    product = steps[number]
    assert isinstance(product, Product)
    if product.start != Term("load", view=product.result):
        return None
    for place in range(number - 1, -1, -1):
        step = steps[place]
        if isinstance(step, Elementwise) and step.result == product.result:
            same = (step.ranges, step.edges) == (product.ranges[:INNER], product.edges)
            return place if same and _may_move(step, steps[place + 1 : number]) else None
        if product.result.array in arrays_of(step):
            return None
    return None


def _behind(steps: list[Step], number: int) -> tuple[int, Elementwise] | None:
    """The step that alone reads a product's result, or replaces it."""
    product = steps[number]
    assert isinstance(product, Product)
    name = product.result.array
    for place in range(number + 1, len(steps)):
        step = steps[place]
        if name not in arrays_of(step):
            continue
        if not isinstance(step, Elementwise):
            return None
        for made in (step, step.swapped()):
            read = {view for view in made.views if view.array == name}
            same = (made.ranges, made.edges) == (product.ranges[:INNER], product.edges)
            alone = made.result == product.result or name.startswith("%")
            if read == {product.result} and same and alone:
                rest = steps[number + 1 : place]
                return (place, made) if _may_move(step, rest) else None
        return None
    return None


def _finished(product: Product, step: Elementwise) -> Product:
    """A product with what follows it; rows are of its first subscript again."""
    done = replace(product, finish=step.value.with_sum(product.result), result=step.result)
    order = [axis.coordinate for axis in done.result.axes if axis.coordinate >= 0]
    return done.swapped() if order and order[0] == COL else done


def _may_move(step: Step, others: list[Step]) -> bool:
    """Whether a step may run before or behind others."""
    read, written = {view.array for view in step.views}, step.result.array
    return all(
        other.result.array not in read and written not in arrays_of(other) for other in others
    )


def arrays_of(step: Step) -> set[str]:
    """What a step reads and writes."""
    return {step.result.array, *(view.array for view in step.views)}

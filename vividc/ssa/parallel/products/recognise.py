"""Recognises matrix products on the statements, domains and dependences of a function's nests.

Each change that a nest makes (`effects`) is a step: an update that adds a product to an element
for each of an inner coordinate, or something that is done to each element once (`steps`). The nest
is these steps one after the other if its dependences let all iterations of one run before those of
the next, those of a sum in their order. So neither the order of the loops matters, nor what else
they do beside, nor whether sums are in memory.
"""

from __future__ import annotations

from dataclasses import dataclass

from vividc.machine.params import TRAP
from vividc.machine.product import Elementwise, Product, Size, Step, is_mirror
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop, find_loops, flow_of
from vividc.ssa.ir import Function
from vividc.ssa.parallel.products.checks import demand_only_checks
from vividc.ssa.parallel.products.effects import (
    NoProduct,
    effects_of,
    may_be_apart,
    with_stores_behind,
)
from vividc.ssa.parallel.products.rows import with_rows
from vividc.ssa.parallel.products.steps import folded, order_of, step_of
from vividc.ssa.polyhedral.scop import Scop, find_scop


@dataclass(frozen=True)
class Found:
    """What was found in a function.

    Attributes
    ----------
    steps
        What the whole function does; () if that is not all known.
    products
        The matrix products among it.
    strides
        Arrays of two dimensions whose rows are as long as these numbers, if a launch proves it.
    reason
        Why the function is not a sequence of steps with a product, as the end of "no matrix
        product: ..."; "": it is one.
    """

    steps: tuple[Step, ...]
    products: tuple[Product, ...]
    strides: tuple[tuple[str, Size], ...] = ()
    reason: str = ""


def recognise(function: Function) -> Found:
    """The steps of a function whose loops are canonical and whose products and sums are fused."""
    function, strides = with_rows(function)
    loops = find_loops(function)
    outer = [one for one in loops if not any(_is_around(other, one) for other in loops)]
    order = flow_of(function).order
    outer.sort(key=lambda one: order.index(one.header))
    steps: list[Step] = []
    reasons: list[str] = []
    for loop in outer:
        try:
            steps += _of_nest(function, loop)
        except NoProduct as reason:
            line = block_of(function, loop.header).branch.loc
            reasons.append(f"{reason} (line {line.line})" if line else str(reason))
    steps = folded(steps)
    products = tuple(step for step in steps if isinstance(step, Product))
    try:
        _demand_whole(function, steps, outer, reasons)
    except NoProduct as reason:
        return Found((), products, reason=str(reason))
    return Found(tuple(steps), products, strides)


def _demand_whole(
    function: Function, steps: list[Step], outer: list[Loop], reasons: list[str]
) -> None:
    if reasons:
        raise NoProduct(reasons[0])
    if not any(isinstance(step, Product) for step in steps):
        raise NoProduct("no loop adds products to sums")
    if function.returns is not None:
        raise NoProduct("it returns a value")
    if any(not local.name.startswith(TRAP) for local in function.locals):
        raise NoProduct("it makes arrays of its own")
    for step in steps:
        if step.result.array.startswith("%") or any(v.array[0] == "%" for v in step.views):
            raise NoProduct("a value that a loop carries is more than a sum")
        _demand_apart(step)
    demand_only_checks(function, steps, outer)


def _demand_apart(step: Step) -> None:
    """No element is computed from others of the same array, unless it is those' mirror image."""
    if isinstance(step, Elementwise) and is_mirror(step):
        return
    factors = (step.left, step.right) if isinstance(step, Product) else ()
    read = {view.array for factor in factors for view in factor.views}
    others = {view.array for view in step.views if view != step.result}
    if step.result.array in read | others:
        raise NoProduct(f"it overwrites elements of {step.result.array} that it reads")


def _of_nest(function: Function, loop: Loop) -> list[Step]:
    scop = find_scop(with_own_latches(function, loop.header), loop.header)
    if not isinstance(scop, Scop):
        raise NoProduct(scop.reason)
    if any(statement.guards for statement in scop.statements):
        raise NoProduct("its body branches")
    scop = with_stores_behind(scop)
    effects = effects_of(scop)
    made = [step_of(effect, scop) for effect in effects]
    if effects and not may_be_apart(scop, effects, tuple(map(order_of, effects))):
        raise NoProduct("its parts need each other's results in turn")
    return made


def _is_around(one: Loop, other: Loop) -> bool:
    return one is not other and other.header in one.blocks

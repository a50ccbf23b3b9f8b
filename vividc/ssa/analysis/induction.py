"""Induction variables: phis of a loop's header to which every iteration adds the same value."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from vividc.machine.words import signed
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Block, Const, Function, Instr, Int, Phi, Ref, Value, definition_of

Body = frozenset[str]
"""Names of a loop's blocks."""


@dataclass(frozen=True, slots=True)
class Induction:
    """An induction variable, of words or of LLVM's integers.

    Attributes
    ----------
    start
        Its value in the first iteration; None if the ways into the loop bring different ones.
    update
        The addition (or subtraction) whose result it is in the next iteration.
    by
        What `update` adds or subtracts; it does not change in the loop.
    """

    phi: Phi
    start: Value | None
    update: Instr
    by: Value

    @property
    def step(self) -> int | None:
        """What each iteration adds, if it is a constant."""
        sign = -1 if self.update.mnemonic == "sub" else 1
        if isinstance(self.by, Int):
            return sign * self.by.value
        return signed(sign * self.by.word) if isinstance(self.by, Const) else None


def induction_of(function: Function, body: Body, phi: Phi) -> Induction | None:
    """The induction variable that a phi of a loop's header is."""
    starts = {value for source, value in phi.incoming if source not in body}
    again = {value for source, value in phi.incoming if source in body}
    update = definition_of(function, again.pop()) if starts and len(again) == 1 else None
    if not isinstance(update, Instr) or update.mnemonic not in ("add", "sub"):
        return None
    left, by = update.operands
    if left != Ref(phi.id) and update.mnemonic == "add":
        left, by = by, left
    if left != Ref(phi.id) or not is_invariant(function, body, by):
        return None
    return Induction(phi, starts.pop() if len(starts) == 1 else None, update, by)


def constant_step(function: Function, loop: Loop, phi: Phi) -> int | None:
    """What each iteration adds to a phi of the header, if it is the same constant every time."""
    induction = induction_of(function, loop.blocks, phi)
    return None if induction is None else induction.step


def initial(phi: Phi, body: Body) -> Value:
    """The value of a header's phi in the first iteration, of a loop with one preheader."""
    return next(value for source, value in phi.incoming if source not in body)


def is_invariant(function: Function, body: Body, value: Value) -> bool:
    """Whether `value` is defined outside the loop."""
    return not isinstance(value, Ref) or function.block_of.get(value.id) not in body


def never_wraps(function: Function, body: Body, value: Value, *, by_one: bool) -> bool:
    """Whether an induction variable, or a sum of some, stays a signed word for as long as a
    comparison with a fixed limit holds.

    A counter that the limit is compared with and that moves by one meets the limit before it can
    wrap; others need every addition on the way to be `exact`.
    """
    if is_invariant(function, body, value):
        return True
    item = definition_of(function, value)
    if isinstance(item, Phi):
        induction = induction_of(function, body, item)
        return induction is not None and (by_one or induction.update.exact)
    return (
        item is not None
        and item.exact
        and all(never_wraps(function, body, operand, by_one=False) for operand in item.operands)
    )


def computed_from(blocks: Iterable[Block], first: Value) -> set[Value]:
    """`first`, and the values of these blocks that are computed from it; not by what was stored."""
    found: set[Value] = {first}
    items = [item for block in blocks for item in block.items]
    size = 0
    while len(found) > size:
        size = len(found)
        for item in items:
            if isinstance(item, Phi):
                read = tuple(value for _, value in item.incoming)
            else:
                read = item.operands
            if any(value in found for value in read):
                found.add(Ref(item.id))
    return found

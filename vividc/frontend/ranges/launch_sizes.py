"""Sizes that are known at launch: an upper bound of an integer as a formula over launch inputs.

An array of the kernel's own whose size follows from shapes and scalar parameters gets its place
when the program is launched. The bound is exact for sums, products and quotients of them; of a
choice it is the larger branch, of a difference the smaller subtrahend that the ranges prove, of a
loop's counter its start or its limit.
"""

from __future__ import annotations

from vividc.frontend.ranges.assumed import assumed, no_more
from vividc.frontend.ranges.formulas import shortened
from vividc.frontend.ranges.interval import Interval
from vividc.frontend.ranges.ranges import Ranges
from vividc.machine.params import MAX_DIMENSION, Formula
from vividc.ssa.ir import (
    Function,
    Input,
    Instr,
    Int,
    Key,
    Phi,
    Ref,
    Value,
    definition_of,
    is_dimension,
)

_LARGEST = 1 << 31
"""What no counter goes below."""
_ALIASES = frozenset({"zext", "sext", "trunc", "freeze", "udiv", "lshr"})
"""What gives its operand, or less of one that is not negative."""
_FEW = 1 << 10
"""A constant bound is taken where there is no other up to here."""
_DEPTH = 64
_LONGEST = 400
_SHORT = 24
"""A formula of more items is made shorter: one for the shape of a broadcast has each of its arrays.
"""

_OPPOSITES = {"sgt": "sle", "sge": "slt", "ugt": "ule", "uge": "ult"}
"""What holds where a comparison does not."""

_Asked = tuple[Key, str, bool, frozenset[int]]
"""A value, where, whether it is signed, and the phis that are assumed to have a bound."""


class LaunchSizes:
    """Upper bounds of a function's integers."""

    def __init__(self, function: Function) -> None:
        self._function = function
        self._params = dict(function.inputs)
        bounds: dict[Key, Interval] = {
            name: (0, MAX_DIMENSION * 4) for name in self._params if is_dimension(Input(name))
        }
        self._ranges = Ranges(function, bounds)
        self._loops = self._ranges.flow.loops
        self._assumed: frozenset[int] = frozenset()
        self._bounds: dict[_Asked, Formula] = {}
        self._unbounded: dict[_Asked, int] = {}
        self._counters = {
            phi.id: name for name in self._loops for phi in function.by_name[name].phis
        }

    def bound(self, operand: Value, block: str) -> Formula | None:
        """What `operand` is at most while `block` runs; None: nothing known at launch bounds it."""
        formula = self._bound(operand, block, False, _DEPTH)
        return None if formula is None or len(formula) > _LONGEST else formula

    def _bound(self, operand: Value, block: str, signed: bool, depth: int) -> Formula | None:
        """As `bound`, found once: neither what has a bound nor what had none, looked at as deep."""
        if not isinstance(operand, Ref):
            return self._known(operand, block, signed, depth)
        key = operand.key, block, signed, self._assumed
        if key not in self._bounds and self._unbounded.get(key, -1) < depth:
            formula = self._known(operand, block, signed, depth)
            if formula is None:
                self._unbounded[key] = depth
            else:
                self._bounds[key] = formula if len(formula) <= _SHORT else shortened(formula)
        return self._bounds.get(key)

    def _known(self, operand: Value, block: str, signed: bool, depth: int) -> Formula | None:
        formula = self._formula(operand, block, signed, depth)
        if formula is None and depth:
            high = self._ranges.at(operand, block)[1]
            return (high,) if high <= _FEW else None
        return formula

    def _formula(self, operand: Value, block: str, signed: bool, depth: int) -> Formula | None:
        if isinstance(operand, Int):
            return (operand.value,)
        if not depth:
            return None
        if isinstance(operand, Input):
            wide = self._params[operand.key] == "i64"
            return (("s:" if signed or wide else "u:") + operand.key,)
        definition = definition_of(self._function, operand)
        if isinstance(definition, Phi):
            return self._joined(definition, block, depth)
        if isinstance(definition, Instr):
            return self._of(definition, block, signed, depth)
        return None

    def _joined(self, phi: Phi, block: str, depth: int) -> Formula | None:
        if phi.id in self._counters:
            return self._counter(phi, depth)
        return self._all("max", [value for _, value in phi.incoming], block, depth)

    def _of(self, op: Instr, block: str, signed: bool, depth: int) -> Formula | None:
        if op.source == "i1":
            return (0,) if op.op == "sext" else (1,)
        if op.op in ("sdiv", "udiv") and isinstance(op.operands[1], Int) and op.operands[1].value:
            return self._quotient(op.operands[0], op.operands[1].value, block, depth)
        if op.op in _ALIASES:
            given = op.op == "sext" or "nneg" in op.flags
            return self._bound(op.operands[0], block, given, depth - 1)
        if op.op == "xor" and op.operands[1] == Int(-1):  # -1 - x
            less = self._negative(op.operands[0], block, depth - 1)
            return None if less is None else (*less, -1, "+")
        if op.op == "add" and signed and "nsw" in op.flags:
            return self._all("+", op.operands, block, depth, signed=True)
        rules = {"mul": self._product, "shl": self._product, "sub": self._difference}
        rules |= dict.fromkeys(("sdiv", "sfloordiv", "ufloordiv", "ashr"), self._divided)
        rules |= {"add": self._sum, "or": self._sum, "select": self._choice, "call": self._call}
        rule = rules.get(op.mnemonic)
        return None if rule is None else rule(op, block, depth)

    def _sum(self, op: Instr, block: str, depth: int) -> Formula | None:
        """A sum; of a disjunction with a constant the sum is a bound."""
        right = op.operands[1]
        if op.op == "or" and not (isinstance(right, Int) and right.value >= 0):
            return None
        return self._all("+", op.operands, block, depth)

    def _difference(self, op: Instr, block: str, depth: int) -> Formula | None:
        left = self._bound(op.operands[0], block, False, depth - 1)
        less = self._negative(op.operands[1], block, depth - 1)
        return None if left is None or less is None else (*left, *less, "+")

    def _divided(self, op: Instr, block: str, depth: int) -> Formula | None:
        """Of a division by a positive constant, of which what is negative has none above 0; by
        anything else an input is no more than itself without its sign.
        """
        by = op.operands[1]
        left = self._bound(op.operands[0], block, op.op != "ufloordiv", depth - 1)
        if left is None:
            return None
        if isinstance(by, Int) and by.value > 0:
            divisor = 1 << by.value if op.op == "ashr" else by.value
            return (*left, 0, "max", divisor, "//")
        if op.op == "ashr" or not _is_input(left):
            return None
        return (*left, *left, -1, "*", "max")

    def _quotient(self, dividend: Value, divisor: int, block: str, depth: int) -> Formula | None:
        """A quotient that rounds to zero, by a constant: of a negative one 0 is a bound."""
        most = self._bound(dividend, block, False, depth - 1)
        if divisor < 0:
            most = self._negative(dividend, block, depth - 1)
        return None if most is None else (*most, 0, "max", abs(divisor), "//")

    def _negative(self, operand: Value, block: str, depth: int) -> Formula | None:
        """What minus `operand` is at most: a constant, or of an input, a sum, a difference, a
        choice its other sign.
        """
        known = self._negative_input(operand)
        op = definition_of(self._function, operand)
        if known is None and isinstance(op, Instr) and depth:
            known = self._negative_of(op, block, depth - 1)
        if known is not None:
            return known
        low = self._ranges.at(operand, block)[0]
        # That a dimension is no longer than a scratchpad is no size for an array.
        return (-low,) if low > -MAX_DIMENSION else None

    def _negative_input(self, operand: Value) -> Formula | None:
        """Minus an input, in as many bits as it is launched with."""
        sign = "s:"
        op = definition_of(self._function, operand)
        if isinstance(op, Instr) and op.op in ("sext", "zext", "freeze"):
            operand, sign = op.operands[0], "u:" if op.op == "zext" else "s:"
        elif not isinstance(operand, Input) or self._params[operand.key] != "i64":
            return None
        if not isinstance(operand, Input) or self._params[operand.key] not in ("i32", "i64"):
            return None
        return (f"{sign}{operand.key}", -1, "*")

    def _negative_of(self, op: Instr, block: str, depth: int) -> Formula | None:
        """Minus a sum, a difference or a choice."""
        if op.op == "sub":
            right = self._bound(op.operands[1], block, False, depth)
            less = self._negative(op.operands[0], block, depth)
            return None if right is None or less is None else (*right, *less, "+")
        operator, operands = "max", op.operands[-2:]
        if op.op == "add" and "nsw" in op.flags:
            operator = "+"
        elif op.op == "call" and op.pred.startswith(("llvm.smax", "llvm.umax")):
            operator = "min"
        elif op.op != "select" and not op.pred.startswith(("llvm.smin", "llvm.umin")):
            return None
        one, other = (self._negative(arg, block, depth) for arg in operands)
        if one is None or other is None:
            return one or other if operator == "min" else None
        return (*one, *other, operator)

    def _counter(self, phi: Phi, depth: int) -> Formula | None:
        """A loop's counter: its start or, if it grows, the limit that its header tests."""
        if phi.id in self._assumed:
            return (assumed(phi.id),)
        header = self._counters[phi.id]
        body = self._loops[header]
        steps = [self._step(phi, value) for pred, value in phi.incoming if pred in body]
        starts = [value for pred, value in phi.incoming if pred not in body]
        first = self._all("max", starts, header, depth)
        known = [step for step in steps if step is not None]
        if first is None:
            return None
        if len(known) < len(steps):
            return self._climbing(phi, first, depth) or self._not_growing(phi, first, depth)
        if max(known) <= 0:
            is_word = self._ranges.at(Ref(phi.id), header)[0] >= -_LARGEST
            return first if is_word else None
        limit = self._limit(phi, header, depth)
        return None if limit is None else (*first, *limit, max(known) - 1, "+", "max")

    def _climbing(self, phi: Phi, first: Formula, depth: int) -> Formula | None:
        """What counts in some iterations of a loop: its start, and the most that an iteration adds
        as often as the loop runs.
        """
        header = self._counters[phi.id]
        body = self._loops[header]
        rises = [
            self._rise(phi, value, pred, depth) for pred, value in phi.incoming if pred in body
        ]
        known = [rise for rise in rises if rise is not None]
        runs = self._runs(header, depth)
        if runs is None or len(known) < len(rises) or not 0 <= max(known) <= _FEW:
            return None
        return (*first, *runs, 0, "max", max(known), "*", "+")

    def _not_growing(self, phi: Phi, first: Formula, depth: int) -> Formula | None:
        """What an iteration hands on to the next one, such as how long an array is that it selects
        from one of the iteration before: by induction, its start or what else it may be.
        """
        body = self._loops[self._counters[phi.id]]
        before, bound = self._assumed, first
        self._assumed = before | {phi.id}
        try:
            for pred, value in phi.incoming:
                if pred in body:
                    again = self._bound(value, pred, False, depth - 1)
                    known = None if again is None else no_more(again, assumed(phi.id))
                    if known is None:
                        return None
                    bound = (*bound, *known, "max") if known else bound
        finally:
            self._assumed = before
        return bound

    def _rise(self, phi: Phi, value: Value, block: str, depth: int) -> int | None:
        """How much more than `phi` a value of the same iteration is at most."""
        if value == Ref(phi.id):
            return 0
        op = definition_of(self._function, value)
        if op is None or not depth:
            return None
        if isinstance(op, Phi):
            if op.id in self._counters:  # of a loop inside
                return None
            ways = [(value, pred) for pred, value in op.incoming]
        elif op.op == "select":
            ways = [(value, block) for value in op.operands[1:]]
        elif op.op == "add" and op.type == "i64":
            added = self._ranges.at(op.operands[1], block)[1]
            rise = self._rise(phi, op.operands[0], block, depth - 1)
            return None if rise is None or not 0 <= added <= _FEW else rise + added
        else:
            return None
        rises = [self._rise(phi, value, pred, depth - 1) for value, pred in ways]
        known = [rise for rise in rises if rise is not None]
        return max(known) if known and len(known) == len(rises) else None

    def _runs(self, header: str, depth: int) -> Formula | None:
        """How often a loop runs at most, by a counter that begins at a constant and grows."""
        body = self._loops[header]
        for phi in self._function.by_name[header].phis:
            starts = [value for pred, value in phi.incoming if pred not in body]
            steps = [self._step(phi, value) for pred, value in phi.incoming if pred in body]
            if not all(isinstance(start, Int) and start.value >= 0 for start in starts):
                continue
            if all(step is not None and step >= 1 for step in steps):
                limit = self._limit(phi, header, depth)
                if limit is not None:
                    return limit
        return None

    def _step(self, phi: Phi, again: Value) -> int | None:
        op = definition_of(self._function, again)
        if not isinstance(op, Instr) or op.op != "add" or op.operands[0] != Ref(phi.id):
            return None
        return op.operands[1].value if isinstance(op.operands[1], Int) else None

    def _limit(self, phi: Phi, header: str, depth: int) -> Formula | None:
        """What the counter is below of, when the loop goes on."""
        leave = self._function.by_name[header].branch
        test = definition_of(self._function, leave.cond)
        inside = [target in self._loops[header] for target in leave.successors]
        if (
            not isinstance(test, Instr)
            or sorted(inside) != [False, True]
            or test.operands[0] != Ref(phi.id)
        ):
            return None
        pred = test.pred if inside[0] else _OPPOSITES.get(test.pred, "")
        limit = test.operands[1]
        is_signed = pred in ("slt", "sle")
        if not is_signed and (pred not in ("ult", "ule") or self._ranges.at(limit, header)[0] < 0):
            return None
        bound = self._bound(limit, header, is_signed, depth - 1)
        return (*bound, 1, "+") if bound and pred.endswith("le") else bound

    def _choice(self, op: Instr, block: str, depth: int) -> Formula | None:
        return self._all("max", op.operands[1:], block, depth)

    def _call(self, op: Instr, block: str, depth: int) -> Formula | None:
        signed = op.pred.startswith(("llvm.smax", "llvm.smin"))
        if op.pred.startswith(("llvm.smax", "llvm.umax")):
            return self._all("max", op.operands, block, depth, signed=signed)
        if op.pred.startswith(("llvm.smin", "llvm.umin")):
            known = [self._bound(arg, block, signed, depth - 1) for arg in op.operands]
            one, other = known
            if one is None or other is None:
                return one or other
            return (*one, *other, "min")
        return None

    def _product(self, op: Instr, block: str, depth: int) -> Formula | None:
        left, right = op.operands
        if op.op == "shl":
            if not isinstance(right, Int):
                return None
            right = Int(1 << right.value)
        one, other = (self._bound(arg, block, False, depth - 1) for arg in (left, right))
        if one is None or other is None:
            return None
        scaled = isinstance(right, Int) and right.value > 0
        exact = _is_input(one) and _is_input(other)
        least = [self._least(arg, block) for arg in (left, right)]
        if scaled or exact or min(least) >= 0:
            return (*one, *other, "*")
        if min(least) < -_FEW:
            return None
        both = least[0] * least[1] if max(least) < 0 else 0  # the product of the negative ones
        return (*one, 0, "max", *other, 0, "max", "*", both, "max")

    def _least(self, value: Value, block: str) -> int:
        """What a value is at least; a product that does not overflow has the sign of its factors,
        however large their ranges are.
        """
        least = self._ranges.at(value, block)[0]
        op = definition_of(self._function, value)
        if least >= 0 or not isinstance(op, Instr):
            return least
        if op.op == "udiv" and self._least(op.operands[0], block) >= 0:
            return 0
        if op.op == "select" and self._is_unless_negative(op):
            return min(self._least(op.operands[1], block), 0)
        if op.op != "mul" or "nsw" not in op.flags:
            return least
        return 0 if all(self._least(arg, block) >= 0 for arg in op.operands) else least

    def _is_unless_negative(self, choice: Instr) -> bool:
        """Whether the second one of a choice is taken only where it is not negative."""
        test = definition_of(self._function, choice.operands[0])
        if not isinstance(test, Instr) or test.op != "icmp" or test.pred != "slt":
            return False
        second = choice.operands[2]
        wide = definition_of(self._function, second)
        if isinstance(wide, Instr) and wide.op == "sext" and wide.operands == test.operands[:1]:
            second = test.operands[0]
        return test.operands == (second, Int(0))

    def _all(
        self,
        operator: str,
        operands: list[Value] | tuple[Value, ...],
        block: str,
        depth: int,
        *,
        signed: bool = False,
    ) -> Formula | None:
        formula: Formula = ()
        for operand in operands:
            bound = self._bound(operand, block, signed, depth - 1)
            if bound is None:
                return None
            formula = (*formula, *bound, operator) if formula else bound
        return formula


def _is_input(formula: Formula) -> bool:
    """Whether the formula is an input itself: exact, not only a bound."""
    return len(formula) == 1 and isinstance(formula[0], str)

"""Values of a loop as affine functions of its iteration index, modulo 2**32."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.edit import incoming
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Instr, Phi, Ref, Value


@dataclass(frozen=True, slots=True)
class Affine:
    """stride * (iteration index) + sum of coefficient * invariant value + constant."""

    stride: int
    constant: int
    terms: tuple[tuple[Value, int], ...] = ()

    def plus(self, other: Affine, sign: int = 1) -> Affine:
        """self + sign * other."""
        terms = dict(self.terms)
        for value, factor in other.terms:
            terms[value] = signed(terms.get(value, 0) + sign * factor)
        return Affine(
            signed(self.stride + sign * other.stride),
            signed(self.constant + sign * other.constant),
            tuple((value, factor) for value, factor in terms.items() if factor),
        )

    def times(self, factor: int) -> Affine:
        """self * factor."""
        return Affine(
            signed(self.stride * factor),
            signed(self.constant * factor),
            tuple((value, signed(f * factor)) for value, f in self.terms if signed(f * factor)),
        )

    @property
    def is_constant(self) -> bool:
        """Neither the iteration nor an invariant value appears."""
        return self.stride == 0 and not self.terms


@dataclass
class AffineAnalysis:
    """Answers `of(value)` for one loop; None where the value is not affine."""

    function: Function
    loop: Loop
    _instrs: dict[int, Instr] = field(init=False)
    _phis: dict[int, Phi] = field(init=False)
    _memo: dict[Value, Affine | None] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Indexes the loop's definitions."""
        inside = [block for block in self.function.blocks if block.name in self.loop.blocks]
        self._instrs = {instr.id: instr for block in inside for instr in block.instrs}
        header = next(block for block in inside if block.name == self.loop.header)
        self._phis = {phi.id: phi for phi in header.phis}
        self._merges = {p.id for b in inside if b.name != self.loop.header for p in b.phis}

    def of(self, value: Value) -> Affine | None:
        """The affine form of `value`, or None."""
        if value not in self._memo:
            self._memo[value] = None  # a cycle through phis is not affine unless `_phi` says so
            self._memo[value] = self._compute(value)
        return self._memo[value]

    def is_invariant(self, value: Value) -> bool:
        """Whether `value` is defined outside the loop."""
        if not isinstance(value, Ref):
            return True
        return not (value.id in self._instrs or value.id in self._phis or value.id in self._merges)

    def step(self, phi: Phi) -> int | None:
        """What each iteration adds to a header phi, if it is the same constant every time."""
        carried = incoming(phi, self.loop.latches[0])
        instr = self._instrs.get(carried.id) if isinstance(carried, Ref) else None
        if instr is None or instr.op not in (Opcode.ADD, Opcode.SUB):
            return None
        left, right = instr.operands
        if left == Ref(phi.id) and isinstance(right, Const):
            return signed(right.word if instr.op is Opcode.ADD else -right.word)
        if right == Ref(phi.id) and isinstance(left, Const) and instr.op is Opcode.ADD:
            return signed(left.word)
        return None

    def initial(self, phi: Phi) -> Value:
        """The value of a header phi in the first iteration."""
        return next(v for name, v in phi.incoming if name not in self.loop.blocks)

    def never_wraps(self, value: Value, *, by_one: bool) -> bool:
        """Whether `value` stays a signed word for as long as a comparison with a fixed limit holds.

        A counter that the limit is compared with and that moves by one meets the limit before it
        can wrap; others need every addition on the way to be `exact`.
        """
        if self.is_invariant(value):
            return True
        assert isinstance(value, Ref)
        phi = self._phis.get(value.id)
        if phi is not None:
            carried = incoming(phi, self.loop.latches[0])
            update = self._instrs.get(carried.id) if isinstance(carried, Ref) else None
            return by_one or (update is not None and update.exact)
        instr = self._instrs.get(value.id)
        if instr is None or not instr.exact:
            return False
        return all(self.never_wraps(operand, by_one=False) for operand in instr.operands)

    def _compute(self, value: Value) -> Affine | None:
        if isinstance(value, Const):
            return Affine(0, signed(value.word))
        if self.is_invariant(value):
            return Affine(0, 0, ((value, 1),))
        assert isinstance(value, Ref)
        if value.id in self._phis:
            return self._phi(self._phis[value.id])
        instr = self._instrs.get(value.id)
        return None if instr is None else self._instr(instr)

    def _phi(self, phi: Phi) -> Affine | None:
        step = self.step(phi)
        start = self.of(self.initial(phi))
        if step is None or start is None:
            return None
        return Affine(step, 0).plus(start)

    def _instr(self, instr: Instr) -> Affine | None:
        rule = _RULES.get(instr.opcode)
        if rule is None:
            return None
        operands = [self.of(operand) for operand in instr.operands]
        known = [operand for operand in operands if operand is not None]
        return rule(known) if len(known) == len(operands) else None


def _product(operands: list[Affine]) -> Affine | None:
    left, right = operands
    if right.is_constant:
        return left.times(right.constant)
    return right.times(left.constant) if left.is_constant else None


def _shift(operands: list[Affine]) -> Affine | None:
    left, right = operands
    if right.is_constant and 0 <= right.constant < 32:  # noqa: PLR2004 - a word's bits
        return left.times(1 << right.constant)
    return None


_RULES: dict[Opcode, Callable[[list[Affine]], Affine | None]] = {
    Opcode.ADD: lambda o: o[0].plus(o[1]),
    Opcode.SUB: lambda o: o[0].plus(o[1], -1),
    Opcode.MUL: _product,
    Opcode.SHL: _shift,
    Opcode.MOV: lambda o: o[0],
}

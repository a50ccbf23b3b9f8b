"""Runs an `ssa.ir.Function` on numpy arrays: the oracle of the frontend's tests, independent of the
rest of vividc.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.machine.params import DType
from vividc.machine.semantics import SEMANTICS
from vividc.ssa.ir import Block, Const, Function, Input, Instr, Value

_MASK = 0xFFFFFFFF


def run(function: Function, *args: object, max_blocks: int = 1_000_000) -> object:
    """Runs `function`; arrays are updated in place. Returns the scalar result, or None."""
    machine = _Machine(function, args)
    name = function.blocks[0].name
    blocks = {block.name: block for block in function.blocks}
    previous = ""
    for _ in range(max_blocks):
        block = blocks[name]
        machine.execute(block, previous)
        previous, branch = name, block.branch
        if branch.target is None:
            return machine.result(function.returns, branch.value, branch.high)
        taken = branch.cond is None or machine.word(branch.cond)
        name = branch.target if taken else branch.otherwise
    raise AssertionError("the function does not end")


class _Machine:
    def __init__(self, function: Function, args: tuple[object, ...]) -> None:
        self.inputs: dict[str, int] = {}
        self.memory: dict[str, np.ndarray] = {}
        self.shapes: dict[str, tuple[int, ...]] = {}
        self.values: dict[int, int] = {}
        for param, value in zip(function.params, args, strict=True):
            if param.ndim:
                self.memory[param.name] = value.reshape(-1).view(np.uint8)
                self.inputs[f"&{param.name}"] = 0
                self.shapes[param.name] = value.shape
                for axis, size in enumerate(value.shape):
                    self.inputs[f"{param.name}.shape{axis}"] = size
            elif param.dtype is DType.F32:
                self.inputs[param.name] = int(np.float32(value).view(np.uint32))
            else:
                self.inputs[param.name] = int(value) & (1 << 8 * param.dtype.size_bytes) - 1
                if param.words == 2:
                    self.inputs[f"{param.name}.high"] = int(value) >> 32 & _MASK

        for local in function.locals:
            self.memory[local.name] = np.zeros(4 * local.words, np.uint8)
            self.inputs[f"&{local.name}"] = 0
            if local.contents is not None:
                self.memory[local.name].view(np.uint32)[:] = local.contents

    def word(self, value: Value) -> int:
        if isinstance(value, Const):
            return value.word
        return self.inputs[value.key] if isinstance(value, Input) else self.values[value.id]

    def execute(self, block: Block, previous: str) -> None:
        new = {phi.id: self.word(dict(phi.incoming)[previous]) for phi in block.phis}
        self.values.update(new)
        for instr in block.instrs:
            self.values[instr.id] = self._step(instr) & _MASK

    def _step(self, instr: Instr) -> int:
        words = [self.word(value) for value in instr.operands]
        if instr.op not in MEMORY:
            return int(_SEMANTICS.get(instr.op, SEMANTICS.get(instr.op))(*words))
        if len(words) > OPCODES[instr.op].arity + 1 and not words.pop():
            return 0
        address = (words[0] + (words[1] << instr.shift) + instr.offset) & _MASK
        cells = self.memory[instr.array]
        assert address % instr.width == 0
        assert address + instr.width <= cells.size, f"{instr} leaves its array"
        self._check_subscript(instr, address)
        place = cells[address : address + instr.width]
        if instr.op is Opcode.LOAD:
            return int.from_bytes(place.tobytes(), "little", signed=instr.signed)
        place[...] = list(words[2].to_bytes(4, "little")[: instr.width])
        return 0

    def _check_subscript(self, instr: Instr, address: int) -> None:
        """What an access says of its element must be so."""
        if instr.subscript:
            place = np.unravel_index(address // instr.width, self.shapes[instr.array])
            said = zip(instr.subscript, place, strict=True)
            assert all(constant in (None, there) for constant, there in said), instr

    def result(self, returns: DType | None, value: Value | None, high: Value | None) -> object:
        if returns is None or value is None:
            return None
        word = self.word(value)
        if high is not None:
            whole = word | self.word(high) << 32
            return whole - 2**64 if returns is DType.I64 and whole >> 63 else whole
        if returns is DType.F32:
            return _float(word)
        if returns is DType.BOOL:
            return bool(word)
        bits = 8 * returns.size_bytes
        if returns.is_signed:
            return _signed(word << 32 - bits) >> 32 - bits
        return word & (1 << bits) - 1


def _signed(word: int) -> int:
    word &= _MASK
    return word - 2**32 if word & 0x80000000 else word


def _float(word: int) -> np.float32:
    return np.uint32(word).view(np.float32)


def _bits(value: np.float32) -> int:
    return int(np.float32(value).view(np.uint32))


def _float_op(function: Callable[..., object]) -> Callable[..., int]:
    def run_op(*words: int) -> int:
        with np.errstate(all="ignore"):
            return _bits(np.float32(function(*(_float(word) for word in words))))

    return run_op


def _of_double(function: Callable[..., object]) -> Callable[..., int]:
    return _float_op(lambda *values: function(*(np.float64(value) for value in values)))


def _float_test(function: Callable[..., object]) -> Callable[..., int]:
    return lambda a, b: int(bool(function(_float(a), _float(b))))


def _unordered(a: np.float32, b: np.float32) -> bool:
    return bool(np.isnan(a) or np.isnan(b))


def _to_int(word: int) -> int:
    value = float(_float(word))
    if value != value:  # noqa: PLR0124
        return 0
    return int(min(max(value, -(2.0**31)), 2.0**31 - 1))


def _truncated(a: int, b: int) -> int:
    return math.trunc(Fraction(a, b)) if b else 0


_O = Opcode
_SEMANTICS: dict[Opcode, Callable[..., int]] = {
    _O.MOV: lambda a: a,
    _O.ADD: lambda a, b: a + b,
    _O.SUB: lambda a, b: a - b,
    _O.MUL: lambda a, b: a * b,
    _O.MULHS: lambda a, b: _signed(a) * _signed(b) >> 32,
    _O.MULHU: lambda a, b: a * b >> 32,
    _O.SDIV: lambda a, b: _truncated(_signed(a), _signed(b)),
    _O.SREM: lambda a, b: _signed(a) - _signed(b) * _truncated(_signed(a), _signed(b)),
    _O.UDIV: _truncated,
    _O.UREM: lambda a, b: a - b * _truncated(a, b),
    _O.CTPOP: lambda a: bin(a).count("1"),
    _O.CTLZ: lambda a: f"{a:032b}1".index("1"),
    _O.CTTZ: lambda a: f"{a:032b}"[::-1].find("1") % 33,
    _O.BSWAP: lambda a: int.from_bytes(a.to_bytes(4, "big"), "little"),
    _O.BITREVERSE: lambda a: int(f"{a:032b}"[::-1], 2),
    _O.AND: lambda a, b: a & b,
    _O.OR: lambda a, b: a | b,
    _O.XOR: lambda a, b: a ^ b,
    _O.SHL: lambda a, b: a << (b & 31),
    _O.LSHR: lambda a, b: a >> (b & 31),
    _O.ASHR: lambda a, b: _signed(a) >> (b & 31),
    _O.SMIN: lambda a, b: min(_signed(a), _signed(b)),
    _O.SMAX: lambda a, b: max(_signed(a), _signed(b)),
    _O.ICMP_EQ: lambda a, b: a == b,
    _O.ICMP_NE: lambda a, b: a != b,
    _O.ICMP_SLT: lambda a, b: _signed(a) < _signed(b),
    _O.ICMP_SLE: lambda a, b: _signed(a) <= _signed(b),
    _O.ICMP_ULT: lambda a, b: a < b,
    _O.ICMP_ULE: lambda a, b: a <= b,
    _O.SELECT: lambda p, a, b: a if p else b,
    _O.FADD: _float_op(lambda a, b: a + b),
    _O.FSUB: _float_op(lambda a, b: a - b),
    _O.FMUL: _float_op(lambda a, b: a * b),
    _O.FMA: _float_op(lambda a, b, c: float(a) * float(b) + float(c)),
    _O.FNEG: lambda a: a ^ 0x80000000,
    _O.FABS: lambda a: a & 0x7FFFFFFF,
    _O.FMIN: _float_op(np.fmin),
    _O.FMAX: _float_op(np.fmax),
    _O.FCMP_OEQ: _float_test(lambda a, b: a == b),
    _O.FCMP_UNE: _float_test(lambda a, b: a != b),
    _O.FCMP_OLT: _float_test(lambda a, b: a < b),
    _O.FCMP_OLE: _float_test(lambda a, b: a <= b),
    _O.FCMP_ULT: _float_test(lambda a, b: not a >= b),
    _O.FCMP_ULE: _float_test(lambda a, b: not a > b),
    _O.FCMP_ONE: _float_test(lambda a, b: a < b or a > b),
    _O.FCMP_UEQ: _float_test(lambda a, b: not (a < b or a > b)),
    _O.FCMP_ORD: _float_test(lambda a, b: not _unordered(a, b)),
    _O.FCMP_UNO: _float_test(_unordered),
    _O.SITOFP: lambda a: _bits(np.float32(_signed(a))),
    _O.UITOFP: lambda a: _bits(np.float32(a)),
    _O.FPTOSI: _to_int,
    _O.EXP: _float_op(lambda a: np.exp(np.float64(a))),
    _O.EXP2: _float_op(lambda a: np.exp2(np.float64(a))),
    _O.FDIV: _float_op(np.divide),
    _O.SQRT: _float_op(np.sqrt),
    _O.FLOOR: _float_op(np.floor),
    _O.CEIL: _float_op(np.ceil),
    _O.TRUNC: _float_op(np.trunc),
    _O.RINT: _float_op(np.rint),
    _O.LOG: _of_double(np.log),
    _O.LOG2: _of_double(np.log2),
    _O.LOG10: _of_double(np.log10),
    _O.LOG1P: _of_double(np.log1p),
    _O.EXPM1: _of_double(np.expm1),
    _O.SIN: _of_double(np.sin),
    _O.COS: _of_double(np.cos),
    _O.TAN: _of_double(np.tan),
    _O.SINH: _of_double(np.sinh),
    _O.COSH: _of_double(np.cosh),
    _O.TANH: _of_double(np.tanh),
    _O.ASIN: _of_double(np.arcsin),
    _O.ACOS: _of_double(np.arccos),
    _O.ATAN: _of_double(np.arctan),
    _O.ATAN2: _of_double(np.arctan2),
    _O.HYPOT: _of_double(np.hypot),
    _O.POW: _of_double(np.power),
    _O.FREM: _of_double(np.fmod),
}

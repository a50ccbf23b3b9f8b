"""Runs a function in SSA form on numpy arrays, operation by operation.

A witness for everything behind it: a pass is right if what it leaves gives the same results. Words
are computed by `machine.semantics`, LLVM's values by `ssa.llvm_semantics`, whose doubles are
doubles: narrowing runs them in float32.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Final, Generic, TypeVar

import numpy as np

from vividc.errors import SSAError
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.machine.params import HIGH_SUFFIX, WIDE_DTYPES, DType, Param, given
from vividc.machine.semantics import evaluate
from vividc.machine.words import WORD_MASK, float_of, word_of
from vividc.ssa.ir import (
    Block,
    Const,
    Float,
    Function,
    Input,
    Instr,
    Int,
    Key,
    Ref,
    Value,
    pitch_of,
)
from vividc.ssa.llvm_semantics import Number, evaluate_llvm, wrapped

_MOST_BLOCKS: Final = 1_000_000
_FLOATS: Final = frozenset({"float", "double"})
_V = TypeVar("_V")


def interpret(function: Function, *args: object, max_blocks: int = _MOST_BLOCKS) -> object:
    """Run a function whose accesses name their arrays.

    Parameters
    ----------
    args
        One for each of `function.params` that a caller gives: numpy arrays of its dtype, which are
        updated in place, or numbers.
    max_blocks
        Blocks to run at most.

    Returns
    -------
    The number returned, as of `function.returns`, or the arrays and tuples of `function.results`;
    None if there is none.

    Raises
    ------
    SSAError
        An access leaves its array or is no element that it says to be, the function does not end,
        or it has an operation that only LLVM knows.
    """
    machine = _LLVM(function, args) if function.is_llvm else _Words(function, args)
    return machine.run(max_blocks)


class _Machine(ABC, Generic[_V]):
    """Memory, and the values computed so far."""

    def __init__(self, function: Function, args: tuple[object, ...]) -> None:
        self.function = function
        self.values: dict[Key, _V] = {}
        self._memory: dict[str, np.ndarray] = {}
        self._arrays: dict[str, np.ndarray] = {}
        self._shapes: dict[str, tuple[int, ...]] = {}
        words: dict[str, int] = {}
        for param, value in zip(given(function.params), args, strict=True):
            if isinstance(value, np.ndarray):
                words |= {f"{param.name}.shape{n}": size for n, size in enumerate(value.shape)}
                self._arrays[param.name] = value
                self._memory[param.name] = value.reshape(-1).view(np.uint8)
                self._shapes[param.name] = value.shape
                for axis, size in enumerate(value.shape):
                    self.values[f"{param.name}.shape{axis}"] = self.number(size)
                    self.values[pitch_of(param.name, axis).key] = self.number(size)
                self.values[f"&{param.name}"] = self.number(0)
            else:
                words |= param.words_of(int(value)) if isinstance(value, int | np.integer) else {}
                self.bind(param, value)
        for param in (param for param in function.params if param.made):
            self._arrays[param.name] = np.zeros(param.words_at(words), param.dtype.value)
            self._memory[param.name] = self._arrays[param.name].view(np.uint8)
            self.values[f"&{param.name}"] = self.number(0)
        self._inputs = words
        for local in (local.at_launch(words) for local in function.locals):
            self._memory[local.name] = np.zeros(4 * local.words, np.uint8)
            self.values[f"&{local.name}"] = self.number(0)
            if local.contents is not None:
                self._memory[local.name].view(np.uint32)[:] = local.contents

    @abstractmethod
    def number(self, value: int) -> _V:
        """An integer that the launch supplies."""

    @abstractmethod
    def bind(self, param: Param, value: object) -> None:
        """Supply a scalar."""

    @abstractmethod
    def constant(self, value: Value) -> _V:
        """What a constant is."""

    @abstractmethod
    def step(self, instr: Instr, operands: list[_V]) -> _V:
        """The result of an instruction, which may access memory."""

    @abstractmethod
    def result(self, value: Value, high: Value | None, returns: DType) -> object:
        """What is returned."""

    def run(self, max_blocks: int) -> object:
        """Run from the entry to a return."""
        name, previous = self.function.blocks[0].name, ""
        for _ in range(max_blocks):
            block = self.function.by_name[name]
            self._execute(block, previous)
            previous, branch = name, block.branch
            if branch.target is None:
                results = self.function.results
                value = results and results.value(self._arrays, self._inputs)
                if self.function.returns is None:
                    return value
                if branch.value is None or self.function.returns is None:
                    return None
                return self.result(branch.value, branch.high, self.function.returns)
            taken = branch.cond is None or self.value(branch.cond)
            name = branch.target if taken else str(branch.otherwise)
        raise SSAError(f"it does not end within {max_blocks} blocks")

    def value(self, value: Value) -> _V:
        """What an operand is now."""
        if isinstance(value, Ref | Input):
            return self.values[value.key]
        return self.constant(value)

    def _execute(self, block: Block, previous: str) -> None:
        entered: dict[Key, _V] = {
            phi.id: self.value(dict(phi.incoming)[previous]) for phi in block.phis
        }
        self.values.update(entered)
        for instr in block.instrs:
            self.values[instr.id] = self.step(instr, [self.value(v) for v in instr.operands])

    def place(self, instr: Instr, index: int, base: int = 0) -> np.ndarray:
        """The bytes of an access; every array begins at address 0."""
        cells = self._memory[instr.array]
        address = (base + (index << instr.shift) + instr.offset) & WORD_MASK
        if address % instr.width or address + instr.width > cells.size:
            raise SSAError(f"{instr.mnemonic} {instr.id} leaves {instr.array}: byte {address}")
        if instr.subscript:
            element = self._arrays[instr.array].itemsize
            there = np.unravel_index(address // element, self._shapes[instr.array])
            said = zip(instr.subscript, there, strict=True)
            if not all(constant in (None, axis) for constant, axis in said):
                raise SSAError(f"{instr.mnemonic} {instr.id} is at {there}: {instr.subscript}")
        return cells[address : address + instr.width]


class _Words(_Machine[int]):
    """Words, as the array has them."""

    def number(self, value: int) -> int:
        return value

    def bind(self, param: Param, value: object) -> None:
        if param.dtype.is_float:
            parts = _parts(param, value)
            self.values |= {name: word_of(float(part)) for name, part in parts.items()}
            return
        whole = int(value)  # type: ignore[call-overload]
        self.values[param.name] = whole & (1 << 8 * min(param.dtype.size_bytes, 4)) - 1
        if param.words > 1:
            self.values[f"{param.name}.high"] = whole >> 32 & WORD_MASK

    def constant(self, value: Value) -> int:
        if not isinstance(value, Const):
            raise SSAError(f"{value} is not a word")
        return value.word

    def step(self, instr: Instr, operands: list[int]) -> int:
        if instr.op not in MEMORY:
            return evaluate(instr.opcode, operands)
        if len(operands) > OPCODES[instr.opcode].arity + 1 and not operands.pop():
            return 0
        place = self.place(instr, operands[1], operands[0])
        if instr.op is Opcode.LOAD:
            return int.from_bytes(place.tobytes(), "little", signed=instr.signed) & WORD_MASK
        place[...] = list(operands[2].to_bytes(4, "little")[: instr.width])
        return 0

    def result(self, value: Value, high: Value | None, returns: DType) -> object:
        word = self.value(value)
        if returns is DType.F32:
            return np.float32(float_of(word))
        if high is not None:
            return _integer(word | self.value(high) << 32, 64, returns)
        return _integer(word, 32 if returns in WIDE_DTYPES else 8 * returns.size_bytes, returns)


class _LLVM(_Machine[Number]):
    """Integers of any width (with sign) and doubles."""

    def number(self, value: int) -> Number:
        return value

    def bind(self, param: Param, value: object) -> None:
        kind = dict(self.function.inputs)[param.name]
        if kind in _FLOATS:
            self.values.update(_parts(param, value))
        else:
            self.values[param.name] = wrapped(int(value), kind)  # type: ignore[call-overload]

    def constant(self, value: Value) -> Number:
        if not isinstance(value, Int | Float):
            raise SSAError(f"{value} is not a number")
        return value.value

    def step(self, instr: Instr, operands: list[Number]) -> Number:
        if instr.op not in ("load", "store"):
            return evaluate_llvm(instr, operands)
        place = self.place(instr, int(operands[-1]))
        if instr.op == "load":
            if instr.type == "float":
                return np.float32(place.view(np.float32)[0])
            return wrapped(
                int.from_bytes(place.tobytes(), "little", signed=instr.signed), instr.type
            )
        if instr.type == "float":
            place[...] = np.array([operands[0]], np.float32).view(np.uint8)
        else:
            low = int(operands[0]) & (1 << 8 * instr.width) - 1
            place[...] = list(low.to_bytes(instr.width, "little"))
        return 0

    def result(self, value: Value, high: Value | None, returns: DType) -> object:
        number = self.value(value)
        if returns is DType.F32:
            return np.float32(number)
        return _integer(int(number), int(self.function.result[1:]), returns)


def _parts(param: Param, value: object) -> dict[str, np.float32]:
    """A float, or both parts of a complex number, by input."""
    whole = np.complex64(value)  # type: ignore[call-overload]
    parts = {param.name: whole.real}
    return parts if param.words == 1 else parts | {param.name + HIGH_SUFFIX: whole.imag}


def _integer(value: int, bits: int, returns: DType) -> object:
    """The integer that `bits` stand for as the function's type."""
    if returns is DType.BOOL:
        return bool(value & 1)
    low = value & (1 << bits) - 1
    return low - (1 << bits) if returns.is_signed and low >> (bits - 1) else low

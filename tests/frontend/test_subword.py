"""Integers of less than a word: exact, and at no operation more than they need."""

from __future__ import annotations

from collections import Counter
from copy import deepcopy

import numpy as np
import pytest

from tests.frontend import narrow_kernels
from vividc.compiler.driver import lower
from vividc.frontend import KernelFunction
from vividc.machine.opcodes import MEMORY, Opcode
from vividc.ssa.interpret import interpret as run


def all_bytes(dtype: str) -> np.ndarray:
    return np.arange(256, dtype=np.uint8).view(dtype)


def halves(dtype: str) -> np.ndarray:
    edges = np.array([0, 1, 127, 128, 255, 256, 32767, 32768, 65408, 65535], np.uint16)
    return np.concatenate([edges, np.arange(0, 65536, 733).astype(np.uint16)]).view(dtype)


def like(array: np.ndarray, dtype: str) -> np.ndarray:
    return np.zeros(array.shape, dtype)


ARRAYS = {
    "next_byte": (all_bytes("uint8"), like(all_bytes("uint8"), "uint8")),
    "double_byte": (all_bytes("int8"), like(all_bytes("int8"), "int16")),
    "above": (halves("int16"), like(halves("int16"), "bool"), np.int16(-7)),
    "clip": (all_bytes("int8"), like(all_bytes("int8"), "int8")),
    "high_byte": (halves("uint16"), like(halves("uint16"), "uint8")),
    "cut_to_byte": (halves("int16"), like(halves("int16"), "int8")),
    "smallest": (all_bytes("int8"),),
    "from_float": (np.linspace(-128, 127, 99, dtype=np.float32), np.zeros(99, np.int8)),
    "rotate_bits": (all_bytes("uint8"), like(all_bytes("uint8"), "uint8")),
    "any_in_row": (np.eye(5, 7, -2, bool), np.array([0, 1, 0, 1, 0], bool)),
    "planes": (all_bytes("int8")[7:67].reshape(3, 4, 5), np.full((4, 3), 65530, np.uint16)),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_against_numba(name: str) -> None:
    kernel: KernelFunction = getattr(narrow_kernels, name)
    expected, actual = deepcopy(ARRAYS[name]), deepcopy(ARRAYS[name])
    assert kernel(*expected) == run(kernel.lower(), *actual)
    for one, other in zip(expected, actual, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("a", [0, 1, 127, 128, 255])
@pytest.mark.parametrize("d", [-32768, -1, 0, 32767])
def test_scalars_against_numba(a: int, d: int) -> None:
    b = a - 128
    for name, args in (
        ("mixed_scalars", (np.uint8(a), np.int8(b), np.uint16(d + 32768), np.int16(d), True)),
        ("negated", (np.int8(b),)),
        ("as_float", (np.int16(d),)),
    ):
        kernel: KernelFunction = getattr(narrow_kernels, name)
        assert run(kernel.lower(), *args) == kernel(*args)


@pytest.mark.parametrize(
    ("name", "operations"),
    [
        ("next_byte", {Opcode.ADD: 1}),
        ("double_byte", {Opcode.SHL: 1}),
        ("clip", {Opcode.SMIN: 1, Opcode.SMAX: 1}),
        ("high_byte", {Opcode.LSHR: 1}),
        ("cut_to_byte", {}),
        ("smallest", {Opcode.SMIN: 1}),
        ("any_in_row", {Opcode.SELECT: 1, Opcode.XOR: 1}),
    ],
)
def test_extending_and_cutting_is_done_by_loads_and_stores(
    name: str, operations: dict[Opcode, int]
) -> None:
    kernel: KernelFunction = getattr(narrow_kernels, name)
    (loop,) = (region for region in lower(kernel).regions if region.kind == "loop")
    found = Counter(node.op for node in loop.dfg.operations if node.op not in MEMORY)
    assert found == Counter(operations)


def test_the_sign_follows_the_uses() -> None:
    for name, signed in (("next_byte", False), ("double_byte", True), ("above", True)):
        kernel: KernelFunction = getattr(narrow_kernels, name)
        instrs = [i for block in kernel.lower().blocks for i in block.instrs]
        loads = [i for i in instrs if i.op is Opcode.LOAD]
        assert [i.signed for i in loads] == [signed]

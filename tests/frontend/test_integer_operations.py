"""Every integer operator on pairs of words at their edges, against numba, bit for bit.

The kernels of one pair of types are one kernel, which writes a row of results for each expression.
"""

from __future__ import annotations

import importlib.util
import itertools
from pathlib import Path

import numpy as np
import pytest

from vividc.frontend import KernelFunction
from vividc.machine.opcodes import Opcode
from vividc.ssa.interpret import interpret as run

EDGES = (0, 1, 2, 7, 10, 255, 65536, 1000003, 2**31 - 1)
VALUES = sorted({sign * edge for edge in EDGES for sign in (1, -1)} | {-(2**31)})
# numba's own np.remainder divides INT_MIN by -1 on the host, which stops the process.
PAIRS = [pair for pair in itertools.product(VALUES, VALUES) if pair != (-(2**31), -1)]
TYPES = ("int32", "uint32")

DIVISIONS = (
    *("a // b", "a % b", "a // b + a % b * 3", "divmod(a, b)[0] ^ divmod(a, b)[1]"),
    *("a // 7", "a % 7", "a // -7", "a % -7", "a // 10", "a % 10", "a // 3 + a % 3"),
    *("a // 16", "a % 16", "a // -16", "a % -16", "a // 1", "a % 1", "a // 2147483647"),
    *("a % 65537", "a // (-2147483648)", "a // 4294967291", "a % 4294967295"),
    *("1000 // b", "1000 % b", "-1000 // b", "-1000 % b", "a // 0", "a % 0"),
    *("(a & 1023) // (b & 63)", "(a & 1023) % ((b & 63) + 1)", "(a & 1023) % 10"),
    *("((a & 1023) - 512) // 10", "((a & 1023) - 512) % 10"),
    *("(5 if np.int32(a) // np.int32(b) < 3 else 4)", "(np.int32(a) // np.int32(b)) == 2147483648"),
)
INVARIANT = (
    *("a // n", "a % n", "a // m", "a % m"),
    *("divmod(a, n)[0] - divmod(a, n)[1]", "divmod(a, m)[0] - divmod(a, m)[1]"),
)
BITS = (
    *("a << (b & 31)", "a >> (b & 31)", "(a & 255) << (b & 63)", "a >> (b & 63)", "a & b | a ^ ~b"),
    *("np.left_shift(a, b & 31)", "np.right_shift(a, b & 31)", "np.uint32(a) >> (b & 63)"),
    "(np.uint32(a) << np.uint32(b & 31)) | (np.uint32(a) >> np.uint32(-b & 31))",
    "(np.uint32(a) >> np.uint32(b & 31)) | (np.uint32(a) << np.uint32(-b & 31))",
    *("math.gcd(np.int32(a), np.int32(b))", "np.gcd(np.int32(a), np.int32(b))"),
    *("a ** (b & 15)", "2 ** (b & 31)", "a ** 3", "np.int32(a) ** np.int8(b)", "pow(a, 2)"),
    *("abs(np.int32(a))", "min(a, b)", "max(a, b)", "np.sign(np.int32(a))", "-a", "~a", "+a"),
)
SMALL = (
    *("np.int8(np.int8(a) * np.int8(b)) >> 1", "np.int8(np.int8(a) + np.int8(b))"),
    *("np.int16(a) // np.uint8(b)", "np.int16(a) % np.uint8(b)", "min(np.int16(a), np.uint8(b))"),
    *("max(np.int8(a), np.int8(b))", "abs(np.int8(a))", "np.int8(a) < np.int8(b)", "-np.int16(a)"),
    *("np.int8(np.int8(a) << (b & 7))", "np.uint8(np.uint8(a) - np.uint8(b))", "~np.int8(a)"),
    *("np.float32(np.int8(a))", "np.int8(np.float32(np.int8(a)))", "np.uint16(np.float32(a & 99))"),
    *("np.int8(a) // np.int8(b)", "np.int8(a) % np.int8(b)", "np.int16(np.int16(a) ** 2) // 3"),
    *("np.uint8(np.uint8(a) * np.uint8(b)) // np.uint8(7)", "np.uint8(a) >> (b & 7)"),
    *("(a > 0) + (b > 0) * 5 + (not a)", "((a > 3) & (b > 3)) + ((a > 3) ^ (b > 3))", "-(a > b)"),
    *("True + (a > b)", "(a > b) // True", "(a > b) * b", "(a > b) | (a < 3)", "np.uint16(a) ^ b"),
)
FAMILIES = {"divisions": DIVISIONS, "invariant": INVARIANT, "bits": BITS, "small": SMALL}
UFUNCS = ("np.floor_divide(a, b)", "np.remainder(a, b)", "np.fmod(a, b)")


def compiled(expressions: tuple[str, ...], types: tuple[str, str], folder: Path) -> KernelFunction:
    rows = "".join(
        f"        out[{row}, i] = np.int32({text})\n" for row, text in enumerate(expressions)
    )
    source = (
        "import math\nimport numpy as np\nfrom vividc.frontend import kernel\n"
        f'@kernel("void({types[0]}[::1], {types[1]}[::1], int32[:, ::1], int32, uint32)")\n'
        "def program(x, y, out, n, m):\n    for i in range(len(x)):\n"
        f"        a = x[i]\n        b = y[i]\n{rows}"
    )
    name = f"operations_{types[0]}_{types[1]}"
    file = folder / f"{name}.py"
    file.write_text(source, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    kernel: KernelFunction = module.program
    return kernel


def assert_agrees(
    expressions: tuple[str, ...],
    types: tuple[str, str],
    folder: Path,
    scalars: tuple[tuple[int, int], ...] = ((-7, 7),),
) -> None:
    kernel = compiled(expressions, types, folder)
    function = kernel.lower()
    x, y = (
        np.array(column, np.int64).astype(type_)
        for column, type_ in zip(zip(*PAIRS, strict=True), types, strict=True)
    )
    for n, m in scalars:
        expected, actual = (np.zeros((len(expressions), len(x)), np.int32) for _ in range(2))
        kernel(x, y, expected, n, m)
        run(function, x, y, actual, n, m)
        for row, text in enumerate(expressions):
            wrong = np.nonzero(expected[row] != actual[row])[0]
            assert not len(wrong), (text, types, x[wrong[:3]], y[wrong[:3]])


SIGNED, MIXED = ("int32", "int32"), ("uint32", "int32")


def test_divisions_of_signed_integers(tmp_path: Path) -> None:
    assert_agrees(DIVISIONS[:12], SIGNED, tmp_path)


def test_divisions_of_unsigned_by_signed_integers(tmp_path: Path) -> None:
    assert_agrees(DIVISIONS[:4], MIXED, tmp_path)


def test_divisions_by_what_a_loop_does_not_change(tmp_path: Path) -> None:
    scalars = ((-7, 7), (10, 2**32 - 5), (0, 0))
    assert_agrees((*INVARIANT, *DIVISIONS[-1:]), SIGNED, tmp_path, scalars)


def test_bit_operations(tmp_path: Path) -> None:
    assert_agrees(BITS[:10], MIXED, tmp_path)


def test_small_types(tmp_path: Path) -> None:
    assert_agrees(SMALL[:10], SIGNED, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("types", list(itertools.product(TYPES, TYPES)), ids=" ".join)
@pytest.mark.parametrize(
    "expressions",
    [DIVISIONS, INVARIANT, BITS, SMALL],
    ids=["divisions", "invariant", "bits", "small"],
)
def test_all(expressions: tuple[str, ...], types: tuple[str, str], tmp_path: Path) -> None:
    assert_agrees(expressions, types, tmp_path, ((-7, 7), (0, 0)))


@pytest.mark.slow
@pytest.mark.parametrize("type_", TYPES)
def test_ufuncs(type_: str, tmp_path: Path) -> None:
    assert_agrees(UFUNCS, (type_, type_), tmp_path)


def opcodes(expression: str, types: tuple[str, str], folder: Path) -> list[Opcode]:
    function = compiled((expression,), types, folder).lower()
    return [instr.op for block in function.blocks for instr in block.instrs]


def test_a_floor_division_by_a_power_of_two_is_a_shift(tmp_path: Path) -> None:
    assert Opcode.ASHR in opcodes("a // 8", ("int32", "int32"), tmp_path)
    assert Opcode.SELECT not in opcodes("a // 8 + a % 8", ("int32", "int32"), tmp_path)


def test_the_reciprocal_of_a_loops_constant_divisor_is_computed_before_it(tmp_path: Path) -> None:
    kernel = compiled(("a // m + a % m",), ("uint32", "uint32"), tmp_path)
    divisions = [
        block.name
        for block in kernel.lower().blocks
        for instr in block.instrs
        if instr.op is Opcode.UDIV
    ]
    [before] = divisions
    loops = {block.name for block in kernel.lower().blocks if block.phis}
    assert before not in loops


def test_a_division_of_two_variables_is_written_once_for_both_results(tmp_path: Path) -> None:
    found = opcodes("divmod(a, b)[0] + divmod(a, b)[1]", ("uint32", "uint32"), tmp_path)
    assert found.count(Opcode.UDIV) == found.count(Opcode.UREM) == 1

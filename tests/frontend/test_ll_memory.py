"""C functions on bytes, halves, tables, local arrays and integers of 64 bits, without debug
information: lowered and evaluated, against LLVM on the host.
"""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.errors import KernelError
from vividc.machine.params import DType
from vividc.ssa.interpret import interpret as run

FILE = Path(__file__).parent / "c" / "memory.ll"
_RNG = np.random.default_rng(1)
DATA = [_RNG.integers(0, 256, 20, dtype=np.uint8) for _ in range(2)]
_UNSIGNED = {"udiv64": ("arg0", "arg1"), "popc": ("arg0",)}


def text(string: bytes) -> np.ndarray:
    return np.frombuffer(string + b"\0", np.uint8)


CASES: dict[str, tuple[tuple[object, ...], ...]] = {
    "sum64": ((np.arange(5, dtype=np.int32), 5, -(2**62)), (np.full(9, -(2**31), np.int32), 9, 7)),
    "div64": ((1 - 2**63, 3), (2**63 - 1, -7), (5, 2**40), (-(2**50), 2**20 - 1), (1, 0)),
    "udiv64": ((2**64 - 1, 10), (2**64 - 1, 2**63 + 5), (7, 0)),
    "muladd": ((2**40 + 1, -3), (-(2**61), 1), (-5, 7)),
    "tab2": tuple((i, j) for i in range(4) for j in range(4)),
    "tab16": tuple((i,) for i in range(5)),
    "tab64": tuple((i,) for i in range(4)),
    "tabf": tuple((i,) for i in range(4)),
    "init8": ((3,), (15,)),
    "loc2": ((3,), (-5,)),
    "locs": ((3,), (100,), (-77,)),
    "rnd": ((2.5,), (-2.5,), (-0.5,), (0.49999997,), (-0.2,), (8388609.0,), (float("inf"),)),
    "ret8": ((200,), (-129,)),
    "ret16": ((-3, 60000), (127, 9)),
    "odd": ((3,), (8,), (255,)),
    "cp": ((*DATA, 13), (*DATA, 0), (*DATA, 16)),
    "mv": ((DATA[0], 13), (DATA[0], 0)),
    "popc": ((2**64 - 1,), (2**40 + 1,)),
    "cmps": tuple(
        (text(a), text(b)) for a, b in ((b"abc", b"abd"), (b"\xff", b"a"), (b"", b""), (b"b", b""))
    ),
    "base64": ((DATA[0], np.zeros(24, np.uint8), 18),),
    "mum": ((2**31 - 1, 2**31 - 1), (5, 6), (-1, -1)),
    "load4": ((DATA[0].view(np.int32), 2),),
    "rd": ((DATA[0], 16),),
    "pun": ((1.5,), (2.75,), (7.1,)),
}


@cache
def loaded(name: str) -> vividc.LLKernel:
    types = dict.fromkeys(_UNSIGNED.get(name, ()), "uint64")
    return vividc.load_ll(FILE, name, types=types)


@pytest.mark.parametrize("name", CASES)
def test_functions(name: str) -> None:
    kernel = loaded(name)
    function = kernel.lower()
    for arguments in CASES[name]:
        ours = [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
        host = [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
        np.testing.assert_equal(run(function, *ours), kernel(*host))
        for mine, theirs in zip(ours, host, strict=True):
            np.testing.assert_array_equal(mine, theirs)


def test_mathematics_is_close() -> None:
    kernel = loaded("maths")
    for x, y in ((0.7, 1.3), (-2.1, 0.4)):
        np.testing.assert_allclose(run(kernel.lower(), x, y), kernel(x, y), rtol=1e-5)


def test_types_follow_from_accesses() -> None:
    def dtypes(name: str) -> list[DType]:
        return [param.dtype for param in loaded(name).params]

    assert dtypes("cp") == [DType.U8, DType.U8, DType.I32]
    assert dtypes("load4") == [DType.I32, DType.I32]
    assert [param.words for param in loaded("sum64").params] == [1, 1, 2]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("sized", "a local array of variable size"),
        ("keeps", "an access to a global that is no constant"),
        ("longs", "an array access of type i64"),
    ],
)
def test_refused(name: str, message: str) -> None:
    with pytest.raises(KernelError, match=rf"memory\.ll:\d+: {message}") as caught:
        vividc.load_ll(FILE, name).lower()
    assert caught.value.hint
    assert "np." not in caught.value.hint


def test_the_package_runs_as_a_module() -> None:
    command = [sys.executable, "-m", "vividc", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert vividc.__version__ in done.stdout

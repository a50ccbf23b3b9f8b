"""Sizes known when a kernel is compiled: what is taken, what is refused, what becomes constant."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import vividc
from tests.frontend.test_ll import LOOP, write
from vividc.errors import ArgumentError
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function, Input


@vividc.kernel("void(float32[:, ::1], float32[::1], int16, int64, float32, boolean)")
def rows(a, x, n, m, scale, flag):
    for i in range(n):
        for j in range(a.shape[1]):
            if flag:
                x[i] += scale * a[i, j] * np.float32(m)


@dataclass(frozen=True)
class Shaped:
    """Something that only has a shape and a type."""

    shape: tuple[int, ...]
    dtype: object = np.float32


A, X = np.zeros((3, 5), np.float32), np.zeros(3, np.float32)


def inputs_of(function: Function) -> set[str]:
    values = (v for b in function.blocks for i in b.instrs for v in i.operands)
    return {value.key for value in values if isinstance(value, Input)}


@pytest.mark.parametrize(
    "like",
    [
        (A, X, 3, 1 << 40, 0.5, True),
        [Shaped((3, 5)), Shaped((3,), np.dtype(np.float32)), np.int16(3), 1 << 40, None, None],
        {"a": (3, 5), "x": 3, "n": np.array(3), "m": np.int64(1 << 40)},
        {"a": [np.int64(3), 5], "x": (3,), "n": 3, "m": 1 << 40, "scale": np.float32(2)},
    ],
)
def test_shapes_and_integers_are_known(like: object) -> None:
    sized = rows.sized(like)
    assert [p.known for p in sized.params] == [(3, 5), (3,), (3,), (1 << 40,), (), ()]
    assert [p.known for p in rows.params] == [()] * 6
    keys = inputs_of(sized.lower())
    assert keys <= {"&a", "&x", "scale", "flag", "a.pitch1"}
    assert {"n", "m"} <= inputs_of(rows.lower())


def test_none_is_any() -> None:
    assert not any(p.known for p in rows.sized([None] * 6).params)
    assert not any(p.known for p in rows.sized({}).params)


@pytest.mark.parametrize(
    ("like", "reason"),
    [
        ({"b": 3}, "has no parameter 'b'"),
        ((A, X), "takes 6 arguments, not 2"),
        (3, "like cannot be 3"),
        ({"a": 3}, r"a of rows: expected 2 dimension\(s\), got 1"),
        ({"a": (3, 5, 7)}, "got 3"),
        ({"a": (3, -1)}, "a dimension of -1 is not in 0 .. 16384"),
        ({"a": (3, 1 << 20)}, "a dimension of 1048576"),
        ({"a": (3, 5.0)}, r"a shape cannot be \(3, 5.0\)"),
        ({"a": A.astype(np.float64)}, "expected float32, got float64"),
        ({"n": 1 << 15}, "n of rows: 32768 does not fit int16"),
        ({"n": 3.0}, "expected int16, got 3.0"),
        ({"n": True}, "expected int16, got True"),
        ({"m": "3"}, "expected int64, got '3'"),
        ({"scale": "x"}, "expected float32"),
        ({"flag": A}, "expected bool"),
    ],
)
def test_what_fits_no_launch_is_refused(like: object, reason: str) -> None:
    with pytest.raises(ArgumentError, match=reason):
        rows.sized(like)


@pytest.mark.parametrize("n", [-2, 0, 1, 3])
def test_a_sized_kernel_does_the_same(n: int) -> None:
    values = np.random.default_rng(0)
    a = values.standard_normal((3, 5)).astype(np.float32)
    args = (a, X.copy(), np.int16(n), np.int64(-7), np.float32(0.5), np.bool_(True))
    expected = [np.copy(arg) for arg in args]
    rows(*expected[:2], *args[2:])
    interpret(rows.sized(args).lower(), *args)
    assert np.array_equal(args[1], expected[1])


def test_a_decorated_kernel_knows_sizes_itself() -> None:
    @vividc.kernel("int32(int32[::1], int32)", like={"n": 4})
    def total(x, n):
        result = np.int32(0)
        for i in range(n):
            result += x[i]
        return result

    x = np.arange(8, dtype=np.int32)
    program = vividc.compile(total)
    assert program.sizes == {"n": 4}
    assert vividc.simulate(program, x, 4).value == total(x, 4) == 6
    with pytest.raises(ArgumentError, match="was compiled for n = 4 only, and got n = 5"):
        vividc.simulate(program, x, 5)
    assert vividc.compile(total, like={"x": 8}).sizes == {"x": (8,)}


def test_scalars_of_c_are_known(tmp_path: Path) -> None:
    loaded = vividc.load_ll(write(tmp_path, LOOP))
    x = np.arange(24, dtype=np.int32).reshape(4, 6)
    sized = loaded.sized((x, 24))
    assert [p.known for p in sized.params] == [(), (24,)]
    assert "n" not in inputs_of(sized.lower())
    program = vividc.compile(loaded, like={"n": 24})
    assert vividc.simulate(program, x, 24).value == x.sum()
    with pytest.raises(ArgumentError, match="was compiled for n = 24 only, and got n = 23"):
        vividc.simulate(program, x, 23)
    with pytest.raises(ArgumentError, match="size of a pointer cannot be known"):
        loaded.sized({"x": (4, 6)})


def test_small_integers_of_c_wrap_as_at_launch(tmp_path: Path) -> None:
    text = "define i32 @f(i8 signext %k) {\n  %w = sext i8 %k to i32\n  ret i32 %w\n}\n"
    loaded = vividc.load_ll(write(tmp_path, text))
    for value in (-1, 200):
        program = vividc.compile(loaded, like=(value,))
        assert vividc.simulate(program, value).value == np.int64(value).astype(np.int8)

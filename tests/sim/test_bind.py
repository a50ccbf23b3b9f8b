"""Arguments of `simulate`: what is accepted, what is refused, what a failed run leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.program.hand_kernels import Hand, N, O, fabric, find, positive, program, saxpy
from vividc import simulate
from vividc.dfg.regions import RETURN_VARIABLE, Region
from vividc.errors import ArgumentError
from vividc.program import DType, Param, Program
from vividc.sim.bind import arguments, bind


def echo(dtype: DType) -> Program:
    """Return the scalar argument."""
    hand = Hand(fabric("mesh-1x1"), 2)
    value = hand.op(O.MOV, 0, 0)
    hand.feed(hand.live_in("v"), value)
    hand.feed(value, hand.op(O.LIVE_OUT, 0, 1, name=RETURN_VARIABLE))
    region = Region("echo", "straight", hand.dfg("echo"))
    return program("echo", (Param("v", dtype),), [(region, hand)], dtype)


@pytest.mark.parametrize(
    ("dtype", "given", "value"),
    [
        (DType.I32, -5, -5),
        (DType.I32, np.int64(7), 7),
        (DType.I32, True, 1),
        (DType.U32, 2**32 - 1, 2**32 - 1),
        (DType.I64, -(2**31), -(2**31)),
        (DType.F32, 0.1, float(np.float32(0.1))),
        (DType.F32, np.float64(-0.0), -0.0),
        (DType.F32, 3, 3.0),
        (DType.F32, float("-inf"), float("-inf")),
        (DType.I16, -(2**15), -(2**15)),
        (DType.U16, 2**16 - 1, 2**16 - 1),
        (DType.I8, np.int8(-1), -1),
        (DType.I8, 127, 127),
        (DType.U8, 255, 255),
        (DType.BOOL, np.True_, True),
        (DType.BOOL, 0, False),
    ],
)
def test_scalars(dtype: DType, given: object, value: object) -> None:
    result = simulate(echo(dtype), given).value
    assert result == value
    assert type(result) is type(value)


@pytest.mark.parametrize(
    ("dtype", "given"),
    [
        (DType.I32, 2**31),
        (DType.I32, 1.0),
        (DType.I32, "1"),
        (DType.I32, None),
        (DType.I32, np.zeros(())),
        (DType.U32, -1),
        (DType.I64, 2**31),
        (DType.F32, 1e39),
        (DType.F32, 10**400),
        (DType.F32, 1j),
        (DType.BOOL, 2),
        (DType.I16, 2**15),
        (DType.U16, -1),
        (DType.I8, -129),
        (DType.U8, 256),
        (DType.U8, 1.0),
    ],
)
def test_refused_scalars(dtype: DType, given: object) -> None:
    with pytest.raises(ArgumentError, match="argument v"):
        simulate(echo(dtype), given)


def arrays(n: int = 4) -> tuple[np.ndarray, np.ndarray]:
    return np.ones(n, np.float32), np.ones(n, np.float32)


def test_keywords_and_their_errors() -> None:
    x, y = arrays()
    simulate(saxpy(fabric()), x, n=4, y=y)
    assert y.tolist() == [3.0] * 4
    for args, kwargs, reason in (
        ((x, y), {}, "misses n"),
        ((x, y, 4, 5), {}, "takes 3 arguments, not 4"),
        ((x, y, 4), {"n": 4}, "got 'n' twice"),
        ((x, y, 4), {"m": 4}, "no parameter 'm'"),
        ((x, y, 4), {"engine": "warp"}, "unknown engine 'warp'"),
    ):
        with pytest.raises(ArgumentError, match=reason):
            simulate(saxpy(fabric()), *args, **kwargs)


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        ([1.0], "got list"),
        (np.ones(4), "got float64"),
        (np.ones(4, ">f4"), "got >f4"),
        (np.ones((2, 2), np.float32), r"float32 with 2 dimension\(s\)"),
        (np.ones(8, np.float32)[::2], "strides"),
    ],
)
def test_refused_arrays(bad: object, reason: str) -> None:
    with pytest.raises(ArgumentError, match=reason) as caught:
        simulate(saxpy(fabric()), bad, np.ones(4, np.float32), 4)
    assert "argument x of saxpy" in str(caught.value)


def test_read_only_arrays_may_be_read_but_not_written() -> None:
    x, y = arrays()
    x.flags.writeable = False
    simulate(saxpy(fabric()), x, y, 4)
    y.flags.writeable = False
    with pytest.raises(ArgumentError, match="read-only"):
        simulate(saxpy(fabric()), x, y, 4)


def test_the_way_out_of_a_wrong_number_of_dimensions_works() -> None:
    y = np.ones((2, 4), np.float32)
    with pytest.raises(ArgumentError) as caught:
        simulate(saxpy(fabric()), np.ones(8, np.float32), y, 8)
    assert caught.value.hint is not None
    assert "y.reshape(-1)" in caught.value.hint
    simulate(saxpy(fabric()), np.ones(8, np.float32), y.reshape(-1), 8)


def test_a_structured_array_is_told_as_one() -> None:
    x = np.ones(4, [("a", np.float32), ("b", np.int32)])
    with pytest.raises(ArgumentError, match="got structured with 1") as caught:
        simulate(saxpy(fabric()), x, np.ones(4, np.float32), 4)
    assert caught.value.hint is not None
    assert "np.ascontiguousarray(x['a'], np.float32)" in caught.value.hint
    x0 = np.ascontiguousarray(x["a"], np.float32)
    simulate(saxpy(fabric()), x0, np.ones(4, np.float32), 4)


def test_arrays_that_are_only_read_may_overlap() -> None:
    params = tuple(Param(name, DType.F32, 1) for name in "aby")
    base, y = np.arange(8, dtype=np.float32), np.zeros(8, np.float32)
    program = replace(saxpy(fabric()), params=params)
    assert program.stored_arrays == {"y"}
    for a, b in ((base, base), (base[:5], base[2:]), (base[2:], base[:5])):
        bound, _ = arguments(program, (a, b, y), {})
        assert bound["a"] is a
        assert bound["b"] is b
    with pytest.raises(ArgumentError, match="arrays a and y overlap, and the kernel writes y"):
        arguments(program, (base, y.copy(), base), {})


def test_overlapping_arrays_are_refused_where_one_is_written() -> None:
    base = np.ones(8, np.float32)
    with pytest.raises(ArgumentError, match="arrays x and y overlap, and the kernel writes y"):
        simulate(saxpy(fabric()), base, base, 4)
    with pytest.raises(ArgumentError, match="overlap"):
        simulate(saxpy(fabric()), base[:5], base[4:], 4)
    simulate(saxpy(fabric()), base[:4], base[4:], 4)


def test_arrays_larger_than_the_scratchpad() -> None:
    big = np.ones(8192, np.float32)
    with pytest.raises(ArgumentError, match="65536 bytes and the scratchpad has 32768"):
        simulate(saxpy(fabric()), big, big.copy(), 4)


def test_arrays_only_read_stay_untouched_even_with_nan_payloads() -> None:
    x = np.array([0x7FC12345, 0xFF800001], np.uint32).view(np.float32)
    y = np.zeros(2, np.float32)
    simulate(saxpy(fabric()), x, y, 0)
    assert x.view(np.uint32).tolist() == [0x7FC12345, 0xFF800001]


def test_64_bit_arrays_hold_one_word_per_element() -> None:
    compiled = positive(fabric())
    params = (Param("x", DType.I64, 1), Param("y", DType.I32, 1), N)
    wide = type(compiled)(**{**fields(compiled), "params": params})
    x, y = np.array([5, -3, 1]), np.zeros(3, np.int32)
    simulate(wide, x, y, 3)
    assert y.tolist() == [5, 0, 1]
    with pytest.raises(ArgumentError, match="32 bits"):
        simulate(wide, x * 2**40, y, 3)


NARROW = [DType.U8, DType.I8, DType.BOOL, DType.U16, DType.I16]


@pytest.mark.parametrize("dtype", NARROW)
def test_narrow_arrays_lie_in_the_scratchpad_as_in_numpy(dtype: DType) -> None:
    compiled = saxpy(fabric())
    params = (Param("x", dtype, 1), Param("y", DType.F32, 1), N)
    packed = type(compiled)(**{**fields(compiled), "params": params})
    x = np.arange(7).astype(dtype.value)
    bound = bind(packed, (x, np.ones(2, np.float32), 0), {})
    start = bound.addresses["x"]
    assert bound.extents["x"] == (start, start + x.nbytes)
    assert bound.memory.tobytes()[start : start + x.nbytes] == x.tobytes()
    assert bound.addresses["y"] % 4 == 0
    bound.memory.view(np.uint8)[start : start + x.nbytes] = 1
    bound.copy_back(bound.memory, frozenset({"x"}))
    assert x.tobytes() == b"\x01" * x.nbytes


def test_a_flag_is_0_or_1_whatever_its_byte() -> None:
    compiled = saxpy(fabric())
    params = (Param("x", DType.BOOL, 1), Param("y", DType.F32, 1), N)
    packed = type(compiled)(**{**fields(compiled), "params": params})
    flags = np.array([0, 1, 2, 255], np.uint8).view(np.bool_)
    bound = bind(packed, (flags, np.ones(2, np.float32), 0), {})
    start = bound.addresses["x"]
    assert bound.memory.view(np.uint8)[start : start + 4].tolist() == [0, 1, 1, 1]


def fields(compiled: Program) -> dict[str, object]:
    return {name: getattr(compiled, name) for name in type(compiled).__dataclass_fields__}


def test_failed_run_leaves_arrays_untouched() -> None:
    x = np.arange(8, dtype=np.int32)
    y = np.zeros(8, np.int32)
    with pytest.raises(Exception, match="out-of-bounds"):
        simulate(find(fabric()), x, y, 12345)
    assert not y.any()

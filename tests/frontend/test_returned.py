"""Returned arrays, tuples and None: numba, the SSA interpreter and the simulator agree."""

from __future__ import annotations

import warnings
from collections import namedtuple
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace

import numba
import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import KernelError, SimulationError, VividcWarning
from vividc.program import from_bytes
from vividc.ssa.interpret import interpret
from vividc.ssa.results import Leaf, Results, named_leaves
from vividc.ssa.text import parse, to_text

Point = namedtuple("Point", "x y")
X = np.arange(6, dtype=np.float32)


def twice(x, n):
    return x * np.float32(2)


def table(x, n):
    made = np.zeros((n, 3), np.int32)
    for i in range(n):
        made[i, 1] = i
    return made


def parts(x, n):
    count = np.zeros(n, np.uint8)
    count[1] = 200
    return np.arange(n), (n, x[1:]), Point(np.float32(n), n > 3), count[::-1], None


def flags(x, n):
    return n > 3, x[1] > 0


def flags_in_tuples(x, n):
    return ((n > 3, x[1] > 0), (x[2] > 9, True)), Point(n > 2, x[0]), n


def maybe(x, n):
    if n > 3:
        return None
    return x + x


def one_of_three(x, n):
    if n > 3:
        made = np.zeros(n, np.float32)
        made[1] = n
        return made
    total = np.ones(2, np.float32)
    for i in range(n):
        total[0] += x[i]
        if total[0] > 2:
            return x[2:]
    return total


def some(x, n):
    found = np.empty(len(x), np.int32)
    count = 0
    for i in range(len(x)):
        if x[i] > n:
            found[count] = i
            count += 1
    return found[:count]


def same_twice(x, n):
    made = x.copy()
    return made, made[1:]


def doubles(x, n):
    made = np.zeros(n)
    for i in range(n):
        made[i] = x[i]
    return made, len(x) * 2**33, x.sum()


def the_parameter(x, n):
    x[0] = n
    return x


def transposed(x, n):
    return x.reshape(2, 3).T


def either_way(x, n):
    made = x * np.float32(n)
    step = 1 if n > 3 else -2
    return x[::step], made[::-step]


KERNELS = (
    *(
        twice,
        table,
        parts,
        flags,
        flags_in_tuples,
        maybe,
        one_of_three,
        some,
        same_twice,
        doubles,
        the_parameter,
    ),
    *(transposed, either_way),
)


@pytest.mark.parametrize("function", KERNELS)
def test_all_witnesses_return_the_same(function: Callable[..., object]) -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(function)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        lowered = kernel.lower()
    assert parse(to_text(lowered)) == lowered
    program = words_in_blocks(lowered)
    assert from_bytes(program.to_bytes()) == program
    for n in (2, 5):
        theirs, by_ssa, by_words = X.copy(), X.copy(), X.copy()
        expected = kernel(theirs, np.int32(n))
        same(interpret(lowered, by_ssa, np.int32(n)), expected)
        for engine in ("reference", "native"):
            by_words = X.copy()
            result = vividc.simulate(program, by_words, n, engine=engine)
            same(result.value, expected)
        assert np.array_equal(theirs, by_words)
        assert np.array_equal(theirs, by_ssa)


def same(found: object, expected: object) -> None:
    assert type(found).__name__ == type(expected).__name__
    ours, theirs = dict(named_leaves(found)), dict(named_leaves(expected))
    assert ours.keys() == theirs.keys()
    for name, array in theirs.items():
        assert ours[name].dtype == array.dtype or not array.ndim
        assert np.array_equal(ours[name], array)


def test_a_returned_part_of_an_argument_is_a_view_of_it() -> None:
    program = words_in_blocks(vividc.kernel("(float32[::1], int32)")(the_parameter).lower())
    x = X.copy()
    value = vividc.simulate(program, x, 3).value
    assert value is x or np.shares_memory(value, x)


def test_arrays_returned_together_share_memory_as_in_numba() -> None:
    program = words_in_blocks(vividc.kernel("(float32[::1], int32)")(same_twice).lower())
    whole, part = vividc.simulate(program, X.copy(), 3).value
    whole[1] = 7
    assert part[0] == 7


def test_an_array_of_words_of_a_run_is_another_in_each_run() -> None:
    program = words_in_blocks(vividc.kernel("(float32[::1], int32)")(twice).lower())
    first = vividc.simulate(program, X.copy(), 3).value
    kept = deepcopy(first)
    vividc.simulate(program, X + 1, 3)
    assert np.array_equal(first, kept)


def test_the_array_is_no_argument() -> None:
    program = words_in_blocks(vividc.kernel("(float32[::1], int32)")(twice).lower())
    with pytest.raises(vividc.VividcError, match=r"twice\(x, n\) takes 2 arguments, not 3"):
        vividc.simulate(program, X.copy(), 3, X.copy())


def test_a_constant_array_is_returned_as_a_copy_only() -> None:
    constant = np.arange(4, dtype=np.float32)

    def returned(x):
        return constant

    with pytest.raises(KernelError, match="a constant array is returned"):
        vividc.kernel("(float32[::1],)")(returned).lower()


def test_a_flag_is_a_scalar() -> None:
    results = Results((Leaf("float32", ("x",)), Leaf("bool", ("f",), is_scalar=True)))
    assert replace(results, form=(1, 0, "optional")).is_sound
    assert not replace(results, form=(0, 0, "optional")).is_sound


@pytest.mark.parametrize("is_scalar", [False, True])
def test_a_damaged_type_lies_outside_its_memory(is_scalar: bool) -> None:
    for made, size in (((), 3), (("x",), 0)):
        for dtype in ("int64", "float64"):
            leaf = Leaf(dtype, ("x",), shape=((1,),), strides=((8,),), is_scalar=is_scalar)
            results = Results((replace(leaf, offset=(8,)),), made=made)
            with pytest.raises(SimulationError, match="outside its memory"):
                results.value({"x": np.zeros(size, np.int32)}, {})


def test_all_tiles_fill_a_returned_array() -> None:
    @vividc.kernel("(float32[::1],)")
    def squares(x):
        made = np.empty(x.shape[0], np.float32)
        for i in numba.prange(x.shape[0]):
            made[i] = x[i] * x[i]
        return made

    program = vividc.compile(squares, fabric="vivid")
    x = np.arange(100, dtype=np.float32)
    assert np.array_equal(vividc.simulate(program, x).value, x * x)

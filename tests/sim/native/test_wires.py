"""Words that pass several links in one cycle: both engines, against numba."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import vividc
from tests.sim.native.agreement import agreed_run, launch
from vividc.arch import load
from vividc.errors import BundleError
from vividc.program import Entry, Program, Sel, Select, Write, decode, disassemble
from vividc.program.words.wires import check_wires, driver


@vividc.kernel("void(float32[::1], float32[:,::1], float32[::1], int32, int32)")
def matrix_vector(x, a, y, n, m):
    for i in range(n):
        total = np.float32(0.0)
        for j in range(m):
            total += a[i, j] * x[j]
        y[i] = total


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def mix(x, y, n):
    total = 0
    for i in range(n):
        v = x[i] ^ (y[i] << 3)
        if v > 5:
            total += v * 3 + x[n - 1 - i]
        else:
            y[i] = total ^ v
    return total


@cache
def _program(name: str, fabric: str) -> Program:
    # Negotiation would do without several links a cycle; the solver takes them.
    kernel = {"matrix_vector": matrix_vector, "mix": mix}[name]
    return vividc.compile(kernel, fabric=fabric, mapper="cpsat", time_limit_s=20, effort="fast")


def _arguments(name: str) -> tuple[object, ...]:
    draw = np.random.default_rng(3)
    if name == "mix":
        x, y = (draw.integers(-99, 99, 23).astype(np.int32) for _ in range(2))
        return x, y, 23
    x = draw.integers(-9, 9, 7).astype(np.float32)
    a = draw.integers(-9, 9, (5, 7)).astype(np.float32)
    return x, a, np.zeros(5, np.float32), 5, 7


def _wires(program: Program) -> int:
    entries = (entry for context in program.entries for entry in context)
    return sum(select.kind is Sel.WIRE for entry in entries for select in entry.links)


@pytest.mark.parametrize(
    ("name", "fabric"),
    [
        ("matrix_vector", "hycube-4x4"),
        pytest.param("matrix_vector", "hycube-2x5", marks=pytest.mark.slow),
        ("mix", "hycube-4x4"),
        pytest.param("mix", "hycube-2x5", marks=pytest.mark.slow),
    ],
)
def test_results_are_those_of_numba(name: str, fabric: str) -> None:
    program = _program(name, fabric)
    expected, found = _arguments(name), _arguments(name)
    value = {"matrix_vector": matrix_vector, "mix": mix}[name](*expected)
    result = vividc.simulate(program, *found)
    assert result.value == value
    for one, other in zip(expected, found, strict=True):
        np.testing.assert_array_equal(one, other)
    agreed_run(program, launch(program, *_arguments(name)))


def test_words_do_pass_links() -> None:
    program = _program("matrix_vector", "hycube-4x4")
    assert _wires(program) > 0
    assert "wire<-" in disassemble(program)


def test_as_many_links_a_cycle_as_the_words_need_suffice() -> None:
    program = _program("matrix_vector", "hycube-4x4")
    deepest = max(
        driver(program.fabric, context, pe, select)[2]
        for context in program.entries
        for pe, entry in enumerate(context)
        for select in entry.links
    )
    assert deepest > 1
    enough = replace(program.fabric, routing=replace(program.fabric.routing, hops=deepest))
    assert decode(enough, program.words) == list(map(list, program.entries))


def _line(*drives: Select) -> list[Entry]:
    """A 1x4 mesh whose PEs 0, 1, 2 drive their links to the east so."""
    idle = Entry(None, (Select(Sel.NONE),) * 2, (0,) * 4, (Write(),) * 4)
    return [*(replace(idle, links=(drive, Select(Sel.NONE))) for drive in drives), idle]


def test_more_links_than_a_cycle_has_time_for() -> None:
    fabric = load("hycube-1x4")
    assert [k.dst for k in fabric.links_from[1]] == [2, 0]
    assert [k.src for k in fabric.links_to[1]] == [0, 2]
    wire = Select(Sel.WIRE, 0)
    line = _line(Select(Sel.RES), wire, wire)
    assert driver(fabric, line, 2, wire) == (0, Select(Sel.RES), 3)
    check_wires(fabric, line, 0)
    two = replace(fabric, routing=replace(fabric.routing, hops=2))
    with pytest.raises(BundleError, match="more than 2 links in a cycle, at PE 2"):
        check_wires(two, line, 0)


def test_wires_in_a_circle_are_refused() -> None:
    fabric = load("hycube-1x2")
    idle = Entry(None, (Select(Sel.WIRE, 0),), (0,) * 4, (Write(),) * 4)
    with pytest.raises(BundleError, match="more than 4 links"):
        check_wires(fabric, [idle, idle], 0)

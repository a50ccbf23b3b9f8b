"""Entries of constant stores that variables share."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vividc
from tests.programs import lower, programs
from vividc import arch
from vividc.compiler.regions.stores import Stores
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.forms.text_parser import parse
from vividc.dfg.lives import ALWAYS, Lives, needed_after
from vividc.dfg.regions import Kernel, Region
from vividc.mapper.mapping import Mapping, Place
from vividc.mapper.problem import ConstantKey
from vividc.program.encoder.constants import numbered_entries


def copy(read: str, write: str) -> str:
    return f'dfg "copy"\n%0 = live_in "%{read}"\n%1 = mov %0\n%2 = live_out "%{write}" %1\n'


def kernel(*texts: str, loops: tuple[int, ...] = ()) -> Kernel:
    """Regions one after the other, these of them loops."""
    last = len(texts) - 1
    return Kernel(
        "k",
        (),
        tuple(
            Region(
                f"r{at}",
                "loop" if at in loops else "straight",
                parse(text),
                None if at == last else at + 1,
                counted=at in loops,
            )
            for at, text in enumerate(texts)
        ),
    )


def test_what_is_read_behind_a_region_is_needed_there() -> None:
    after = needed_after(kernel(copy("a", "b"), copy("c", "d"), copy("b", "e")))
    assert "b" not in {name for names in after for name in names}
    assert "%b" in after[0]
    assert "%b" in after[1]
    assert "%b" not in after[2]
    assert "%c" in after[0]


def test_a_loop_that_may_have_no_iteration_keeps_what_was_there() -> None:
    before = copy("x", "a")
    loop, end = copy("y", "a"), copy("a", "z")
    assert "%a" in needed_after(kernel(before, loop, end, loops=(1,)))[0]
    assert "%a" not in needed_after(kernel(before, loop, end))[0]


def test_what_a_loop_needs_is_needed_by_the_region_that_may_begin_as_it_ends() -> None:
    lives = Lives.of(kernel(copy("x", "a"), copy("a", "b"), copy("c", "d"), loops=(1,)))
    assert lives.regions["%a"] == 0b111
    assert lives.of_key(("live_in", "%d")) == 0b100
    assert lives.of_key(("const", 3)) == lives.of_key(("live_in", "n")) == ALWAYS


@settings(max_examples=100)
@given(programs(), st.integers(4, 40))
def test_no_two_words_that_a_region_needs_share_an_entry(
    program: tuple[object, ...], room: int
) -> None:
    made = build_kernel(lower(program))
    lives = Lives.of(made)
    keys: list[ConstantKey] = [("const", 1), ("live_in", "n")]
    keys += [("live_in", name) for name in lives.regions]
    numbers = numbered_entries(keys, room, lives)
    most = max(sum(lives.of_key(k) >> at & 1 for k in keys) for at in range(len(made.regions)))
    if numbers is None:
        assert len(keys) > room
        return
    assert set(numbers) == set(keys)
    assert max(numbers.values()) < room
    assert most <= room
    for one in keys:
        for other in keys:
            if one != other and numbers[one] == numbers[other]:
                assert not lives.of_key(one) & lives.of_key(other)


def test_stores_are_tried_as_they_are_needed_and_then_as_they_are_taken() -> None:
    tile = arch.load_tile("vivid-tile")
    small = replace(tile, pes=tuple(replace(pe, constants=3) for pe in tile.pes))
    made = kernel(copy("a", "b"), copy("c", "d"), copy("e", "f"), loops=(0, 1, 2))
    stores = Stores.of(made, small)
    assert stores.are_crowded
    assert not Stores.of(made, tile).are_crowded
    mapping = Mapping(1, {1: Place(5, 0), 2: Place(5, 1)}, {})
    held = stores.with_regions([(made.regions[0].dfg, mapping)])
    first, *_, last = held.beside(2)
    assert first[5] == frozenset()
    assert len(last[5]) == 2
    both = held.with_regions([(made.regions[2].dfg, mapping)])
    assert len(both.held[5]) == 4
    assert both.fit()
    three = both.with_regions([(made.regions[1].dfg, mapping)])
    assert not three.fit()


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def several_nests(x: Any, y: Any, z: Any) -> None:
    """Loops one after the other, each with pitches and offsets of its own."""
    n, m = x.shape
    for i in range(n):
        for j in range(m - 1):
            y[i, j] = x[i, j] * np.float32(0.5) + x[i, j + 1]
    for i in range(n - 1):
        for j in range(m):
            z[i, j] = y[i + 1, j] - y[i, j] * np.float32(0.25)
    for i in range(n):
        for j in range(m):
            x[i, j] = z[i, j] * z[i, j] + y[i, j]


@pytest.mark.parametrize("entries", [7, 6])
def test_nests_run_on_tiles_with_small_constant_stores(entries: int) -> None:
    tile = arch.load_tile("vivid-tile")
    small = replace(tile, pes=tuple(replace(pe, constants=entries) for pe in tile.pes))
    program = vividc.compile(several_nests, small, loops=vividc.LoopOptions(restructure=False))
    assert max(int(row.sum()) for row in program.images_set) <= entries
    mine = [np.linspace(-1, 1, 42, dtype=np.float32).reshape(6, 7) + k for k in range(3)]
    numbas = [array.copy() for array in mine]
    vividc.simulate(program, *mine)
    several_nests(*numbas)
    for one, other in zip(mine, numbas, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-5)

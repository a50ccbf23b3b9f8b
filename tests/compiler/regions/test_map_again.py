"""Loops mapped again, for fewer bank stalls and shorter iterations: at the same II."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import vividc
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.driver import lower
from vividc.compiler.regions.map_again import Runs
from vividc.compiler.regions.map_regions import MapOptions, map_kernel
from vividc.dfg.regions import Kernel
from vividc.mapper import EffortLevel, MapResult
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Try, least_span
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.banks import Traffic, words_of
from vividc.program.encoder.banks import choose_layout, traffic_of
from vividc.program.encoder.checks import span_of


@vividc.kernel("void(float32[:,::1], float32[:,::1])")
def nine_points(a, b):
    for i in range(1, a.shape[0] - 1):
        for j in range(1, a.shape[1] - 1):
            b[i, j] = (
                a[i - 1, j - 1]
                + a[i - 1, j]
                + a[i - 1, j + 1]
                + a[i, j - 1]
                + a[i, j]
                + a[i, j + 1]
                + a[i + 1, j - 1]
                + a[i + 1, j]
                + a[i + 1, j + 1]
            )


@vividc.kernel("void(int32[::1], int32[::1])")
def eight_apart(x, y):
    for i in range(len(y)):
        y[i] = (x[i] ^ x[i + 8]) + (x[i + 16] ^ x[i + 24]) + (x[i + 32] ^ x[i + 40])


@vividc.kernel("void(float32[::1], int32[::1], float32[::1])")
def rows_of_a_table(table, rows, out):
    for i in range(len(rows)):
        o = rows[i] & 255
        a = table[o] * table[o + 1] + table[o + 2]
        out[i] = (table[o + 3] * a + table[o + 4]) * table[o + 5] + a


@vividc.kernel("void(int32[::1], int32[::1])")
def alone(x, y):
    for i in range(len(y)):
        y[i] = x[i] + 1


def mapped(
    kernel: vividc.KernelFunction, runs: bool, effort: EffortLevel = "normal"
) -> tuple[Kernel, dict[int, MapResult], Fabric, list[float]]:
    fabric = arch.load("vivid-tile")
    assert isinstance(fabric, Fabric)
    lowered = lower(kernel)
    loop = [100.0 if region.kind == "loop" else 1.0 for region in lowered.regions]
    given = Runs([1.0] * len(loop), loop) if runs else None
    made = map_kernel(lowered, fabric, MapOptions(effort=effort), runs=given)
    assert isinstance(made, tuple)
    return *made, fabric, loop


def stalls(
    kernel: Kernel, results: dict[int, MapResult], fabric: Fabric, runs: list[float]
) -> float:
    mappings = {index: r.mapping for index, r in results.items() if r.mapping is not None}
    traffic = traffic_of(kernel, fabric, mappings, runs)
    pitches, starts = choose_layout(kernel, traffic)
    return sum(one.weight * one.stalls(words_of(starts, pitches)) for one in traffic)


@pytest.mark.parametrize("effort", ["normal", "thorough"])
@pytest.mark.parametrize("kernel", [nine_points, eight_apart, alone], ids=lambda k: k.name)
def test_fewer_stalls_at_the_same_iis(kernel: vividc.KernelFunction, effort: EffortLevel) -> None:
    plain, results, fabric, runs = mapped(kernel, runs=False, effort=effort)
    spared, better, _, _ = mapped(kernel, runs=True, effort=effort)
    assert {i: r.ii for i, r in results.items() if plain.regions[i].kind == "loop"} == {
        i: r.ii for i, r in better.items() if spared.regions[i].kind == "loop"
    }
    for index, result in better.items():
        if spared.regions[index].kind == "loop":
            assert result.mapping is not None
            assert violations(spared.regions[index].dfg, fabric, result.mapping) == []
    before, after = stalls(plain, results, fabric, runs), stalls(spared, better, fabric, runs)
    assert after <= before
    if kernel is eight_apart:
        assert before > 50.0
        assert after < 0.5 * before
    assert [r.mapping for r in better.values()] == [
        r.mapping for r in mapped(kernel, True, effort)[1].values()
    ]


@vividc.kernel("void(float32[:,::1], float32[:,::1], float32[::1])")
def products(a, b, y):
    for j in range(len(y)):
        total = y[j]
        for i in range(a.shape[0]):
            total += a[i, j] * b[i, j] * (a[i, j] - b[i, j]) * (a[i, j] + b[i, j])
        y[j] = total


def test_iterations_of_a_loop_entered_often_are_not_longer() -> None:
    fabric = arch.load("vivid-tile")
    assert isinstance(fabric, Fabric)
    lowered = lower(products)
    loops = [i for i, region in enumerate(lowered.regions) if region.kind == "loop"]
    often = Runs([100.0] * len(lowered.regions), [300.0] * len(lowered.regions))
    plain = map_kernel(lowered, fabric, MapOptions())
    again = map_kernel(lowered, fabric, MapOptions(), runs=often)
    assert isinstance(plain, tuple)
    assert isinstance(again, tuple)
    for index in loops:
        old, new = plain[1][index].mapping, again[1][index].mapping
        assert old is not None
        assert new is not None
        assert new.ii == old.ii
        region = again[0].regions[index]
        assert span_of(region, new, fabric) <= span_of(plain[0].regions[index], old, fabric)
        assert span_of(region, new, fabric) >= least_span(MapProblem(region.dfg, fabric), new.ii)
        assert violations(region.dfg, fabric, new) == []


def test_what_it_computes_stays() -> None:
    x = np.arange(240, dtype=np.int32) * 7919 % 1009
    y = np.zeros(200, np.int32)
    expected = (x[:200] ^ x[8:208]) + (x[16:216] ^ x[24:224]) + (x[32:232] ^ x[40:240])
    program = vividc.compile(eight_apart, loops=vividc.LoopOptions(auto=False))
    result = vividc.simulate(program, x, y)
    assert np.array_equal(y, expected)
    assert result.stats["stalls"]["bank_conflict"] < 0.1 * result.cycles


@pytest.mark.parametrize(("annealing_s", "most"), [(0.4, 5), (0.15, 7), (0.01, 8)])
def test_seeds_that_map_nothing_end_a_search_the_sooner_the_more_they_cost(
    monkeypatch: pytest.MonkeyPatch, annealing_s: float, most: int
) -> None:
    seeds: dict[int, set[int]] = {}

    def nothing(tries: Sequence[Try], *_others: object) -> list[None]:
        for one in tries:
            assert one.frame is not None
            seeds.setdefault(one.ii if one.frame.meetings.accesses else 0, set()).add(one.seed)
        return [None] * len(tries)

    monkeypatch.setattr("vividc.compiler.regions.map_again.negotiate_each", nothing)
    monkeypatch.setattr("vividc.compiler.regions.map_again.annealing_s", lambda *_: annealing_s)
    _, results, _, _ = mapped(eight_apart, runs=True, effort="thorough")
    assert all(result.mapping is not None for result in results.values())
    assert max(map(len, seeds.values())) == most


def test_in_haste_a_search_ends_by_what_it_may_save(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stalls of a twentieth of the cycles are worth half a second, of the half five."""

    def begun(share: float, effort: EffortLevel) -> int:
        seeds: list[int] = []

        def slow(tries: Sequence[Try], deadline: Deadline, _: int) -> list[None]:
            seeds.extend(one.seed for one in tries)
            deadline.charge(0.2 * len(tries))
            return [None] * len(tries)

        monkeypatch.setattr("vividc.compiler.regions.map_again.negotiate_each", slow)
        monkeypatch.setattr(Traffic, "stalls", lambda self, *_: share / (1 - share) * self.ii)
        mapped(eight_apart, runs=True, effort=effort)
        return len(seeds)

    assert begun(0.0, "normal") < begun(0.05, "normal") < begun(0.5, "normal")
    assert begun(0.05, "normal") < begun(0.05, "thorough")


def test_accesses_around_a_place_that_nobody_knows_start_together() -> None:
    """Six of one row never meet each other in a cycle, and those of two iterations may."""
    program = vividc.compile(rows_of_a_table, arch.load("vivid-tile"), cache=False)
    rng = np.random.default_rng(0)
    table, rows = rng.random(300, np.float32), rng.integers(0, 256, 200).astype(np.int32)
    result = vividc.simulate(program, table, rows, np.zeros(200, np.float32))
    assert [region.ii for region in program.regions if region.kind == "loop"] == [2]
    assert result.stats["stalls"]["bank_conflict"] < 20

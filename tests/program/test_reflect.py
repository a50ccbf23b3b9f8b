"""Mirrored programs: as legal, as fast, and with the same results, on all four tiles."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc import arch, mapper
from vividc.arch import Fabric, Orientation
from vividc.compiler.driver import lower
from vividc.errors import InternalError
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.program.encoder.reflect import reflected_program

CORNERS: list[Orientation] = ["nw", "ne", "sw", "se"]


@vividc.kernel("float32(float32[::1], float32[::1], int32)")
def mixed(x, y, n):
    total = np.float32(0)
    for i in range(n):
        value = x[i] * y[n - 1 - i]
        if value > 0:
            y[i] = value
        total += value
    return total


@pytest.fixture(scope="module")
def program() -> vividc.Program:
    return vividc.compile(mixed, fabric="vivid-tile", time_limit_s=20)


@pytest.mark.parametrize("corner", CORNERS)
def test_a_mirrored_program_gives_the_same(program: vividc.Program, corner: Orientation) -> None:
    fabric = arch.reflected(program.fabric, corner)
    mirrored = reflected_program(program, fabric, arch.reflection(program.fabric, corner))
    rng = np.random.default_rng(2)
    x, y = rng.standard_normal((2, 40)).astype(np.float32)
    results = []
    for code in (program, mirrored):
        mine = y.copy()
        for engine in ("reference", "native"):
            mine = y.copy()
            done = vividc.simulate(code, x.copy(), mine, 40, engine=engine)
            results.append((done.value, done.cycles, done.stats["activity"], mine.tobytes()))
    assert all(result == results[0] for result in results)


def test_mirroring_twice_is_nothing(program: vividc.Program) -> None:
    fabric = arch.reflected(program.fabric, "se")
    places = arch.reflection(program.fabric, "se")
    back = reflected_program(reflected_program(program, fabric, places), program.fabric, places)
    assert back == program


def test_other_fabrics_are_refused(program: vividc.Program) -> None:
    with pytest.raises(InternalError, match="is not a mirror image"):
        reflected_program(program, arch.load_tile("vivid-tile-ne"), tuple(range(16)))


def mirrored_mapping(
    mapping: Mapping, fabric: Fabric, other: Fabric, places: tuple[int, ...]
) -> Mapping:
    ends = {(link.src, link.dst): link.id for link in other.links}
    links = {k.id: ends[places[k.src], places[k.dst]] for k in fabric.links}

    def step(item: Step) -> Step:
        index = links[item.index] if item.kind == "link" else item.index
        return Step(item.kind, places[item.pe], index, item.time)

    return Mapping(
        mapping.ii,
        {node: Place(places[p.pe], p.time) for node, p in mapping.places.items()},
        {edge: tuple(map(step, route)) for edge, route in mapping.routes.items()},
    )


@pytest.mark.parametrize("corner", CORNERS[1:])
def test_a_mirrored_mapping_is_legal(corner: Orientation) -> None:
    fabric = arch.load_tile("vivid-tile")
    dfg = next(region.dfg for region in lower(mixed).regions if region.kind == "loop")
    result = mapper.map_dfg(dfg, fabric, time_limit_s=20)
    assert result.mapping is not None
    other = arch.reflected(fabric, corner)
    mapping = mirrored_mapping(result.mapping, fabric, other, arch.reflection(fabric, corner))
    assert not mapper.verify(dfg, other, mapping)

"""Every mapper, ours and one that comes by an entry point, passes the same tests."""

from __future__ import annotations

import random
import time
from collections.abc import Iterator
from importlib.metadata import EntryPoint, EntryPoints

import pytest
from fabrics import grid
from graphs import GraphBuilder, accumulator, blending, chain
from random_graphs import random_loop
from replay import Broken, replay
from test_mutation import MUTATIONS

from vividc import arch
from vividc.arch import Fabric
from vividc.dfg.ir import DFG
from vividc.errors import VividcError
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper import MapResult, map_dfg, registry, violations
from vividc.mapper.engines.negotiate import prepare

GUEST = "guest"
MAPPERS = (*registry.BUILT_IN, GUEST)
_LIMIT_S = 30.0
_GENEROUS_S = 6.0
_ITERATIONS = 8


@pytest.fixture(params=MAPPERS)
def mapper(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    point = EntryPoint(GUEST, "vividc.mapper.published.spr:spr", registry.ENTRY_POINT_GROUP)

    def installed(name: str | None = None, **_: str) -> EntryPoints:
        return EntryPoints([point] if name in (None, GUEST) else [])

    monkeypatch.setattr(registry, "entry_points", installed)
    return request.param


def _mapped(dfg: DFG, fabric: Fabric, mapper: str, ii: int | None = None) -> MapResult:
    return map_dfg(dfg, fabric, mapper, ii, _LIMIT_S, workers=1)


def test_small_graphs_reach_their_bound(mapper: str) -> None:
    for dfg in (accumulator(), chain(4)):
        result = _mapped(dfg, grid(2, 2), mapper)
        assert (result.status, result.ii) == ("optimal", 1)


def test_mappings_are_legal_and_run(mapper: str) -> None:
    for seed in range(12):
        dfg = random_loop(seed, 6)
        result = _mapped(dfg, grid(2, 2, constants=12), mapper)
        if result.mapping is None:
            assert result.status in ("timeout", "infeasible")
            continue
        assert result.lower_bound <= result.mapping.ii == result.ii
        assert violations(dfg, grid(2, 2, constants=12), result.mapping) == []
        replay(dfg, grid(2, 2, constants=12), result.mapping, _ITERATIONS)


def test_a_recurrence_is_kept(mapper: str) -> None:
    fabric = grid(2, 2, latencies={LatencyClass.FADD: 4})
    result = _mapped(accumulator(), fabric, mapper)
    assert (result.status, result.ii, result.lower_bound) == ("optimal", 4, 4)


def test_a_time_limit_is_kept(mapper: str) -> None:
    """Words that live long kept "ims" searching for minutes."""
    g = GraphBuilder("long lives")
    value, one = g.source(Opcode.IV), g.const(1)
    early = [g.op(Opcode.ADD, value, one) for _ in range(6)]
    for _ in range(100):
        value = g.op(Opcode.ADD, value, one)
    for word in early:
        value = g.op(Opcode.ADD, value, word)
    prepare()
    began = time.process_time()
    map_dfg(g.build(), arch.load("vivid-8x8"), mapper, time_limit_s=0.5, workers=1)
    assert time.process_time() - began < _GENEROUS_S


def test_an_ii_below_the_bound_is_refuted(mapper: str) -> None:
    result = _mapped(chain(5), grid(1, 2), mapper, ii=2)
    assert (result.status, result.ii) == ("infeasible", None)


def test_a_given_ii_is_kept(mapper: str) -> None:
    result = _mapped(chain(3), grid(2, 2), mapper, ii=3)
    assert (result.ii, result.lower_bound) == (3, 1)


def test_a_node_that_no_pe_takes_is_proved(mapper: str) -> None:
    nothing = dict.fromkeys((0, 1), frozenset({LatencyClass.INT}))
    result = _mapped(accumulator(), grid(1, 2, classes=nothing), mapper)
    assert result.status == "infeasible"


def test_homes_and_stores_are_kept(mapper: str) -> None:
    dfg = chain(3)
    last = dfg.operations[-1].id
    full = frozenset({("const", 9)})
    fabric = grid(2, 2, constants=1)
    result = map_dfg(
        dfg,
        fabric,
        mapper,
        allowed={last: frozenset({3})},
        resident={0: full},
        workers=1,
        time_limit_s=_LIMIT_S,
    )
    assert result.mapping is not None
    assert result.mapping.places[last].pe == 3
    assert all(place.pe != 0 for place in result.mapping.places.values())


@pytest.mark.parametrize("name", ["openedge-2x2", "hycube-2x2"])
def test_other_arrays_are_mapped_or_refused(mapper: str, name: str) -> None:
    fabric = arch.load(name)
    if name.startswith("openedge") and mapper == "ims":
        with pytest.raises(VividcError, match="no words take links"):
            _mapped(chain(4), fabric, mapper)
        return
    result = _mapped(chain(4), fabric, mapper)
    assert result.mapping is not None
    replay(chain(4), fabric, result.mapping, _ITERATIONS)


@pytest.mark.slow
def test_a_kernel_of_forty_operations(mapper: str) -> None:
    result = _mapped(blending(), grid(4, 4, registers=8), mapper)
    assert result.mapping is not None


@pytest.mark.parametrize("name", ["grid", "openedge-2x2", "hycube-2x2"])
def test_damage_to_what_a_mapper_made_is_noticed(mapper: str, name: str) -> None:
    if name.startswith("openedge") and mapper == "ims":
        return
    _damage(mapper, grid(2, 2) if name == "grid" else arch.load(name), 2)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["grid", "openedge-3x3", "hycube-3x3", "adres-2x2"])
def test_much_damage_to_what_a_mapper_made_is_noticed(mapper: str, name: str) -> None:
    fabric = grid(2, 2) if name == "grid" else arch.load(name)
    if name[:5] in ("opene", "adres") and mapper == "ims":
        return
    _damage(mapper, fabric, 200)


def _damage(mapper: str, fabric: Fabric, times: int) -> None:
    """Each damaged mapping is reported, or is one that a tagged replay runs."""
    rng = random.Random(mapper)
    for dfg in (accumulator(), chain(5)):
        mapping = _mapped(dfg, fabric, mapper).mapping
        assert mapping is not None
        for mutation in MUTATIONS:
            for _ in range(times):
                mutant = mutation(rng, fabric, mapping)
                if violations(dfg, fabric, mutant):
                    continue
                try:
                    replay(dfg, fabric, mutant, _ITERATIONS)
                except Broken as broken:
                    pytest.fail(f"{mutation.__name__}: {broken}")

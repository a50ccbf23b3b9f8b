"""Stays that fit no register file are excluded in all their places and times at once."""

from __future__ import annotations

import random

import pytest
from tiny_fabrics import tiny_fabric

from vividc.arch.fabric import Fabric, Routing
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import Opcode
from vividc.mapper import map_dfg
from vividc.mapper.engines.cpsat import solve


def _kept_long(seed: int) -> tuple[DFG, Fabric]:
    """Two or three operations that read their own results of earlier iterations; few registers."""
    rng, size = random.Random(seed), 2 + seed // 2 % 2
    nodes = tuple(Node(k, Opcode.MUL if k % 2 else Opcode.ADD) for k in range(size))
    edges = [Edge(k - 1, k, 0, distance=rng.choice([0, 0, 1, 2])) for k in range(1, size)]
    own = (Edge(k, k, 1, distance=rng.choice([1, 2, 3])) for k in range(size))
    edges += [edge for edge in own if rng.random() < 0.7]
    fabric = tiny_fabric(
        cols=2 + seed // 4 % 2,
        read_ports=2,
        max_stages=2 + seed // 8 % 2,
        contexts=4,
        routing=Routing(hops=0, holds=True, shared=True),
    )
    return DFG("kept", nodes, tuple(edges)), fabric


@pytest.fixture
def excluded(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The conflicts that were excluded."""
    found: list[object] = []
    exclude = solve.exclude
    monkeypatch.setattr(solve, "exclude", lambda *args: found.append(args) or exclude(*args))
    return found


@pytest.mark.parametrize("seed", [26, 44, 56, 60, 86, 116])
def test_cuts_elsewhere_lose_no_mapping(
    seed: int, excluded: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    dfg, fabric = _kept_long(300 + seed)
    ii = 3 + (300 + seed) // 16 % 2
    everywhere = map_dfg(dfg, fabric, "cpsat", ii=ii, workers=1)
    assert excluded
    monkeypatch.setattr(solve, "MOST_CUTS", 1)
    only_here = map_dfg(dfg, fabric, "cpsat", ii=ii, workers=1)
    assert (everywhere.status, everywhere.ii) == (only_here.status, only_here.ii)


def test_a_file_that_is_too_small_is_refuted_in_few_solver_runs(excluded: list[object]) -> None:
    """With one exclusion for each place and time it took 170, and seconds."""
    dfg, fabric = _kept_long(340)
    assert map_dfg(dfg, fabric, "cpsat", ii=4, workers=1).status == "infeasible"
    assert 0 < len(excluded) < 60

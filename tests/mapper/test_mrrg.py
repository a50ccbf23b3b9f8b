"""The MRRG of a fabric says what `docs/machine.md` says."""

from __future__ import annotations

import pytest
from tiny_fabrics import tiny_fabric

from vividc.arch import load
from vividc.arch.fabric import Routing
from vividc.mapper.resources.distances import FAR, hop_distances
from vividc.mapper.resources.mrrg import MRRG, NONE, build_mrrg


def _named(graph: MRRG, origin: int, target: int) -> list[tuple[str, int, int]]:
    return [
        (graph.resources[resource].kind, graph.resources[resource].index, when)
        for resource, when in graph.claims(origin, target)
    ]


def test_a_pair_of_pes_with_a_link_each_way() -> None:
    graph = build_mrrg(tiny_fabric(1, 2, registers=3, read_ports=2))
    assert graph.locations == 4
    assert [(r.kind, r.index, r.capacity) for r in graph.resources] == [
        ("link", 0, 1),
        ("link", 1, 1),
        ("registers", 0, 3),
        ("registers", 1, 3),
        ("read ports", 0, 2),
        ("read ports", 1, 2),
        ("write ports", 0, 1),
        ("write ports", 1, 1),
    ]
    assert graph.owner.tolist() == [1, 0, 0, 1]
    assert [graph.entries[pe] for pe in range(2)] == [[0, 2], [1, 3]]
    assert [graph.moves[at] for at in range(4)] == [[1, 3], [0, 2], [0, 2], [1, 3]]
    assert [graph.readers[at] for at in range(4)] == [[1], [0], [0], [1]]


def test_claims_of_moves() -> None:
    graph = build_mrrg(tiny_fabric(1, 2))
    assert _named(graph, NONE, 0) == [("link", 0, 1)]
    assert _named(graph, NONE, 2) == [("write ports", 0, 0), ("registers", 0, 1)]
    assert _named(graph, 2, 2) == [("registers", 0, 1)]
    assert _named(graph, 2, 0) == [("read ports", 0, 0), ("link", 0, 1)]
    assert _named(graph, 0, 3) == [("write ports", 1, 0), ("registers", 1, 1)]


def test_links_alone_where_there_are_no_registers() -> None:
    graph = build_mrrg(tiny_fabric(1, 3, registers=0, read_ports=0, write_ports=0))
    assert graph.locations == graph.links == 4
    assert graph.leaving.tolist() == [NONE] * 4
    assert graph.reach.tolist() == [[0, 0, 1], [0, 0, 0], [1, 0, 0]]


def _open_pair() -> MRRG:
    """Two PEs that read each other's held output registers; their files take results only."""
    return build_mrrg(
        tiny_fabric(
            1,
            2,
            registers=1,
            routing=Routing(hops=0, holds=True, shared=True, moves=True),
            written_by_fu=True,
        )
    )


def test_output_registers_are_places_of_their_own() -> None:
    graph = _open_pair()
    kinds = [(spot.kind, spot.index) for spot in graph.spots]
    assert kinds == [("out", 0), ("out", 1), ("out", 0), ("out", 1), ("reg", 0), ("reg", 1)]
    assert graph.fresh.tolist() == [0, 1]
    assert [graph.entries[pe] for pe in range(2)] == [[0, 4], [1, 5]]
    assert [graph.readers[at] for at in range(6)] == [[0, 1]] * 4 + [[0], [1]]
    assert [graph.sides[at] for at in range(6)] == [[4], [5], [], [], [], []]
    assert graph.aside.tolist() == [0, 0, 0, 0, 1, 1]
    assert graph.keeps.tolist() == [0, 0, 1, 1, 1, 1]
    assert [graph.moves[at] for at in range(6)] == [
        [0, 1, 2],
        [0, 1, 3],
        [0, 1, 2],
        [0, 1, 3],
        [0, 4],
        [1, 5],
    ]


def test_a_move_takes_the_fu_and_its_output_register() -> None:
    graph = _open_pair()
    assert _named(graph, 0, 1) == [("FU", 1, 0), ("output", 1, 1)]
    assert _named(graph, 0, 0) == [("FU", 0, 0), ("output", 0, 1)]
    assert _named(graph, 0, 2) == [("output", 0, 1)]
    assert _named(graph, 2, 2) == [("output", 0, 1)]
    assert _named(graph, 4, 0) == [("read ports", 0, 0), ("FU", 0, 0), ("output", 0, 1)]


def test_links_in_a_row_are_passed_in_one_cycle() -> None:
    graph = build_mrrg(tiny_fabric(1, 4, registers=0, routing=Routing(hops=2)))
    assert graph.links == graph.locations == 12
    assert [graph.spots[at].index for at in (0, 6)] == [0, 0]
    assert graph.aside.tolist() == [0] * 6 + [1] * 6
    assert graph.reach.tolist()[0] == [0, 0, 0, 1]
    assert graph.away[0].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize("name", ["openedge-4x4", "hycube-4x4", "adres-4x4"])
def test_words_reach_as_far_a_cycle_as_the_fabric_lets_them(name: str) -> None:
    fabric = load(name)
    cycles = build_mrrg(fabric).reach
    for row, hops in zip(cycles.tolist(), hop_distances(fabric), strict=True):
        if fabric.routing.shared:  # a neighbour reads the output register
            assert row == [max(hop - 1, 0) for hop in hops]
        else:
            assert row == [max(-(-hop // fabric.routing.hops) - 1, 0) for hop in hops]


@pytest.mark.parametrize("name", ["vivid-tile", "vivid-tile-unit"])
def test_a_word_needs_a_cycle_less_than_hops(name: str) -> None:
    fabric = load(name)
    cycles = build_mrrg(fabric).reach
    for row, hops in zip(cycles.tolist(), hop_distances(fabric), strict=True):
        assert row == [max(hop - 1, 0) for hop in hops]


def test_what_no_link_leads_to_is_out_of_reach() -> None:
    fabric = tiny_fabric(1, 3, links=((0, 1),))
    assert build_mrrg(fabric).reach.tolist() == [[0, 0, FAR], [FAR, 0, FAR], [FAR, FAR, 0]]

"""Tiny fabrics, one for each option of a fabric and for some together."""

from __future__ import annotations

from typing import Final

from tiny_fabrics import tiny_fabric

from vividc.arch.fabric import Fabric, Routing
from vividc.machine.opcodes import LatencyClass

_RING = ((0, 1), (1, 2), (2, 0))
_SLOW = {LatencyClass.IMUL: 2}
_SLOWER = {LatencyClass.IMUL: 3}
_BUSY = {LatencyClass.IMUL: 2, LatencyClass.INT: 2, LatencyClass.LOAD: 3}
_OPEN = Routing(hops=0, holds=True, shared=True, moves=True)

FABRICS: Final[dict[str, Fabric]] = {
    "openedge": tiny_fabric(
        1, 3, registers=1, max_stages=2, contexts=4, routing=_OPEN, written_by_fu=True
    ),
    "no registers": tiny_fabric(
        1, 2, registers=0, read_ports=0, write_ports=0, max_stages=2, contexts=4, routing=_OPEN
    ),
    "one-way ring": tiny_fabric(
        1,
        3,
        registers=1,
        links=_RING,
        max_stages=2,
        contexts=4,
        routing=_OPEN,
        written_by_fu=True,
        latencies=_SLOW,
    ),
    "hold": tiny_fabric(
        1, 2, registers=1, max_stages=2, contexts=4, routing=Routing(holds=True), latencies=_SLOW
    ),
    "shared": tiny_fabric(
        1, 3, registers=1, max_stages=2, contexts=4, routing=Routing(shared=True)
    ),
    "shared only": tiny_fabric(
        1,
        2,
        registers=1,
        max_stages=2,
        contexts=4,
        routing=Routing(hops=0, shared=True),
        latencies=_SLOW,
    ),
    "moves": tiny_fabric(
        1,
        2,
        registers=1,
        max_stages=2,
        contexts=4,
        routing=Routing(moves=True),
        written_by_fu=True,
    ),
    "two hops": tiny_fabric(
        1, 3, registers=1, max_stages=2, contexts=4, routing=Routing(hops=2), latencies=_SLOW
    ),
    "three hops round": tiny_fabric(
        1,
        3,
        registers=0,
        read_ports=0,
        write_ports=0,
        links=_RING,
        max_stages=2,
        contexts=4,
        routing=Routing(hops=3),
    ),
    "rotating": tiny_fabric(
        1, 2, registers=2, max_stages=3, contexts=4, rotating=True, latencies=_SLOWER
    ),
    "one rotating": tiny_fabric(
        1, 1, registers=3, max_stages=4, contexts=5, rotating=True, latencies=_SLOWER
    ),
    "busy": tiny_fabric(
        1, 2, registers=1, max_stages=2, contexts=6, occupancies=_BUSY, latencies=_SLOW
    ),
}

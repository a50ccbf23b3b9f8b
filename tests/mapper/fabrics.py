"""Tiny and odd fabrics built by hand."""

from __future__ import annotations

from collections.abc import Mapping

from vividc.arch.fabric import PE, Controller, Fabric, Link, Scratchpad
from vividc.machine.opcodes import LatencyClass

UNPLACED = frozenset({LatencyClass.SOURCE, LatencyClass.SINK})
EVERYTHING = frozenset(LatencyClass) - UNPLACED
NO_MEMORY = EVERYTHING - {LatencyClass.LOAD, LatencyClass.STORE}


def grid(  # noqa: PLR0913 - one keyword per number of a fabric
    rows: int,
    cols: int,
    *,
    latencies: Mapping[LatencyClass, int] | None = None,
    classes: Mapping[int, frozenset[LatencyClass]] | None = None,
    registers: int = 2,
    read_ports: int = 1,
    write_ports: int = 1,
    constants: int = 8,
    contexts: int = 16,
    control_latency: int = 1,
    max_stages: int = 8,
    links: bool = True,
) -> Fabric:
    """A mesh whose PEs run everything in one cycle, but for what the keywords change."""
    pes = tuple(
        PE(
            id=row * cols + col,
            row=row,
            col=col,
            classes=(classes or {}).get(row * cols + col, EVERYTHING),
            registers=registers,
            read_ports=read_ports,
            write_ports=write_ports,
            constants=constants,
        )
        for row in range(rows)
        for col in range(cols)
    )
    pairs = [(a.id, b.id) for a in pes for b in pes if abs(a.row - b.row) + abs(a.col - b.col) == 1]
    cycles = dict.fromkeys(EVERYTHING, 1) | dict.fromkeys(UNPLACED, 0) | dict(latencies or {})
    return Fabric(
        name=f"grid-{rows}x{cols}",
        rows=rows,
        cols=cols,
        pes=pes,
        links=tuple(Link(i, a, b) for i, (a, b) in enumerate(pairs if links else [])),
        latencies=cycles,
        scratchpad=Scratchpad(1024, 4),
        controller=Controller(contexts, control_latency, 1, max_stages),
        clock_ghz=1.0,
    )

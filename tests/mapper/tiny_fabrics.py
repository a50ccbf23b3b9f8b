"""Fabrics of a few PEs, built by hand so that tests of legality depend on no loader."""

from __future__ import annotations

from vividc.arch.fabric import PE, Controller, Fabric, Link, Routing, Scratchpad
from vividc.machine.opcodes import LatencyClass

_COMPUTE = frozenset(LatencyClass) - {LatencyClass.SOURCE, LatencyClass.SINK}
_MEMORY = frozenset({LatencyClass.LOAD, LatencyClass.STORE})


def tiny_fabric(  # noqa: PLR0913 - one keyword per property of a fabric
    rows: int = 1,
    cols: int = 2,
    *,
    registers: int = 2,
    read_ports: int = 1,
    write_ports: int = 1,
    constants: int = 8,
    latencies: dict[LatencyClass, int] | None = None,
    memory: frozenset[int] | None = None,
    max_stages: int = 4,
    contexts: int = 256,
    links: tuple[tuple[int, int], ...] | None = None,
    routing: Routing | None = None,
    occupancies: dict[LatencyClass, int] | None = None,
    rotating: bool = False,
    written_by_fu: bool = False,
) -> Fabric:
    """A mesh of latency 1 but for `latencies`; `memory` names the PEs with a load/store unit."""
    pairs = mesh_links(rows, cols) if links is None else links
    cycles = dict.fromkeys(_COMPUTE, 1) | (latencies or {})
    cycles |= {LatencyClass.SOURCE: 0, LatencyClass.SINK: 0}
    pes = tuple(
        PE(
            id=pe,
            row=pe // cols,
            col=pe % cols,
            classes=_COMPUTE if memory is None or pe in memory else _COMPUTE - _MEMORY,
            registers=registers,
            read_ports=read_ports,
            write_ports=write_ports,
            constants=constants,
            rotating=rotating,
            written_by_fu=written_by_fu,
        )
        for pe in range(rows * cols)
    )
    return Fabric(
        name=f"tiny-{rows}x{cols}",
        rows=rows,
        cols=cols,
        pes=pes,
        links=tuple(Link(index, src, dst) for index, (src, dst) in enumerate(pairs)),
        latencies=cycles,
        scratchpad=Scratchpad(1024, 2),
        controller=Controller(contexts, control_latency=1, switch_cycles=1, max_stages=max_stages),
        clock_ghz=1.0,
        routing=routing or Routing(),
        occupancies=occupancies or {},
    )


def mesh_links(rows: int, cols: int) -> tuple[tuple[int, int], ...]:
    """Both ways between neighbours."""
    pairs = []
    for row in range(rows):
        for col in range(cols):
            here = row * cols + col
            if col + 1 < cols:
                pairs += [(here, here + 1), (here + 1, here)]
            if row + 1 < rows:
                pairs += [(here, here + cols), (here + cols, here)]
    return tuple(pairs)

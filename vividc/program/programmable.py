"""Which fabrics programs can be made for."""

from __future__ import annotations

from collections.abc import Iterator

from vividc.arch.fabric import Fabric, Routing
from vividc.errors import ArchError


def demand_programmable(fabric: Fabric) -> None:
    """Refuse a fabric with options that the configuration word has no fields for.

    Raises
    ------
    ArchError
        With each such option as its YAML has it.
    """
    if fabric.is_plain:
        return
    options = ", ".join(_beyond_words(fabric))
    raise ArchError(
        f"programs cannot be made for fabric {fabric.name}: its configuration word has no fields "
        f"for {options}",
        loc=fabric.name,
        hint="graphs can be mapped to it (`vividc map`); to compile, choose a fabric without these "
        "options, such as vivid-tile or mesh-4x4",
    )


def _beyond_words(fabric: Fabric) -> Iterator[str]:
    routing, default = fabric.routing, Routing()
    if routing.hops != default.hops:
        yield f"`routing.hops: {routing.hops}`"
    if routing.holds:
        yield "`routing.output: hold`"
    if routing.shared:
        yield "`routing.output_readers: neighbours`"
    if routing.moves:
        yield "`routing.moves: true`"
    if any(pe.rotating for pe in fabric.pes):
        yield "`register_file.rotating: true`"
    if any(pe.written_by_fu for pe in fabric.pes):
        yield "`register_file.written_by: fu`"
    for latency_class, cycles in fabric.occupancies.items():
        if cycles > 1:
            yield f"`occupancy.{latency_class.value}: {cycles}`"

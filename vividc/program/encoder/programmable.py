"""Which fabrics can be programmed."""

from __future__ import annotations

from collections.abc import Iterator

from vividc.arch.fabric import Fabric
from vividc.errors import ArchError


def demand_programmable(fabric: Fabric) -> None:
    """Refuse a fabric with options that the configuration word has no fields for.

    Raises
    ------
    ArchError
        With each such option as its YAML has it.
    """
    options = ", ".join(_beyond_words(fabric))
    if not options:
        return
    raise ArchError(
        f"programs cannot be made for fabric {fabric.name}: its configuration word has no fields "
        f"for {options}",
        loc=fabric.name,
        hint="graphs can be mapped to it (`vividc map`); to compile, choose a fabric without these "
        "options, such as vivid-tile or mesh-4x4",
    )


def _beyond_words(fabric: Fabric) -> Iterator[str]:
    routing = fabric.routing
    if not routing.hops:
        yield "`routing.hops: 0`"
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

"""Mirror images of a tile: a program that is legal on one is legal, mirrored, on the other."""

from __future__ import annotations

from dataclasses import replace

import yaml

from vividc.arch.accelerator import Orientation
from vividc.arch.fabric import Fabric
from vividc.arch.yaml.load import load_text
from vividc.arch.yaml.schema import indices
from vividc.errors import ArchError

_MIRRORED: dict[Orientation, tuple[bool, bool]] = {
    "nw": (False, False),
    "ne": (False, True),
    "sw": (True, False),
    "se": (True, True),
}
"""Whether rows and columns are mirrored to get each orientation from the north-west one."""


def reflected(fabric: Fabric, orientation: Orientation) -> Fabric:
    """`fabric`, seen as a north-west tile, as it stands in another corner of its cluster."""
    rows, cols = _MIRRORED[orientation]
    if not (rows or cols):
        return fabric
    data = yaml.safe_load(fabric.source)
    for override in data.get("overrides", []):
        at = override["at"]
        if rows:
            at["rows"] = _mirrored(at["rows"], fabric.rows)
        if cols:
            at["cols"] = _mirrored(at["cols"], fabric.cols)
    links = data.get("links", {})
    for link in (*links.get("extra", ()), *links.get("removed", ())):
        for end in ("from", "to"):
            row, col = link[end]
            link[end] = [
                fabric.rows - 1 - row if rows else row,
                fabric.cols - 1 - col if cols else col,
            ]
    data["name"] = f"{fabric.name[:60]}-{orientation}"
    mirror = load_text(yaml.safe_dump(data, sort_keys=False), data["name"])
    places = reflection(fabric, orientation)
    if not is_isomorphism(fabric, mirror, places):
        raise ArchError(
            f"the fabric {fabric.name} has no mirror image for the {orientation} corner",
            hint="give a fabric whose topology is a mesh, a torus or a king's mesh",
        )
    return mirror


def reflection(fabric: Fabric, orientation: Orientation) -> tuple[int, ...]:
    """For each PE of `fabric` the PE that it becomes in `reflected(fabric, orientation)`."""
    rows, cols = _MIRRORED[orientation]
    return tuple(
        (fabric.rows - 1 - pe.row if rows else pe.row) * fabric.cols
        + (fabric.cols - 1 - pe.col if cols else pe.col)
        for pe in fabric.pes
    )


def is_isomorphism(fabric: Fabric, other: Fabric, places: tuple[int, ...]) -> bool:
    """Whether PE `p` of `fabric` and PE `places[p]` of `other` have the same parts and links, and
    the tiles the same memory, latencies and controller: whatever runs on one then runs on the
    other.
    """
    if len(fabric.pes) != len(other.pes) or sorted(places) != list(range(len(other.pes))):
        return False
    here = {pe.id: replace(pe, id=0, row=0, col=0) for pe in fabric.pes}
    there = {pe.id: replace(pe, id=0, row=0, col=0) for pe in other.pes}
    if any(here[pe] != there[places[pe]] for pe in here):
        return False
    moved = sorted((places[link.src], places[link.dst]) for link in fabric.links)
    if moved != sorted((link.src, link.dst) for link in other.links):
        return False
    return (
        fabric.latencies == other.latencies
        and fabric.scratchpad == other.scratchpad
        and fabric.controller == other.controller
        and fabric.routing == other.routing
        and fabric.occupancies == other.occupancies
        and fabric.clock_ghz == other.clock_ghz
    )


def _mirrored(spec: int | str | list[int | str], count: int) -> str | list[int]:
    if spec == "all":
        return "all"
    return sorted(count - 1 - index for index in indices(spec, count))

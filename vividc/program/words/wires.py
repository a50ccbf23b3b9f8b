"""Words that pass several links in one cycle: which source finally drives each link."""

from __future__ import annotations

from collections.abc import Sequence

from vividc.arch.fabric import Fabric
from vividc.errors import BundleError
from vividc.program.words.entry import Entry, Sel, Select


def driver(
    fabric: Fabric, entries: Sequence[Entry], pe: int, select: Select
) -> tuple[int, Select, int]:
    """Follow a link's selection through links of the same cycle to a source that is not a link.

    Parameters
    ----------
    entries
        Of one context, by PE.
    pe, select
        A PE and what drives one of its outgoing links.

    Returns
    -------
    tuple
        The PE and the selection that drive the first link, and how many links the word passes. In
        a circle of links, more than the fabric permits, and no selection.
    """
    links = 1
    while select.kind is Sel.WIRE:
        if links >= fabric.routing.hops:
            return pe, Select(Sel.NONE), links + 1
        link = fabric.links_to[pe][select.index]
        pe, links = link.src, links + 1
        select = entries[pe].links[fabric.links_from[pe].index(link)]
    return pe, select, links


def check_wires(fabric: Fabric, entries: Sequence[Entry], context: int) -> None:
    """Refuse a context in which a word would pass more links than a cycle has time for.

    Raises
    ------
    BundleError
        With the first PE that asks for it.
    """
    for pe, entry in enumerate(entries):
        for select in entry.links:
            if driver(fabric, entries, pe, select)[2] > fabric.routing.hops:
                reason = f"context {context} passes a word over more than {fabric.routing.hops}"
                raise BundleError(
                    f"{reason} links in a cycle, at PE {pe}",
                    hint="compile the kernel again for this fabric",
                )

"""Items of a report: a count, a cost each, and the source of the figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal, TypedDict

from vividc.arch.cost.schema import Kind
from vividc.arch.cost.tables import Cost

Part = Literal["pe_array", "sram", "control", "configuration", "dram"]
"""As in the paper's Figure 6; "configuration": memory beyond the paper's; "dram": off the chip."""

ON_CHIP: Final[tuple[Part, ...]] = ("pe_array", "sram", "control", "configuration")


class Item(TypedDict):
    """`count` things at `each` are `total` (pJ or um2). `kind`: what the figure is worth."""

    part: Part
    name: str
    count: float
    each: float
    total: float
    kind: Kind
    source: str


def item(part: Part, name: str, count: float, cost: Cost, factor: float = 1.0) -> Item:
    """An item; `factor` scales the figure to another node."""
    each = cost.value * factor
    return Item(
        part=part,
        name=name,
        count=count,
        each=each,
        total=count * each,
        kind=cost.kind,
        source=cost.source,
    )


def by_part(items: Sequence[Item]) -> dict[str, float]:
    """Totals of the parts, in order of appearance."""
    totals: dict[str, float] = {}
    for one in items:
        totals[one["part"]] = totals.get(one["part"], 0.0) + one["total"]
    return totals

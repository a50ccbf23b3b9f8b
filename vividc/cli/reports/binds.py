"""What binds a region as data: the bound with its operations and edges, or the search."""

from __future__ import annotations

from vividc.dfg import DFG
from vividc.mapper.mapping import Bound
from vividc.mapper.report.explain import binding
from vividc.program.tables import RegionReport


def what_binds(region: RegionReport) -> dict[str, object] | None:
    """Return what keeps the II from being smaller; None: nothing was refuted, or it is not kept.

    `what`: in words. `bound`: its name, with `operations` and `edges` of the graph that it follows
    from; None where a search refuted the II `refuted_ii`.
    """
    result = region.result if region.design else None
    cause = None if result is None else binding(result)
    if result is None or cause is None:
        return None
    found = next((bound for bound in result.bounds if bound.name == cause.bound), None)
    body: dict[str, object] = {
        "what": cause.what,
        "bound": cause.bound,
        "refuted_ii": cause.refuted_ii,
    }
    return body if found is None else {**body, **_parts(found, region.dfg)}


def _parts(bound: Bound, graph: DFG) -> dict[str, object]:
    nodes = [graph.by_id[number] for number in bound.nodes]
    edges = [graph.edges[index] for index in bound.edges]
    return {
        "operations": [
            {
                "id": node.id,
                "op": node.op.value,
                "name": node.name,
                "loc": None if node.loc is None else str(node.loc),
            }
            for node in nodes
        ],
        "edges": [
            {"src": edge.src, "dst": edge.dst, "distance": edge.distance, "kind": edge.kind.value}
            for edge in edges
        ],
        "distance": bound.distance,
    }

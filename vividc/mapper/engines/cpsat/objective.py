"""What a good schedule minimises before anything is placed: the cost of carrying words."""

from __future__ import annotations

from collections.abc import Mapping

from ortools.sat.python.cp_model import CpModel, IntVar, LinearExpr

from vividc.mapper.resources.dependences import Dependence


def carrying_cost(
    model: CpModel,
    lives: Mapping[int, tuple[Dependence, LinearExpr]],
    weights: Mapping[int, int],
    easy_life: int,
    longest: int,
) -> None:
    """Minimise, over routed edges, the life beyond `easy_life` plus the weighted shortfall below
    it.

    A word of life n (cycles from result to read) reaches PEs n + 1 hops away, so a short life ties
    the two ends close together; a long one occupies a link or register in each of its cycles.
    """
    terms: list[IntVar] = []
    factors: list[int] = []
    ends: dict[int, IntVar] = {}
    for index, (edge, life) in lives.items():
        if edge.src == edge.dst:
            continue
        short = model.new_int_var(0, easy_life, f"short[{index}]")
        model.add(short >= easy_life - life)
        terms.append(short)
        factors.append(weights[index])
        end = ends.get(edge.src)
        if end is None:
            end = ends[edge.src] = model.new_int_var(0, longest, f"life[{edge.src}]")
            terms.append(end)
            factors.append(2)
        model.add(end >= life - easy_life)
    model.minimize(LinearExpr.weighted_sum(terms, factors))

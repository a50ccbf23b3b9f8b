"""The constraint families of routes through output registers, moves, and several links a cycle.

Notation as in `constraints`; O[v,p,t] = output: word v is in the output register of p; M[v,p,t] =
move: the FU of p moves v in cycle t, so that O[v,p,t+1]. D[v,k,t,h]: v is driven onto link k as
the h-th link of the cycle.
"""

from __future__ import annotations

from ortools.sat.python.cp_model import CpModel, IntVar

from vividc.mapper.engines.cpsat.problem import Prepared
from vividc.mapper.engines.cpsat.variables import Variables
from vividc.mapper.engines.cpsat.ways import at_most, grouped, readable, results, supply


def outputs_keep_words(model: CpModel, problem: Prepared, v: Variables) -> None:
    """O[v,p,t] => x[v,p,t-lat] or M[v,p,t-1], or O[v,p,t-1] where outputs hold."""
    for (word, pe, time), literal in v.output.items():
        ways = results(problem, v, word, pe, time)
        before = (word, pe, problem.wrap(time - 1))
        if problem.fabric.routing.holds and before in v.output:
            ways.append(v.output[before])
        model.add_bool_or([*ways, ~literal])


def results_enter_outputs(model: CpModel, problem: Prepared, v: Variables) -> None:
    """x[v,p,t] => O[v,p,t+lat]; M[v,p,t] => O[v,p,t+1]."""
    for (word, pe, time), literal in v.start.items():
        key = (word, pe, problem.wrap(time + problem.latency[word]))
        if key in v.output:
            model.add_implication(literal, v.output[key])
    for (word, pe, time), literal in v.move.items():
        model.add_implication(literal, v.output[word, pe, problem.wrap(time + 1)])


def moves_find_the_word(model: CpModel, problem: Prepared, v: Variables) -> None:
    """M[v,p,t] => L[v,k,t] of a link k into p or R[v,p,t] or O[v,q,t] that p reads."""
    for (word, pe, time), literal in v.move.items():
        model.add_bool_or([*readable(problem, v, word, pe, time), ~literal])


def one_word_per_output_and_slot(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over words v and t = slot of O[v,p,t] <= 1; an operation whose word nobody reads counts
    as x[v,p,t-lat].
    """
    if not problem.fabric.routing.open_outputs:
        return
    users = [((pe, time % problem.ii), literal) for (_, pe, time), literal in v.output.items()]
    operations = {node.id for node in problem.nodes if node.uses_fu}
    for (node, pe, time), literal in v.start.items():
        ready = time + problem.latency[node]
        if node in operations and (node, pe, problem.wrap(ready)) not in v.output:
            users.append(((pe, ready % problem.ii), literal))
    at_most(model, grouped(users), 1)


def words_pass_links(model: CpModel, problem: Prepared, v: Variables) -> None:
    """L[v,k,t] => D[v,k,t,1] or ... or D[v,k,t,N] => L[v,k,t]; D[v,k,t,1] => what may drive a link
    (`links_are_driven`); D[v,k,t,h] => D[v,k',t,h-1] of a link k' into the PE that k leaves.

    The layers keep words from driving each other in a circle.
    """
    links = problem.fabric.links
    layers = range(1, problem.fabric.routing.hops + 1)
    for (word, link, time), literal in v.link.items():
        if not v.hop:
            return
        depths = [v.hop[word, link, time, depth] for depth in layers]
        model.add_bool_or([*depths, ~literal])
        sources: list[IntVar] = supply(problem, v, word, links[link].src, time)
        for depth, driven in zip(layers, depths, strict=True):
            model.add_implication(driven, literal)
            model.add_bool_or([*sources, ~driven])
            keys = ((word, k.id, time, depth) for k in problem.fabric.links_to[links[link].src])
            sources = [v.hop[key] for key in keys if key in v.hop]

"""Matrices whose rows should lie further apart than they are long, so that fewer accesses meet in a
bank: 24 columns on 8 banks are a bank each, 25 are not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from vividc.compiler.planning.estimate import Estimator
from vividc.host import watch
from vividc.mapper.resources.banks import Traffic, words_of
from vividc.program.encoder.banks import best_pitches
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.subscripts import may_be_spaced

PAYS = 0.005
"""Share of a run's cycles that a matrix has to save: its pitch is one more word that loops read."""


def spaced(function: Function, estimator: Estimator, hints: Mapping[str, float]) -> Function:
    """The same prepared function, with the matrices spaced for which it is expected to pay, or all
    of words that may be (blocks of a nest have rows of words), as the estimator says.
    """
    matrices = may_be_spaced(function) if estimator.spaces != "none" else ()
    per_word = {param.name: param.per_word for param in function.params}
    if estimator.spaces == "all":
        words = frozenset(matrix for matrix in matrices if per_word[matrix] == 1)
        return replace(function, spaced=words) if words else function
    if not matrices:
        return function
    with watch.aside():
        made = replace(function, spaced=frozenset(matrices))
        kernel = estimator.built(made)
        iterations = estimator.iterations(made, kernel, hints)
        shapes = [estimator.shape(region) for region in kernel.regions]
        total = estimator.priced(made, kernel, shapes, hints).cycles
        pad = estimator.fabric.scratchpad
        loops, straight = (
            [
                Traffic.of(estimator.optimized(region.dfg), pad, shape.ii, None, runs)
                for region, shape, runs in zip(kernel.regions, shapes, iterations, strict=True)
                if region.kind == kind and shape.is_possible
            ]
            for kind in ("loop", "straight")
        )
        pitches = best_pitches(loops, {matrix: per_word[matrix] for matrix in matrices})
        all_spaced = _stalls(loops, straight, pitches)
        pays = frozenset(
            matrix
            for matrix in matrices
            if _stalls(loops, straight, {name: n for name, n in pitches.items() if name != matrix})
            > all_spaced + PAYS * total
        )
    return replace(function, spaced=pays) if pays else function


def _stalls(loops: list[Traffic], straight: list[Traffic], pitches: Mapping[str, int]) -> float:
    known = words_of({}, pitches)
    waits = sum(one.weight * one.unsure(known) for one in straight)
    return waits + sum(one.weight * one.stalls(known) for one in loops)

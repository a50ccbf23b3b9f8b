"""Which bank each array should start in, and how far apart its rows should lie, so that accesses of
one cycle meet in few banks.

In a modulo schedule, an access of stage s sees the iteration index s less than one of stage 0 in
the same cycle. Accesses that step through their arrays alike therefore stay a fixed number of banks
apart, and the start of the arrays decides it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from random import Random
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.dfg.regions import Kernel
from vividc.machine.words import WORD_BYTES
from vividc.mapper.mapping import Mapping as RegionMapping
from vividc.mapper.resources.banks import NOTHING, Traffic, Words, words_of
from vividc.ssa.ir import pitch_of

_LOOP: Final = 16.0
"""Iterations of a loop for each run of straight code, where nothing is known of either."""

TRIES: Final = 8
"""Layouts from which the search for the last one begins, while it leaves stalls."""

_GAIN: Final = 0.2
"""Share of the stalls that a start has to save to be taken instead of one before it."""

_NOISE: Final = 0.05
"""The same of a pitch."""

_BUSY: Final = 0.002
"""Share of all accesses that a region makes at least to count when the layout is improved."""

_FEW: Final = 0.01
"""Share of the cycles up to which stalls are no reason to look for another layout."""

_ROUNDS: Final = 3
"""Times that all pitches and starts are chosen anew."""


def traffic_of(
    kernel: Kernel,
    fabric: Fabric,
    mappings: Mapping[int, RegionMapping],
    iterations: Sequence[float] = (),
) -> tuple[Traffic, ...]:
    """The accesses of each mapped region, in the cycles in which they start.

    `iterations`: how many of each region a run is expected to have; none: not known.
    """
    runs = iterations or [_LOOP if region.kind == "loop" else 1.0 for region in kernel.regions]
    return tuple(
        Traffic.of(
            region.dfg,
            fabric.scratchpad,
            mappings[index].ii,
            {node: place.time for node, place in mappings[index].places.items()},
            runs[index],
        )
        for index, region in enumerate(kernel.regions)
    )


def choose_layout(
    kernel: Kernel, traffic: Sequence[Traffic], tries: int = TRIES
) -> tuple[dict[str, int], dict[str, int]]:
    """How far apart the rows of each spaced matrix should lie, in elements modulo those that all
    banks hold, and the start bank of each array parameter and each array of the kernel's own, by
    name; `tries`: from how many layouts the search begins.
    """
    spaced = {param.name: param.per_word for param in kernel.params if param.name in kernel.spaced}
    arrays = [param.name for param in kernel.params if param.ndim]
    own = [local.name for local in kernel.locals]
    return best_layout(traffic, spaced, [*arrays, *own], tries)


def best_pitches(traffic: Sequence[Traffic], matrices: Mapping[str, int]) -> dict[str, int]:
    """How far apart rows should lie, in elements modulo those that all banks hold, for few stalls:
    one matrix after the other, the others' as chosen, or any.

    `matrices`: how many elements of each are a word; rows are whole words apart.
    """
    banks = traffic[0].banks if traffic else 1
    known: dict[str, int] = {}
    for matrix, per_word in matrices.items():
        word = pitch_of(matrix, 1).key
        values = (per_word * (n % banks) for n in range(1, banks + 1))
        known[word] = _best_value(traffic, (matrix, word), values, known, _NOISE)
    return {matrix: known[pitch_of(matrix, 1).key] for matrix in matrices}


def best_starts(
    traffic: Sequence[Traffic], arrays: Sequence[str], pitches: Mapping[str, int] = NOTHING
) -> dict[str, int]:
    """The bank that each array should start in, for few stalls; `pitches` of matrices are known.

    One after the other, each where fewest are expected of the arrays so far; in equal cases, one
    bank behind the array before.
    """
    banks = traffic[0].banks if traffic else 1
    known = words_of({}, pitches)
    for number, array in enumerate(arrays):
        word, among = f"&{array}", arrays[: number + 1]
        values = (WORD_BYTES * ((number + more) % banks) for more in range(banks))
        known[word] = _best_value(traffic, (array, word), values, known, _GAIN, among)
    return {array: known[f"&{array}"] // WORD_BYTES for array in arrays}


def _best_value(
    traffic: Sequence[Traffic],
    of: tuple[str, str],
    values: Iterable[int],
    known: Words,
    gain: float,
    among: Collection[str] | None = None,
) -> int:
    """The first of the values of an array's word with about the fewest stalls: one behind it must
    save this share of them to be taken instead. The rest is not tried once nothing can.

    Parameters
    ----------
    of
        The array, and the word.
    known
        Other words, and what this one was before, if it was known.
    among
        Accesses to these arrays count; None: all do.
    """
    array, word = of
    touched = [one for one in traffic if one.touches(array)]
    starts = {
        number: one.stalls_by_start(array, known, among)
        for number, one in enumerate(touched)
        if word == f"&{array}" and one.times is not None
    }
    kept, least, floor = 0, math.inf, _floor(touched, array, known, among)
    for value in values:
        here, bank = {**known, word: value}, value // WORD_BYTES
        stalls = sum(
            one.weight * (starts[number][bank] if number in starts else one.stalls(here, among))
            for number, one in enumerate(touched)
        )
        if stalls < (1.0 - gain) * least:
            kept, least = value, stalls
        if (1.0 - gain) * least <= floor:
            break
    return kept


Layout = tuple[dict[str, int], dict[str, int]]
"""Pitches of matrices, in elements modulo those that all banks hold, and the banks in which arrays
start.
"""


def best_layout(
    traffic: Sequence[Traffic],
    matrices: Mapping[str, int],
    arrays: Sequence[str],
    tries: int = 1,
) -> Layout:
    """Pitches of the matrices as `best_pitches` and starts of the arrays as `best_starts`, each
    then chosen anew as all others are, with all accesses of all regions, until none is better.

    While that leaves stalls, the same begins so many times in all, from other ones that are drawn:
    of gemm 80 cycles are expected of the first and 24 of a later one.
    """
    pitches = best_pitches(traffic, matrices)
    best = _improved(traffic, matrices, (pitches, best_starts(traffic, arrays, pitches)))
    least, few = _stalls_with(traffic, best), _FEW * sum(one.weight * one.ii for one in traffic)
    banks = traffic[0].banks if traffic else 1
    for turn in range(1, tries):
        if least <= few:
            break
        draw = Random(turn)
        drawn = (
            {name: per_word * draw.randrange(banks) for name, per_word in matrices.items()},
            {name: draw.randrange(banks) for name in best[1]},
        )
        layout = _improved(traffic, matrices, drawn)
        stalls = _stalls_with(traffic, layout)
        if stalls < (1.0 - _NOISE) * least:
            best, least = layout, stalls
    return best


def _stalls_with(traffic: Sequence[Traffic], layout: Layout) -> float:
    pitches, starts = layout
    known = words_of(starts, pitches)
    return sum(one.weight * one.stalls(known) for one in traffic)


def _floor(
    traffic: Sequence[Traffic], array: str, known: Words, among: Collection[str] | None = None
) -> float:
    """What stalls are at least, wherever an array lies: those without its accesses, and none where
    accesses are spread anew for each place of it; `among`: the other arrays, if not all.
    """
    fixed = [one for one in traffic if not one.spread]
    return sum(one.weight * one.stalls(known, one.arrays(among) - {array}) for one in fixed)


def _improved(traffic: Sequence[Traffic], matrices: Mapping[str, int], layout: Layout) -> Layout:
    pitches, starts = (dict(part) for part in layout)
    banks = traffic[0].banks if traffic else 1
    total = sum(one.weight * len(one.accesses) for one in traffic)
    busy = [one for one in traffic if one.weight * len(one.accesses) > _BUSY * total]
    for _ in range(_ROUNDS):
        before = dict(pitches), dict(starts)
        for name, chosen in [(name, group) for group in (pitches, starts) for name in group]:
            is_pitch = chosen is pitches
            word = pitch_of(name, 1).key if is_pitch else f"&{name}"
            step, unit = (matrices[name], 1) if is_pitch else (1, WORD_BYTES)
            values = (unit * ((chosen[name] + step * n) % (step * banks)) for n in range(banks))
            known = words_of(starts, pitches)
            chosen[name] = _best_value(busy, (name, word), values, known, _NOISE) // unit
        if (pitches, starts) == before:
            break
    return pitches, starts

"""Programs with a few fields changed at random: most break a rule of the machine, or nearly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from random import Random

import numpy as np

from vividc.program import Program, RegionRow, word_layout
from vividc.program.words.layout import WORD_BITS, Field


def mutated(program: Program, random: Random, contexts: Sequence[int] = ()) -> Program:
    """The program with one to three configuration fields changed, and sometimes a table row.

    Parameters
    ----------
    contexts
        Those that may be changed; none: all.
    """
    words = program.words.copy()
    contexts = contexts or range(words.shape[0])
    for _ in range(random.choice([1, 1, 2, 3])):
        context, pe = random.choice(contexts), random.randrange(words.shape[1])
        field = random.choice(word_layout(program.fabric).fields)
        words[context, pe] = _changed(words[context, pe], field, random)
    table = list(program.table)
    if random.random() < 0.15:
        index = random.randrange(len(table))
        table[index] = _changed_row(table[index], len(table), random)
    return replace(program, words=words, table=tuple(table))


def field_of(program: Program, context: int, pe: int, name: str) -> int:
    """One field of one entry."""
    return _held(program.words[context, pe], _named(program, name))


def with_field(program: Program, context: int, pe: int, name: str, value: int) -> Program:
    """The program with one field of one entry changed."""
    field = _named(program, name)
    words = program.words.copy()
    words[context, pe] = _with(words[context, pe], field, value)
    return replace(program, words=words)


def _named(program: Program, name: str) -> Field:
    return next(field for field in word_layout(program.fabric).fields if field.name == name)


def _changed(words: np.ndarray, field: Field, random: Random) -> list[int]:
    new = random.randrange(field.limit)
    if random.random() < 0.3:
        new = _held(words, field) ^ 1 << random.randrange(field.width)
    return _with(words, field, new)


def _held(words: np.ndarray, field: Field) -> int:
    bits = sum(int(word) << WORD_BITS * k for k, word in enumerate(words))
    return bits >> field.offset & field.limit - 1


def _with(words: np.ndarray, field: Field, new: int) -> list[int]:
    bits = sum(int(word) << WORD_BITS * k for k, word in enumerate(words))
    bits += (new - _held(words, field)) << field.offset
    return [bits >> WORD_BITS * k & 0xFFFFFFFF for k in range(len(words))]


def _changed_row(row: RegionRow, rows: int, random: Random) -> RegionRow:
    kind = random.randrange(5)
    if kind == 0 and row.kind == "loop":
        return replace(row, span=max(1, row.span + random.randrange(-3, 4)))
    if kind == 1 and row.kind == "loop" and row.has_exit:
        return replace(row, counted=not row.counted)
    if kind == 3 and row.drain:
        return replace(row, drain=max(0, row.drain + random.randrange(-2, 3)))
    if kind == 4 and row.fill:
        changed = {"fill": random.randrange(-2, 3), "stages": random.randrange(-2, 2)}
        return replace(row, **{n: max(0, getattr(row, n) + by) for n, by in changed.items()})
    if kind == 2:
        return replace(row, next=random.choice([None, *range(rows)]))
    return row

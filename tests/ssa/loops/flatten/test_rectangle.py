"""Rectangular nests: what is computed before them, and the counted loop that they become."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, loop_at
from vividc.ssa.ir import Function, Input, Ref, Value
from vividc.ssa.loops.flatten.flatten import flatten
from vividc.ssa.loops.flatten.rectangle import rectangle


def run(function: Function) -> object:
    """The function with the counts computed, what is found, and the flattened function."""
    made, found = rectangle(function, loop_at(function, "b1"), loop_at(function, "b3"))
    if found is None:
        return "no rectangle"
    indices = (f"index {s} * iteration + {_text(b)}" for s, b in found.indices.values())
    flat = flatten(function, "b1")
    return made, f"total {_text(found.total)}, runs {_text(found.runs)}", *indices, flat


def _text(value: Value) -> str:
    if isinstance(value, Ref):
        return "%"
    return value.key if isinstance(value, Input) else str(value.word)


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)

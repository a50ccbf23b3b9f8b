"""Analyses of a function are made once for it, and go with it."""

import gc
import weakref
from dataclasses import replace

from tests.programs import Assign, If, lower
from vividc.host.once import once_each
from vividc.ssa.flow import block_graph, find_loops, flow_of, pipelined_loops, predecessors
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.normalize import normalize

_CHOICE = If(0, 1, (Assign(1, "add", 0, 2, None),), ())


def test_an_analysis_is_made_once_for_a_function_and_anew_for_its_copy() -> None:
    calls: list[str] = []

    @once_each
    def analysis(function: Function) -> list[str]:
        calls.append(function.name)
        return []

    function = lower([_CHOICE])
    assert analysis(function) is analysis(function)
    assert analysis(replace(function)) is not analysis(function)
    assert len(calls) == 2
    for once in (find_loops, pipelined_loops, predecessors):
        assert once(function) is once(function)


def test_an_analysis_of_a_part_is_made_once_for_each() -> None:
    calls: list[str] = []

    @once_each
    def analysis(function: Function, part: str) -> str:
        calls.append(part)
        return f"{function.name} {part}"

    function = lower([_CHOICE])
    assert {analysis(function, part) for part in "aba"} == {
        f"{function.name} a",
        f"{function.name} b",
    }
    assert calls == ["a", "b"]


def test_what_is_kept_does_not_keep_the_function() -> None:
    function = lower([_CHOICE])
    find_loops(function), predecessors(function)
    gone = weakref.ref(function)
    del function
    gc.collect()
    assert gone() is None


def test_a_normalised_function_is_normalised_to_the_same_object() -> None:
    """So that what is known of it needs not be found out again."""
    function = normalize(lower([_CHOICE]))
    assert normalize(function) is function


def test_functions_with_the_same_control_flow_share_what_follows_from_it() -> None:
    function = normalize(lower([_CHOICE]))
    first = function.blocks[0]
    computes = replace(function, blocks=(replace(first, instrs=()), *function.blocks[1:]))
    assert flow_of(computes).idom is flow_of(function).idom
    assert find_loops(computes) is find_loops(function)


def test_functions_with_other_control_flow_share_nothing() -> None:
    function = normalize(lower([_CHOICE]))
    first, *others = function.blocks
    branch = first.branch
    turned = replace(branch, target=branch.otherwise, otherwise=branch.target)
    other = replace(function, blocks=(replace(first, branch=turned), *others))
    reordered = replace(function, blocks=(first, *reversed(others)))
    for changed in (other, reordered):
        assert predecessors(changed) is not predecessors(function)
    assert flow_of(other).successors[first.name] == tuple(reversed(branch.successors))
    assert list(predecessors(reordered)) == [block.name for block in reordered.blocks]


def test_few_control_flows_are_kept() -> None:
    function = normalize(lower([_CHOICE]))
    gone = weakref.ref(block_graph(function))
    del function
    for number in range(2, 12):
        find_loops(lower([_CHOICE] * number))
    gc.collect()
    assert gone() is None

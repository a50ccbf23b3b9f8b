"""Graphs of several threads of the blend: one splat, one exit, a state each."""

from __future__ import annotations

import pytest

from benchmarks.threads import blend, threads
from vividc.dfg.check import check
from vividc.dfg.ir import Control
from vividc.machine.opcodes import Opcode


@pytest.mark.parametrize("count", [1, 4, 8])
def test_threads_share_a_splat_and_have_one_exit(count: int) -> None:
    graph = threads(count)
    assert check(graph) == []
    loads = [node for node in graph.nodes if node.op is Opcode.LOAD]
    assert len(loads) == sum(node.op is Opcode.LOAD for node in blend().nodes)
    assert sum(node.control is Control.EXIT for node in graph.nodes) == 1
    assert sum(node.op is Opcode.LIVE_OUT for node in graph.nodes) == 4 * count


def test_four_threads_have_the_operations_of_a_full_tile() -> None:
    assert len(threads(4).operations) == 107
    assert len(threads(8).operations) == 203

"""Graphs in tests of passes: read from short texts, printed with nodes numbered in order, and run
on random words (see `tests.rules`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.dfg.test_passes_keep_meaning import run
from tests.rules import Language
from tests.strategies import ARRAY_WORDS, MEMORY_WORDS
from vividc.dfg.check import check
from vividc.dfg.forms.text import parse, to_text
from vividc.dfg.ir import DFG

SOURCES = """dfg "d"
%0 = iv
%1 = live_in "a"
%2 = live_in "&x"
%3 = load "x" %0 shift 2 base %2 !k.py:1
%4 = load "x" %1 shift 2 base %2
"""
_TRIES = 6


def graph(text: str) -> DFG:
    """A graph that begins with `SOURCES`, unless the text says how."""
    return parse(text if text.startswith("dfg") else SOURCES + text)


def text_of(made: DFG, before: DFG) -> str:
    """The text of `made`, with nodes numbered in order."""
    ids = {node.id: number for number, node in enumerate(made.nodes)}
    nodes = tuple(replace(node, id=ids[node.id]) for node in made.nodes)
    edges = tuple(
        replace(
            edge,
            src=ids[edge.src],
            dst=ids[edge.dst],
            init=None if edge.init is None else ids[edge.init],
        )
        for edge in made.edges
    )
    lines = to_text(replace(made, nodes=nodes, edges=edges)).splitlines()
    return "\n".join(line for line in lines[1:] if not line.startswith("edges"))


def demand_same(before: DFG, after: DFG) -> None:
    """Fails unless both leave the same memory and variables after some iterations."""
    rng = np.random.default_rng(1)
    for _ in range(_TRIES):
        floats = rng.standard_normal(MEMORY_WORDS).astype(np.float32).view(np.uint32)
        small = rng.integers(0, ARRAY_WORDS, MEMORY_WORDS)
        memory = np.where(rng.random(MEMORY_WORDS) < 1 / 2, floats, small).tolist()
        n, a = rng.integers(0, ARRAY_WORDS, 2).tolist()
        assert run(after, memory, n, a) == run(before, memory, n, a)


GRAPHS = Language(graph, text_of, check, demand_same)

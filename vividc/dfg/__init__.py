"""Dataflow graphs: the IR, where they come from and go to, passes on them, an interpreter.

In order: `ir` (nodes and edges), `check` (invariants), `order`, `regions` (a kernel: a table of
regions with a graph each), `lives` (in which of them variables are needed), `builder`; `cut/` (from
SSA to regions), `passes/` and `expand/` (graph to graph), `pipeline` (their order), `alike` (graphs
but for their names); `interpret/`; `forms/` (text, JSON, DOT, XML, networkx; docs/dfg-formats.md),
`draw`.
"""

from vividc.dfg.check import check
from vividc.dfg.draw import attach
from vividc.dfg.forms.dot import parse_dot, to_dot
from vividc.dfg.forms.json_form import from_json, to_json
from vividc.dfg.forms.load import UnknownOps, load
from vividc.dfg.forms.networkx_form import from_networkx, to_networkx
from vividc.dfg.forms.text import parse, to_text
from vividc.dfg.interpret.interpreter import (
    InterpreterResult,
    RegionRun,
    interpret,
    interpret_region,
)
from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.machine.opcodes import BASE, ORDER, PRED, LatencyClass, Opcode, Type
from vividc.machine.semantics import SEMANTICS, evaluate, evaluate_predicated

__all__ = [
    "BASE",
    "DFG",
    "ORDER",
    "PRED",
    "SEMANTICS",
    "Control",
    "Edge",
    "EdgeKind",
    "InterpreterResult",
    "LatencyClass",
    "Node",
    "Opcode",
    "RegionRun",
    "Type",
    "UnknownOps",
    "check",
    "evaluate",
    "evaluate_predicated",
    "from_json",
    "from_networkx",
    "interpret",
    "interpret_region",
    "load",
    "parse",
    "parse_dot",
    "to_dot",
    "to_json",
    "to_networkx",
    "to_text",
]

attach()

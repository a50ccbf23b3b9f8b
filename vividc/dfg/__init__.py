"""Dataflow graphs: IR, semantics, interpreter, passes, and their text, JSON and DOT forms."""

from vividc.dfg.check import check
from vividc.dfg.dot import parse_dot, to_dot
from vividc.dfg.interpreter import InterpreterResult, RegionRun, interpret, interpret_region
from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.dfg.json_form import from_json, to_json
from vividc.dfg.load import UnknownOps, load
from vividc.dfg.networkx_form import from_networkx, to_networkx
from vividc.dfg.text import parse, to_text
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

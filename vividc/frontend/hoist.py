"""Move what does not change in a loop to before the loop: LLVM's own pass is out of llvmlite's
reach.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.dfg.cfg import Function, Instr, Ref
from vividc.dfg.opcodes import MEMORY
from vividc.frontend.ssa import Flow


def hoist_invariants(function: Function) -> Function:
    """Hoist loop-invariant operations into preheaders, out of as many loops as possible.

    Every operation but an access to memory may run speculatively. Accesses stay: the loop may not
    run at all, or may store to the same place.
    """
    flow = Flow(function.blocks[0].name, {b.name: b.branch.successors for b in function.blocks})
    instrs = {block.name: list(block.instrs) for block in function.blocks}
    home = _homes(function)
    # Inner loops come later in reverse postorder: an operation leaves them first.
    for header, body in reversed(flow.loops.items()):
        outside = [pred for pred in flow.predecessors[header] if pred not in body]
        if len(outside) != 1 or flow.successors[outside[0]] != (header,):
            continue
        for name in flow.order:
            if name in body:
                _hoist_block(instrs, home, name, outside[0], body)
    blocks = tuple(replace(b, instrs=tuple(instrs[b.name])) for b in function.blocks)
    return replace(function, blocks=blocks)


def _homes(function: Function) -> dict[int, str]:
    home: dict[int, str] = {}
    for block in function.blocks:
        home.update((phi.id, block.name) for phi in block.phis)
        home.update((instr.id, block.name) for instr in block.instrs)
    return home


def _hoist_block(
    instrs: dict[str, list[Instr]],
    home: dict[int, str],
    name: str,
    preheader: str,
    body: frozenset[str],
) -> None:
    kept = []
    for instr in instrs[name]:
        if instr.op in MEMORY or any(_inside(v, home, body) for v in instr.operands):
            kept.append(instr)
            continue
        instrs[preheader].append(instr)
        home[instr.id] = preheader
    instrs[name] = kept


def _inside(value: object, home: dict[int, str], body: frozenset[str]) -> bool:
    return isinstance(value, Ref) and home[value.id] in body

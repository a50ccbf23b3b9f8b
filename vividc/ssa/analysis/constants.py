"""Instructions whose operands are known words."""

from __future__ import annotations

from collections.abc import Mapping

from vividc.machine.opcodes import EXPANDED_FLOATS, Opcode, Type
from vividc.machine.semantics import SEMANTICS
from vividc.ssa.ir import Const, Instr, Ref


def constant_value(instr: Instr, words: Mapping[int, int]) -> int | None:
    """The word that `instr` computes if its operands are constants or ids of `words`, else None;
    None, too, if it is a float operation that is expanded later.
    """
    if instr.op not in SEMANTICS or instr.op in EXPANDED_FLOATS:
        return None
    operands = []
    for value in instr.operands:
        word = value.word if isinstance(value, Const) else None
        if isinstance(value, Ref):
            word = words.get(value.id)
        if word is None:
            return _decided_early(instr, words)
        operands.append(word)
    return SEMANTICS[instr.op](*operands)


def _decided_early(instr: Instr, words: Mapping[int, int]) -> int | None:
    """`and` with 0 is 0 and `or` with 1 of predicates is 1, whatever the other operand."""
    known = [words.get(v.id) if isinstance(v, Ref) else None for v in instr.operands]
    known += [v.word for v in instr.operands if isinstance(v, Const)]
    if instr.op is Opcode.AND and 0 in known:
        return 0
    everything = 1 if instr.type is Type.PRED else 0xFFFFFFFF
    if instr.op is Opcode.OR and everything in known:
        return everything
    return None

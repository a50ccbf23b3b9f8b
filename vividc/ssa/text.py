"""The text form of a function: complete, readable, and read back to an equal function.

A line an instruction; lines that start with ``#`` are comments::

    function "dot" file "dot.py" returns int32
    param "n" int32
    param "x" float32[1]
    local "t" words 4 contents 0x00000001 0x00000002 0x00000003 0x00000004
    entry:
      jump head !dot.py:7
    head:
      %3 i32 = phi [entry: 0x00000000, body: %9] !dot.py:7
      %4 pred = icmp.slt %3, $"n"
      branch %4 body else done
    body:
      %6 f32 = load $"&x", %3 array "x" shift 2 !dot.py:8
      %9 i32 = add %3, 0x00000001 exact
      jump head
    done:
      return %3

``%3`` is the result of an instruction, ``0x...`` a word, ``undef`` one that nobody reads, ``$"n"``
an input that the host supplies. Clauses after the operands are the fields of `Instr`, left out
where they have their defaults. ``sequential`` in the first line names the loops that run block by
block.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Final

from vividc.errors import SourceLoc
from vividc.machine.params import LocalArray, Param
from vividc.machine.text_line import location_text
from vividc.ssa.ir import (
    Block,
    Branch,
    Const,
    Function,
    Input,
    Instr,
    Phi,
    Ref,
    Undefined,
    Value,
    type_name,
)
from vividc.ssa.text_parser import PLAIN, parse

__all__ = ["parse", "to_text"]

_WORD_BYTES: Final = 4


def to_text(function: Function) -> str:
    """The text form of `function`, with a final newline."""
    lines = [_header(function)]
    lines += [_param(param) for param in function.params]
    lines += [_local(local) for local in function.locals]
    for block in function.blocks:
        lines += _block(block)
    return "\n".join(lines) + "\n"


def _header(function: Function) -> str:
    parts = [f"function {json.dumps(function.name)}"]
    if function.file:
        parts.append(f"file {json.dumps(function.file)}")
    if function.returns is not None:
        parts.append(f"returns {function.returns.value}")
    if function.sequential:
        parts.append(f"sequential {', '.join(map(_name, sorted(function.sequential)))}")
    return " ".join(parts)


def _param(param: Param) -> str:
    parts = [f"param {json.dumps(param.name)} {param.dtype.value}"]
    if param.ndim:
        parts[0] += f"[{param.ndim}]"
    if param.flat:
        parts.append("flat")
    if param.words != 1:
        parts.append(f"words {param.words}")
    if param.longest:
        parts.append(f"longest {param.longest}")
    return " ".join(parts)


def _local(local: LocalArray) -> str:
    parts = [f"local {json.dumps(local.name)} words {local.words}"]
    if local.contents is not None:
        parts.append(" ".join(("contents", *(f"{word:#010x}" for word in local.contents))))
    if local.size:
        parts.append(" ".join(("size", *map(json.dumps, local.size))))
    if local.loops:
        parts.append(" ".join(("loops", *(json.dumps([at.file, at.line]) for at in local.loops))))
    return " ".join(parts)


def _block(block: Block) -> Iterator[str]:
    yield f"{_name(block.name)}:"
    for phi in block.phis:
        yield f"  {_phi(phi)}{_loc(phi.loc)}"
    for instr in block.instrs:
        yield f"  {_instr(instr)}{_loc(instr.loc)}"
    yield f"  {_branch(block.branch)}{_loc(block.branch.loc)}"


def _phi(phi: Phi) -> str:
    incoming = (f"{_name(block)}: {_value(value)}" for block, value in phi.incoming)
    return f"%{phi.id} {type_name(phi.type)} = phi [{', '.join(incoming)}]"


def _instr(instr: Instr) -> str:
    parts = [f"%{instr.id} {type_name(instr.type)} = {instr.mnemonic}"]
    if instr.operands:
        parts.append(", ".join(map(_value, instr.operands)))
    if instr.array:
        parts.append(f"array {json.dumps(instr.array)}")
    if instr.shift:
        parts.append(f"shift {instr.shift}")
    if instr.offset:
        parts.append(f"offset {instr.offset}")
    if instr.width != _WORD_BYTES:
        parts.append(f"width {instr.width}")
    parts += [word for word in ("signed", "exact") if getattr(instr, word)]
    if instr.distinct:
        parts.append(f"distinct {_name(instr.distinct)}")
    if instr.subscript:
        axes = ("_" if axis is None else str(axis) for axis in instr.subscript)
        parts.append(f"subscript [{', '.join(axes)}]")
    if instr.lane is not None:
        lane = instr.lane
        regions = ", ".join(map(_name, lane.regions))
        parts.append(f"lane {lane.thread} {lane.origin} {lane.part} [{regions}]")
    return " ".join(parts)


def _branch(branch: Branch) -> str:
    if branch.cond is not None:
        ways = f"{_name(branch.target or '')} else {_name(branch.otherwise or '')}"
        return f"branch {_value(branch.cond)} {ways}"
    if branch.target is not None:
        return f"jump {_name(branch.target)}"
    words = [_value(word) for word in (branch.value, branch.high) if word is not None]
    return " ".join(("return", ", ".join(words))) if words else "return"


def _value(value: Value) -> str:
    if isinstance(value, Ref):
        return f"%{value.id}"
    if isinstance(value, Input):
        return f"${json.dumps(value.key)}"
    if isinstance(value, Undefined) and value.word == 0:
        return "undef"
    assert isinstance(value, Const)
    return f"{value.word:#010x}"


def _name(name: str) -> str:
    return name if PLAIN.fullmatch(name) else json.dumps(name)


def _loc(loc: SourceLoc | None) -> str:
    return "" if loc is None else f" {location_text(loc)}"

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

A function that is LLVM's still says what it returns, and the types of its inputs; its constants are
decimal integers, the bits of doubles, globals with an offset, and lists of parts::

    function "mean" llvm "double"
    input "n" i64
    input "&x" ptr
    entry:
      %0 i64 = add $"n", -1 flags [nsw]
      %1 ptr = getelementptr @"table" 8, %0 source i8 strides [1]
      %2 double = load %1
      %3 double = fadd %2, f64 0x3ff0000000000000
      return %3
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Final

from vividc.errors import SourceLoc
from vividc.machine.lanes import Lane
from vividc.machine.params import LocalArray, Param
from vividc.machine.text_line import location_text
from vividc.machine.words import WORD_BYTES
from vividc.ssa.ir import (
    Block,
    Branch,
    Const,
    Float,
    Function,
    Global,
    Input,
    Instr,
    Int,
    Kind,
    Parts,
    Phi,
    Ref,
    Undefined,
    Value,
    type_name,
)
from vividc.ssa.text_parser import PLAIN, parse

__all__ = ["parse", "to_text"]


def to_text(function: Function) -> str:
    """The text form of `function`, with a final newline."""
    lines = [_header(function)]
    lines += [f"input {json.dumps(key)} {_name(kind)}" for key, kind in function.inputs]
    lines += [_param(param) for param in function.params]
    lines += [_local(local) for local in function.locals]
    if function.results is not None:
        lines.append(f"results {json.dumps(function.results.to_text())}")
    for block in function.blocks:
        lines += _block(block)
    return "\n".join(lines) + "\n"


def _header(function: Function) -> str:
    parts = [f"function {json.dumps(function.name)}"]
    if function.file:
        parts.append(f"file {json.dumps(function.file)}")
    if function.returns is not None:
        parts.append(f"returns {function.returns.value}")
    if function.is_llvm:
        parts.append(f"llvm {json.dumps(function.result)}")
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
    if param.known:
        parts.append(f"known [{', '.join(map(str, param.known))}]")
    if param.made:
        parts.append(" ".join(("made", *map(json.dumps, param.made))))
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
    return f"%{phi.id} {_type(phi.type)} = phi [{', '.join(incoming)}]"


def _instr(instr: Instr) -> str:
    parts = [f"%{instr.id} {_type(instr.type)} = {instr.mnemonic}"]
    if instr.operands:
        parts.append(", ".join(map(_value, instr.operands)))
    for clause, (default, write) in _CLAUSES.items():
        value = getattr(instr, clause)
        if value != default:
            parts.append(f"{clause} {write(value)}".rstrip())
    return " ".join(parts)


def _listed(items: Iterable[object]) -> str:
    return f"[{', '.join(map(str, items))}]"


def _lane(lane: Lane) -> str:
    return f"{lane.thread} {lane.origin} {lane.part} {_listed(map(_name, lane.regions))}"


def _type(kind: Kind) -> str:
    return _name(type_name(kind))


def _branch(branch: Branch) -> str:
    if branch.unreachable:
        return "unreachable"
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
    if isinstance(value, Const):
        return f"{value.word:#010x}"
    return _constant(value)


def _constant(value: Int | Float | Global | Parts) -> str:
    """A constant of LLVM's."""
    if isinstance(value, Int):
        return str(value.value)
    if isinstance(value, Float):
        return f"f64 {value.bits:#018x}"
    if isinstance(value, Parts):
        return f"parts [{', '.join(map(_value, value.values))}]"
    return f"@{json.dumps(value.name)}" + (f" {value.offset}" if value.offset else "")


def _name(name: str) -> str:
    return name if PLAIN.fullmatch(name) else json.dumps(name)


def _loc(loc: SourceLoc | None) -> str:
    return "" if loc is None else f" {location_text(loc)}"


_CLAUSES: Final[Mapping[str, tuple[object, Callable[[Any], str]]]] = {
    "array": ("", json.dumps),
    "shift": (0, str),
    "offset": (0, str),
    "width": (WORD_BYTES, str),
    "signed": (False, lambda _: ""),
    "exact": (False, lambda _: ""),
    "distinct": ("", _name),
    "subscript": ((), lambda axes: _listed("_" if axis is None else axis for axis in axes)),
    "pred": ("", _name),
    "source": ("", _name),
    "strides": ((), _listed),
    "flags": (frozenset(), lambda flags: _listed(map(_name, sorted(flags)))),
    "lane": (None, _lane),
}
"""Fields of `Instr`: the default, which is left out, and how another value is written."""

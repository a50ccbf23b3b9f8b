"""From a `.ll` file's text to `ssa.ir.Function`: the stages before those shared with Python."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace

from vividc.errors import KernelError, SourceLoc, warn
from vividc.frontend.advice import in_c
from vividc.frontend.c.checks import check_body, reachable, refuse_own_names, refuse_recursion
from vividc.frontend.c.debug import declared
from vividc.frontend.c.entry import RETURNS, CFunction, CParameter, entry_text
from vividc.frontend.c.library import BELOW, with_block_operations, with_intrinsics, with_rounding
from vividc.frontend.c.source import Body, bodies
from vividc.frontend.c.unrotate import unrotate
from vividc.frontend.llvm.calls import ALLOCATE
from vividc.frontend.llvm.child.client import Late, Lost, ask
from vividc.frontend.llvm.layout import size_of, structs_of
from vividc.frontend.llvm.metadata import Locations
from vividc.frontend.llvm.passes import ENTRY
from vividc.frontend.llvm.reader import read_function, signature
from vividc.frontend.llvm.tokens import Structs
from vividc.frontend.lower import counting_parameters, located, lower_words
from vividc.frontend.memory.arrays.local_arrays import RAW
from vividc.frontend.refused.length import refuse_long
from vividc.frontend.stages import without_pointers
from vividc.host.watch import run_passes
from vividc.machine.params import WIDE_DTYPES, DType, Param
from vividc.ssa.ir import Block, Function, Instr, Int, Ref

_LINK_LIMIT_S = 20
_HINTS = re.compile(
    r"^.*\bcall void @llvm\.(?:experimental\.noalias\.scope\.decl|assume|lifetime|donothing|"
    r"prefetch)\b.*\n",
    re.MULTILINE,
)
"""Calls that only tell LLVM something."""
_PARAMETERS = frozenset(["ptr", "i1", "i8", "i16", "i32", "i64", "float", "double"])
_TYPES_HINT = "a kernel takes and returns float, int32_t, uint32_t, int64_t, bool and pointers"
_SMALL = {"i8": (DType.U8, DType.I8), "i16": (DType.U16, DType.I16)}
_NO_ELEMENTS = frozenset(dtype.value for dtype in WIDE_DTYPES)


@dataclass(frozen=True)
class CModule:
    """A C function of a `.ll` file.

    Attributes
    ----------
    text
        The module as LLVM prints it, with a source line on every instruction.
    file
        Its absolute path.
    kernel
        The function with all that it calls, without pointers, before narrowing.
    """

    text: str
    file: str
    function: CFunction
    params: tuple[Param, ...]
    kernel: Function


def declare(text: str, file: str, name: str, types: Mapping[str, str] | None = None) -> CModule:
    """Find a function in a module, check it and read it.

    Parameters
    ----------
    text
        The module as LLVM prints it, with a source line on every instruction.
    types
        numpy's names of types by parameter, which go before what the text says.

    Raises
    ------
    KernelError
        The function is missing or cannot run on the array.
    """
    by_name = {body.name: body for body in bodies(text)}
    if name not in by_name:
        known = ", ".join(by_name) or "none"
        raise KernelError(f"has no function `{name}`", loc=file, hint=f"it defines: {known}")
    function = _typed(_function(text, by_name[name], file), types or {})
    locate = Locations(text, function.loc.file)
    refuse_own_names(text, file)
    used = reachable(by_name[name], by_name)
    structs = structs_of(text)
    for body in used:
        check_body(body, structs, locate)
    refuse_recursion(used, locate)
    return _module(text, file, function)


def with_scalars(module: CModule, known: Mapping[str, int]) -> CModule:
    """The function where these integer parameters have these values."""
    function = module.function
    params = tuple(replace(p, known=known.get(p.name)) for p in function.params)
    return _module(module.text, module.file, replace(function, params=params))


def _module(text: str, file: str, function: CFunction) -> CModule:
    with located(function.loc), _in_c_terms():
        kernel = _read(text, function, frozenset())
        params = _params(function, kernel)
        counts = counting_parameters(kernel, params)
        if counts:
            kernel = _read(text, function, counts)
            params = tuple(replace(p, words=1) if p.name in counts else p for p in params)
    return CModule(text, file, function, params, kernel)


def _typed(function: CFunction, types: Mapping[str, str]) -> CFunction:
    params = tuple(replace(p, dtype=types.get(p.name, p.dtype)) for p in function.params)
    return replace(function, params=params)


def lower_c(module: CModule, *, strict_fp: bool) -> Function:
    """The function as SSA words; errors and warnings as of `lower.lower`."""
    function = module.function
    for param in function.params:
        if param.type == "double":
            _report_double(param, function.loc, strict_fp=strict_fp)
    with _in_c_terms():
        return lower_words(
            module.kernel,
            function.symbol,
            module.params,
            function.result,
            function.loc,
            file=module.file,
            strict_fp=strict_fp,
            worded=in_c,
        )


def _report_double(param: CParameter, loc: SourceLoc, *, strict_fp: bool) -> None:
    reason = f"parameter {param.name} is a double"
    if strict_fp:
        raise KernelError(reason, loc=loc, hint="declare it float")
    text = f"{loc}: {reason} and is rounded to float32; declare it float"
    warn(text)


@contextmanager
def _in_c_terms() -> Iterator[None]:
    """Hints of the stages that Python's kernels share, in C's words."""
    try:
        yield
    except KernelError as error:
        if error.hint is None:
            raise
        raise KernelError(error.reason, loc=error.loc, hint=in_c(error.hint)) from error


def _function(text: str, body: Body, file: str) -> CFunction:
    header = body.lines[0]
    types, returns = signature(header)
    known = declared(text, header)
    names = [f"arg{index}" if name.isdecimal() else name for index, (name, _) in enumerate(types)]
    dtypes = [""] * len(names)
    if known is not None and len(known.names) == len(names):
        names, dtypes = list(known.names), list(known.dtypes)
    params = tuple(
        CParameter(name, type_, dtype)
        for name, (_, type_), dtype in zip(names, types, dtypes, strict=True)
    )
    loc = Locations(text, file).definition(header) or SourceLoc(file, body.first)
    for param in params:
        if param.type not in _PARAMETERS:
            reason = f"parameter {param.name} has type {param.type}, which the array cannot hold"
            raise KernelError(reason, loc=loc, hint=_TYPES_HINT)
    if returns not in RETURNS:
        raise KernelError(f"the function returns {returns}", loc=loc, hint=_TYPES_HINT)
    signed = "zeroext" not in header.split("@")[0]
    dtype = known.returns if known is not None else ""
    return CFunction(body.name, params, returns, dtype, signed, loc)


def _read(text: str, function: CFunction, counts: frozenset[str]) -> Function:
    """The kernel without pointers; `counts` as of `entry_text`."""
    module, rounding = with_rounding(with_intrinsics(text))
    module, blocks_library = with_block_operations(module)
    parts = [part for part in (module, rounding, blocks_library) if part]
    optimised = _HINTS.sub("", _linked(entry_text(function, counts), parts, function.loc))
    wide = read_function(optimised, ENTRY, function.loc.file)
    refuse_long(wide, function.loc)
    _refuse_kept_calls(wide, frozenset(body.name for body in bodies(text)), function.loc)
    structs = structs_of(optimised)
    blocks = tuple(
        replace(block, instrs=tuple(_recognised(op, structs) for op in block.instrs))
        for block in wide.blocks
    )
    kernel = without_pointers(replace(wide, blocks=blocks), optimised, packed=True)
    return run_passes((unrotate,), kernel)


def _refuse_kept_calls(wide: Function, defined: frozenset[str], loc: SourceLoc) -> None:
    """A function of the file that LLVM does not inline, whatever its name, is none of math.h's."""
    for block in wide.blocks:
        for op in block.instrs:
            if op.op == "call" and op.pred in defined:
                reason = f"the function `{op.pred}` is called, and LLVM cannot inline it"
                hint = (
                    "compile it without attributes that keep it apart, such as those of coroutines"
                )
                raise KernelError(reason, loc=op.loc or loc, hint=hint)


def _linked(entry: str, parts: list[str], loc: SourceLoc) -> str:
    """`linked_ir`, in a process of its own."""
    request = {"do": "link", "entry": entry, "parts": parts}
    try:
        answer, _ = ask(request, limit_s=_LINK_LIMIT_S)
    except Late as late:
        reason = f"LLVM takes more than {_LINK_LIMIT_S} s to optimise the function"
        raise KernelError(reason, loc=loc, hint="make the function smaller") from late
    except Lost as lost:
        reason = f"LLVM cannot optimise the function: it dies ({str(lost) or 'an error'})"
        raise KernelError(reason, loc=loc, hint="make the function smaller") from lost
    if "text" not in answer:
        what = " ".join(answer["error"].split())
        raise KernelError(f"LLVM cannot optimise the function: {what}", loc=loc)
    return str(answer["text"])


def _recognised(op: Instr, structs: Structs) -> Instr:
    """A call of `library` as the comparison that it stands for, an array of C's own as one."""
    size = size_of(str(op.type), structs) if op.op == "alloca" else None
    if size is not None:
        return replace(op, op="call", type="ptr", pred=ALLOCATE + RAW, operands=(Int(size),))
    if op.op != "call":
        return op
    if op.pred == BELOW:
        return replace(op, op="icmp", type="ptr", pred="ult", flags=frozenset({BELOW}))
    return op


def _params(function: CFunction, wide: Function) -> tuple[Param, ...]:
    accessed = _accessed(wide.blocks)
    return tuple(
        Param(param.name, _element(param, accessed.get(param.name, set())), 1, flat=True)
        if param.type == "ptr"
        else _scalar(param)
        for param in function.params
    )


def _scalar(param: CParameter) -> Param:
    known = () if param.known is None else (param.known,)
    words = 2 if param.scalar in WIDE_DTYPES else 1
    return Param(param.name, param.scalar, words=words, known=known)


def _accessed(blocks: tuple[Block, ...]) -> dict[str, set[str]]:
    """LLVM types of the accesses to each array, and "signed" if all loads are sign-extended."""
    extended = _extended(blocks)
    accesses: dict[str, set[str]] = {}
    unsigned: set[str] = set()
    for block in blocks:
        for op in block.instrs:
            if op.array:
                accesses.setdefault(op.array, set()).add(str(op.type))
            if op.op == "load" and extended.get(op.id, set()) != {"sext"}:
                unsigned.add(op.array)
    loaded = {op.array for block in blocks for op in block.instrs if op.op == "load"}
    for array in loaded - unsigned:
        accesses[array].add("signed")
    return accesses


def _extended(blocks: tuple[Block, ...]) -> dict[int, set[str]]:
    """By which operations each value is used, phis and exits left out."""
    extensions: dict[int, set[str]] = {}
    for block in blocks:
        for op in block.instrs:
            for arg in op.operands:
                if isinstance(arg, Ref):
                    extensions.setdefault(arg.id, set()).add(op.mnemonic)
    return extensions


def _element(param: CParameter, accesses: set[str]) -> DType:
    """What the declaration says, else what the accesses do: the largest; words that are read as
    floats are, bytes and halves are signed if every load is sign-extended.
    """
    if param.dtype and param.dtype not in _NO_ELEMENTS:
        return DType(param.dtype)
    if "float" in accesses:
        return DType.F32
    if "i32" in accesses or not accesses & _SMALL.keys():
        return DType.I32
    return _SMALL["i16" if "i16" in accesses else "i8"]["signed" in accesses]

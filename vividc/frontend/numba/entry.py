"""LLVM IR of a typed function: numba's modules, all inlined into an entry function of our own.

Numba's calling convention disappears so: the entry's parameters are the words that the host
supplies at launch.
"""

from __future__ import annotations

from vividc.errors import SourceLoc
from vividc.frontend.llvm.calls import PITCH
from vividc.frontend.llvm.passes import DATA_LAYOUT, ENTRY, linked_ir
from vividc.frontend.numba.returned import parts_of
from vividc.frontend.numba.target import NumbaModule
from vividc.machine.params import HIGH_SUFFIX, WIDE_DTYPES, DType, Param

_SCALAR = {
    DType.F32: "float",
    DType.C64: "float",  # each part
    DType.F16: "i16",
    DType.I32: "i32",
    DType.U32: "i32",
    DType.I16: "i16",
    DType.U16: "i16",
    DType.I8: "i8",
    DType.U8: "i8",
    DType.I64: "i64",
    DType.U64: "i64",
    DType.BOOL: "i8",
}


_RETURN = {"float32": "float", "int32": "i32", "uint32": "i32", "bool": "i8"}
_RETURN |= {"int64": "i64", "uint64": "i64"}
_RETURN |= {"int16": "i16", "uint16": "i16", "int8": "i8", "uint8": "i8"}


def optimised_ir(module: NumbaModule, params: tuple[Param, ...], loc: SourceLoc) -> str:
    """Link, inline and optimise a kernel.

    Parameters
    ----------
    module
        What numba made of the kernel.
    params
        The kernel's parameters, in order.
    loc
        Where the kernel is defined.

    Returns
    -------
    str
        Text of a module whose function `ENTRY` holds the whole kernel.
    """
    return linked_ir(_entry_text(module, params, loc), module.texts)


def _entry_text(module: NumbaModule, params: tuple[Param, ...], loc: SourceLoc) -> str:
    """An entry function that rebuilds numba's flattened arguments: strides and sizes become
    functions of shapes.
    """
    inputs: list[str] = []
    body: list[str] = []
    arguments: list[str] = []
    pitches = "\n".join(_pitch(param, axis) for param in params for axis in range(1, param.ndim))
    for param in params:
        array = param.ndim > 0
        (_array_argument if array else _scalar_argument)(param, inputs, body, arguments)
    name = str(module.returned)
    parts = parts_of(module.returned) if name not in _RETURN else None
    returned = _RETURN[name] if parts is None else parts.type_text
    types = ", ".join(["ptr", *(argument.split(" ")[0] for argument in arguments)])
    call = ", ".join(["ptr %..ret", *arguments])
    file = loc.file.replace("\\", "\\5C").replace('"', "\\22")
    result = "void" if parts is not None else returned
    leave = f"%..value = load {returned}, ptr %..ret\n  ret {returned} %..value"
    if parts is not None:
        leave = "\n  ".join((*parts.lines("%..ret", "%..status", "!dbg !5"), "ret void"))
    declared = "\n".join(() if parts is None else parts.declarations)
    lines = "\n  ".join(body)
    line, flags = loc.line, "spFlags: DISPFlagDefinition"
    return f"""
target datalayout = "{DATA_LAYOUT}"
declare i32 @"{module.symbol}"({types})
{pitches}
{declared}
define {result} @{ENTRY}({", ".join(inputs)}) !dbg !3 {{
..entry:
  %..ret = alloca {returned}
  {lines}
  %..status = call i32 @"{module.symbol}"({call}), !dbg !5
  {leave}
}}
!llvm.dbg.cu = !{{!1}}
!llvm.module.flags = !{{!6, !7}}
!1 = distinct !DICompileUnit(language: DW_LANG_C_plus_plus, file: !2, emissionKind: LineTablesOnly)
!2 = !DIFile(filename: "{file}", directory: "")
!3 = distinct !DISubprogram(name: "{ENTRY}", file: !2, line: {line}, type: !4, unit: !1, {flags})
!4 = !DISubroutineType(types: !{{null}})
!5 = !DILocation(line: {line}, column: 1, scope: !3)
!6 = !{{i32 2, !"Dwarf Version", i32 4}}
!7 = !{{i32 2, !"Debug Info Version", i32 3}}
"""


def _pitch(param: Param, axis: int) -> str:
    """The declaration of an array's pitch: a number without effects, of which LLVM knows no more
    than bounds.
    """
    limits = f"range(i32 0, {param.limit(axis) + 1})"
    return f'declare {limits} i32 @"{PITCH}{param.name}.{axis}"() nounwind willreturn memory(none)'


def _scalar_argument(
    param: Param, inputs: list[str], body: list[str], arguments: list[str]
) -> None:
    kind = _SCALAR[param.dtype]
    name = f'%"{param.name}"'
    if param.known:
        name = str(param.known[0])
    elif param.dtype is DType.C64:  # numba takes its parts as arguments of their own
        parts = [f"float {name}", f'float %"{param.name}{HIGH_SUFFIX}"']
        inputs.extend(parts)
        arguments.extend(parts)
        return
    elif param.dtype in WIDE_DTYPES and param.words == 1:
        inputs.append(f"i32 {name}")
        extend = "sext" if param.dtype is DType.I64 else "zext"
        body.append(f'%".{param.name}" = {extend} i32 {name} to i64')
        name = f'%".{param.name}"'
    elif param.dtype is DType.BOOL:
        inputs.append(f"i1 {name}")
        body.append(f'%".{param.name}" = zext i1 {name} to i8')
        name = f'%".{param.name}"'
    else:
        inputs.append(f"{kind} {name}")
    arguments.append(f"{kind} {name}")


def _array_argument(param: Param, inputs: list[str], body: list[str], arguments: list[str]) -> None:
    """A C-contiguous array: its data pointer and shape come from the host, or the shape is known;
    the rest is computed.
    """
    x = param.name
    inputs.append(f'ptr noalias %"&{x}"')  # a launch with arrays that overlap is refused
    shapes: list[str] = []
    strides: list[str] = []
    item = param.dtype.size_bytes
    stride = str(item)
    count = "1"
    for axis in range(param.ndim):
        if param.known:
            shapes.append(str(param.known[axis]))
        else:
            inputs.append(f'i32 range(i32 0, {param.limit(axis) + 1}) %"{x}.shape{axis}"')
            body.append(f'%".{x}.shape{axis}" = zext nneg i32 %"{x}.shape{axis}" to i64')
            shapes.append(f'%".{x}.shape{axis}"')
        body.append(f'%".{x}.count{axis}" = mul nuw nsw i64 {count}, {shapes[axis]}')
        count = f'%".{x}.count{axis}"'
    for axis in reversed(range(param.ndim)):
        strides.insert(0, f"i64 {stride}")
        body.append(f'%".{x}.size{axis}" = mul nuw nsw i64 {stride}, {shapes[axis]}')
        stride = f'%".{x}.size{axis}"'
    head = ["ptr null", "ptr null", f"i64 {count}", f"i64 {item}", f'ptr %"&{x}"']
    arguments.extend(head + [f"i64 {size}" for size in shapes] + strides)

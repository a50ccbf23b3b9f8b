"""The entry function around a C function: it takes the words that the host supplies at launch, and
the function is inlined into it.
"""

from __future__ import annotations

from dataclasses import dataclass

from vividc.errors import SourceLoc
from vividc.frontend.llvm.passes import DATA_LAYOUT, ENTRY
from vividc.frontend.llvm.tokens import quoted_global
from vividc.machine.params import DType

RETURNS = {"i1": "i1", "i8": "i32", "i16": "i32", "i32": "i32", "i64": "i64"}
RETURNS |= {"float": "float", "double": "float", "void": "void"}
"""Type that the entry returns for each type of C's."""
_ENTRY_TYPE = {"ptr": "ptr", "i1": "i1", "float": "float", "double": "float"}
_CONVERSION = {"i8": "trunc", "i16": "trunc", "double": "fpext"}
_UNSIGNED = {("i32", DType.U32.value), ("i64", DType.U64.value)}


@dataclass(frozen=True, slots=True)
class CParameter:
    """One parameter of a C function.

    Attributes
    ----------
    name
        C's name, the IR's, or "arg0", "arg1", ...
    type
        LLVM's type.
    dtype
        Type of the word, or of the words pointed to, if the debug information or the user says.
    known
        The value of an integer that every launch gives; None: any.
    """

    name: str
    type: str
    dtype: str = ""
    known: int | None = None

    @property
    def scalar(self) -> DType:
        """Type of a scalar at launch: small integers are passed as int32, double as float32."""
        if self.type in ("float", "double"):
            return DType.F32
        if (self.type, self.dtype) in _UNSIGNED:
            return DType(self.dtype)
        return {"i1": DType.BOOL, "i64": DType.I64}.get(self.type, DType.I32)


@dataclass(frozen=True, slots=True)
class CFunction:
    """A function's declaration. `signed`: whether a small returned integer is."""

    symbol: str
    params: tuple[CParameter, ...]
    returns: str
    returns_dtype: str
    signed: bool
    loc: SourceLoc

    @property
    def result(self) -> DType | None:
        """Type of the returned scalar."""
        if self.returns == "void":
            return None
        return CParameter("", self.returns, self.returns_dtype).scalar


def entry_text(function: CFunction, counts: frozenset[str] = frozenset()) -> str:
    """A module that declares the function and defines `ENTRY`, which calls it.

    `counts`: the 64-bit parameters that are launched as one word; others take two.
    """
    inputs, body, arguments = [], [], []
    for index, param in enumerate(function.params):
        if param.known is not None:
            bits = int(param.type.removeprefix("i"))
            arguments.append(f"{param.type} {param.known % (1 << bits)}")
            continue
        whole = param.type == "i64" and param.name not in counts
        word = "i64" if whole else _ENTRY_TYPE.get(param.type, "i32")
        # Arrays of a launch never overlap.
        name = f'%"&{param.name}"' if word == "ptr" else f'%"{param.name}"'
        inputs.append(f"ptr noalias {name}" if word == "ptr" else f"{word} {name}")
        conversion = _conversion(param, word)
        if conversion:
            body.append(f"%..{index} = {conversion} {word} {name} to {param.type}")
            name = f"%..{index}"
        arguments.append(f"{param.type} {name}")
    types = ", ".join(param.type for param in function.params)
    symbol = quoted_global(function.symbol)
    result = RETURNS[function.returns]
    call = f"call {function.returns} {symbol}({', '.join(arguments)}), !dbg !5"
    body += [call, "ret void"] if result == "void" else [f"%..r = {call}", *_returned(function)]
    folder, line = function.loc.file.replace("\\", "\\5C").replace('"', "\\22"), function.loc.line
    lines = "\n  ".join(body)
    return f"""
target datalayout = "{DATA_LAYOUT}"
declare {function.returns} {symbol}({types})
define {result} @{ENTRY}({", ".join(inputs)}) !dbg !3 {{
..entry:
  {lines}
}}
!llvm.dbg.cu = !{{!1}}
!llvm.module.flags = !{{!6}}
!1 = distinct !DICompileUnit(language: DW_LANG_C99, file: !2, emissionKind: LineTablesOnly)
!2 = !DIFile(filename: "{folder}", directory: "")
!3 = distinct !DISubprogram(name: "{ENTRY}", file: !2, line: {line}, type: !4, unit: !1, \
spFlags: DISPFlagDefinition)
!4 = !DISubroutineType(types: !{{null}})
!5 = !DILocation(line: {line}, column: 1, scope: !3)
!6 = !{{i32 2, !"Debug Info Version", i32 3}}
"""


def _conversion(param: CParameter, word: str) -> str:
    """How the launched word becomes the argument; "" if it is the argument."""
    if param.type == "i64" and word != "i64":
        return "zext" if param.scalar is DType.U64 else "sext"
    return _CONVERSION.get(param.type, "")


def _returned(function: CFunction) -> list[str]:
    result = RETURNS[function.returns]
    if function.returns == result:
        return [f"ret {result} %..r"]
    widen = "sext" if function.signed else "zext"
    conversion = "fptrunc" if result == "float" else widen
    return [
        f"%..word = {conversion} {function.returns} %..r to {result}",
        f"ret {result} %..word",
    ]

"""The C library in LLVM IR: block operations as loops over words or bytes (what clang makes of a
loop that clears or copies an array), and `math.h`.
"""

from __future__ import annotations

import re

from vividc.frontend.memory.pointer_math import ANY

BELOW = ANY
"""Calls that ask whether a pointer lies below another, where those to different arrays do not."""
_MATH = {
    **{name: name for name in ("exp", "exp2", "log", "log2", "log10", "sqrt", "pow", "fma")},
    **{name: name for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")},
    **{name: name for name in ("sinh", "cosh", "tanh", "floor", "ceil", "trunc", "round")},
    **{name: name for name in ("rint", "nearbyint", "roundeven", "fabs", "copysign")},
    "fmin": "minnum",
    "fmax": "maxnum",
}
"""C's functions and LLVM's, which are those without `errno`."""
_CALL = re.compile(
    r"call void @llvm\.(?P<kind>memset|memcpy|memmove)(?:\.inline)?\.p0(?:\.p0)?"
    r"\.(?P<length>i32|i64)\((?P<args>.*)"
)
_DECLARE = re.compile(r"^declare .*@llvm\.(?:memset|memcpy|memmove)\..*$", re.MULTILINE)
_ALIGNED = re.compile(r"\bptr\b[^,]*?\balign (\d+)")
_POINTER = re.compile(r"\bptr\b")

_DISPATCH = """
define void @"{name}"({params}, i64 %bytes, i1 %volatile) {{
  %rest = and i64 %bytes, 3
  %whole = icmp eq i64 %rest, 0
  br i1 %whole, label %words, label %parts
words:
  %many = lshr i64 %bytes, 2
  call void @"{name}.i32"({values}, i64 %many)
  ret void
parts:
  call void @"{name}.i8"({values}, i64 %bytes)
  ret void
}}
"""
_BYTEWISE = """
define void @"{name}"({params}, i64 %bytes, i1 %volatile) {{
  call void @"{name}.i8"({values}, i64 %bytes)
  ret void
}}
"""
_HEAD = """
define void @"{name}.{item}"({params}, i64 %many) {{
  %known = call i64 @llvm.umin.i64(i64 %many, i64 2147483647)
  %count = trunc i64 %known to i32
  br label %start
start:
"""
_UP = """
  br label %up
up:
  %i = phi i32 [ 0, %{before} ], [ %i.next, %up.body ]
  %more = icmp slt i32 %i, %count
  br i1 %more, label %up.body, label %done
up.body:
  %to = getelementptr {item}, ptr %target, i32 %i
  {value}
  store {item} %word, ptr %to
  %i.next = add nuw nsw i32 %i, 1
  br label %up
"""
_LOAD = """%from = getelementptr {item}, ptr %source, i32 %i
  %word = load {item}, ptr %from"""
_DOWN = """
down:
  %j = phi i32 [ %count, %start ], [ %j.next, %down.body ]
  %left = icmp sgt i32 %j, 0
  br i1 %left, label %down.body, label %done
down.body:
  %j.next = add nsw i32 %j, -1
  %down.to = getelementptr {item}, ptr %target, i32 %j.next
  %down.from = getelementptr {item}, ptr %source, i32 %j.next
  %down.word = load {item}, ptr %down.from
  store {item} %down.word, ptr %down.to
  br label %down
"""
_TAIL = """
done:
  ret void
}
"""
_FILLED = {
    "i8": "%word = add i8 %value, 0",
    "i32": "%byte = zext i8 %value to i32\n  %word = mul i32 %byte, 16843009",
}
_PARAMS = {kind: ("ptr %target", "ptr %source") for kind in ("memcpy", "memmove")}
_PARAMS["memset"] = ("ptr %target", "i8 %value")


def _memset(item: str) -> str:
    return _UP.format(before="start", item=item, value=_FILLED[item])


def _memcpy(item: str) -> str:
    return _UP.format(before="start", item=item, value=_LOAD.format(item=item))


def _memmove(item: str) -> str:
    """From the end down where the target lies above the source."""
    return (
        f'  %above = call i1 @"{BELOW}"(ptr %source, ptr %target)\n'
        + "  br i1 %above, label %down, label %up.start\n"
        + "up.start:\n"
        + _UP.format(before="up.start", item=item, value=_LOAD.format(item=item))
        + _DOWN.format(item=item)
    )


_WRITERS = {"memset": _memset, "memcpy": _memcpy, "memmove": _memmove}


def with_block_operations(text: str) -> tuple[str, str]:
    """The module calling functions of ours, and the module that defines them.

    Blocks whose pointers are known to be aligned to words go by words where their size is a
    multiple of a word's, all others by bytes.

    Parameters
    ----------
    text
        A module as LLVM prints it.
    """
    used: dict[tuple[str, str, str], str] = {}

    def ours(match: re.Match[str]) -> str:
        key = (match["kind"], match["length"], "words" if _is_aligned(match) else "bytes")
        used[key] = "vividc." + ".".join(key)
        return f"call void @{used[key]}({match['args']}"

    text = _CALL.sub(ours, _DECLARE.sub("", text))
    if not used:
        return text, ""
    # No array has as many elements as a count that does not fit 31 bits: the block ends outside.
    library = [
        f'declare i1 @"{BELOW}"(ptr, ptr) memory(none) nounwind willreturn',
        "declare i64 @llvm.umin.i64(i64, i64)",
    ]
    declares = []
    for (kind, length, unit), name in used.items():
        types = ", ".join(param.partition(" ")[0] for param in _PARAMS[kind])
        declares.append(f"declare void @{name}({types}, {length}, i1)")
        library += _definitions(kind, name, length, unit)
    return "\n".join([text, *declares]), "\n".join(library)


def _is_aligned(call: re.Match[str]) -> bool:
    """Whether all pointers among the arguments are multiples of a word's size."""
    aligned = [int(size) % 4 == 0 for size in _ALIGNED.findall(call["args"])]
    return all(aligned) and len(aligned) == len(_POINTER.findall(call["args"]))


def _definitions(kind: str, name: str, length: str, unit: str) -> list[str]:
    params = _PARAMS[kind]
    signature = ", ".join(params)
    whole = (_DISPATCH if unit == "words" else _BYTEWISE).format(
        name=name, params=signature, values=signature
    )
    items = ("i8", "i32") if unit == "words" else ("i8",)
    loops = [
        _HEAD.format(name=name, item=item, params=signature) + _WRITERS[kind](item) + _TAIL
        for item in items
    ]
    return [whole if length == "i64" else _narrow_length(whole), *loops]


def _narrow_length(text: str) -> str:
    """The same function for a length of 32 bits."""
    text = text.replace("i64 %bytes, i1 %volatile", "i32 %size, i1 %volatile")
    return text.replace(") {\n", ") {\n  %bytes = zext i32 %size to i64\n", 1)


_ROUND = """
declare {type} @llvm.trunc.{suffix}({type})
declare {type} @llvm.fabs.{suffix}({type})
declare {type} @llvm.copysign.{suffix}({type}, {type})
define {type} @vividc.round.{suffix}({type} %x) {{
  %whole = call {type} @llvm.trunc.{suffix}({type} %x)
  %part = fsub {type} %x, %whole
  %size = call {type} @llvm.fabs.{suffix}({type} %part)
  %away = fcmp oge {type} %size, 5.000000e-01
  %one = select i1 %away, {type} 1.000000e+00, {type} 0.000000e+00
  %step = call {type} @llvm.copysign.{suffix}({type} %one, {type} %x)
  %sum = fadd {type} %whole, %step
  ret {type} %sum
}}
"""


def with_rounding(text: str) -> tuple[str, str]:
    """The module calling functions of ours for C's `round`, halves away from zero, and the module
    that defines them. `x - trunc(x)` is exact.
    """
    library = ""
    for type_, suffix in (("float", "f32"), ("double", "f64")):
        callee = f"@llvm.round.{suffix}("
        if callee in text:
            text = text.replace(callee, f"@vividc.round.{suffix}(")
            library += _ROUND.format(type=type_, suffix=suffix)
    return text, library


def with_intrinsics(text: str) -> str:
    """The module with LLVM's functions instead of those of C's `math.h`."""
    declared = re.findall(r"^declare (.*)@(\w+)\(([^)]*)\)", text, re.MULTILINE)
    for returns, name, params in declared:
        single = name.endswith("f") and name.removesuffix("f") in _MATH
        intrinsic = _MATH.get(name.removesuffix("f") if single else name)
        if intrinsic is None:
            continue
        kind, suffix = ("float", "f32") if single else ("double", "f64")
        if {returns.split()[-1], *(param.split()[0] for param in params.split(", "))} != {kind}:
            # The user's own function that has the name is no function of math.h.
            text = text.replace(f"@{name}(", f'@"{name} of another file"(')
            continue
        callee = f"llvm.{intrinsic}.{suffix}"
        types = ", ".join([kind] * (params.count(",") + 1))
        text = re.sub(rf"^declare .*@{name}\(.*$", "", text, flags=re.MULTILINE)
        text = text.replace(f"@{name}(", f"@{callee}(")
        if not re.search(rf"^declare .*@{re.escape(callee)}\(", text, re.MULTILINE):
            text += f"\ndeclare {kind} @{callee}({types})\n"
    return text

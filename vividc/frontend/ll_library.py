"""C's library in LLVM IR: block operations as loops over words (what clang makes of a loop that
clears or copies an array), and `math.h`.

A call that this cannot run as words stays behind after inlining under a name that says why, and is
refused with its line.
"""

from __future__ import annotations

import re

from vividc.frontend.pointer_math import ANY

BELOW = ANY
"""Calls that ask whether a pointer lies below another, where those to different arrays do not."""
PARTIAL = "vividc.partial "
"""Prefix of calls that are left if a block is not shown to consist of whole words."""

_MATH = {
    **{name: name for name in ("exp", "exp2", "log", "log2", "log10", "sqrt", "pow", "fma")},
    **{name: name for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")},
    **{name: name for name in ("sinh", "cosh", "tanh", "floor", "ceil", "trunc", "round")},
    **{name: name for name in ("rint", "nearbyint", "fabs", "copysign")},
    "fmin": "minnum",
    "fmax": "maxnum",
}
"""C's functions and LLVM's, which are those without `errno`."""
_CALL = re.compile(r"@(llvm\.(memset|memcpy|memmove)(?:\.inline)?\.p0(?:\.p0)?\.i(?:32|64))\(")

_HEAD = """
define void @"{name}"({params}, i64 %bytes, i1 %volatile) {{
  %rest = and i64 %bytes, 3
  %whole = icmp eq i64 %rest, 0
  br i1 %whole, label %start, label %partial
partial:
  call void @"{partial}{kind}"()
  br label %start
start:
"""
_UP = """
  br label %up
up:
  %i = phi i32 [ 0, %{before} ], [ %i.next, %up.body ]
  %more = icmp slt i32 %i, %words
  br i1 %more, label %up.body, label %done
up.body:
  %to = getelementptr i32, ptr %target, i32 %i
  {value}
  store i32 %word, ptr %to, align 4
  %i.next = add nuw nsw i32 %i, 1
  br label %up
"""
_WORDS = """  %many = lshr i64 %bytes, 2
  %words = trunc i64 %many to i32
"""
_LOAD = """%from = getelementptr i32, ptr %source, i32 %i
  %word = load i32, ptr %from, align 4"""
_DOWN = """
down:
  %j = phi i32 [ %words, %start ], [ %j.next, %down.body ]
  %left = icmp sgt i32 %j, 0
  br i1 %left, label %down.body, label %done
down.body:
  %j.next = add nsw i32 %j, -1
  %down.to = getelementptr i32, ptr %target, i32 %j.next
  %down.from = getelementptr i32, ptr %source, i32 %j.next
  %down.word = load i32, ptr %down.from, align 4
  store i32 %down.word, ptr %down.to, align 4
  br label %down
"""
_TAIL = """
done:
  ret void
}
"""
_COPY = "ptr %target, ptr %source"


def _memset(name: str) -> str:
    return (
        _HEAD.format(name=name, params="ptr %target, i8 %value", partial=PARTIAL, kind="memset")
        + "  %byte = zext i8 %value to i32\n  %filled = mul i32 %byte, 16843009\n"
        + _WORDS
        + _UP.format(before="start", value="%word = add i32 %filled, 0")
        + _TAIL
    )


def _memcpy(name: str) -> str:
    return (
        _HEAD.format(name=name, params=_COPY, partial=PARTIAL, kind="memcpy")
        + _WORDS
        + _UP.format(before="start", value=_LOAD)
        + _TAIL
    )


def _memmove(name: str) -> str:
    """From the end down where the target lies above the source."""
    return (
        _HEAD.format(name=name, params=_COPY, partial=PARTIAL, kind="memmove")
        + _WORDS
        + f'  %above = call i1 @"{BELOW}"(ptr %source, ptr %target)\n'
        + "  br i1 %above, label %down, label %up.start\n"
        + "up.start:\n"
        + _UP.format(before="up.start", value=_LOAD)
        + _DOWN
        + _TAIL
    )


_WRITERS = {"memset": _memset, "memcpy": _memcpy, "memmove": _memmove}


def with_block_operations(text: str) -> tuple[str, str]:
    """The module calling functions of ours, and the module that defines them.

    Parameters
    ----------
    text
        A module as LLVM prints it.
    """
    used = {match[1]: match[2] for match in _CALL.finditer(text)}
    if not used:
        return text, ""
    for callee in used:
        text = re.sub(rf"^declare .*@{re.escape(callee)}\(.*$", "", text, flags=re.MULTILINE)
        text = text.replace(f"@{callee}(", f"@vividc.{callee.removeprefix('llvm.')}(")
    library = [f'declare i1 @"{BELOW}"(ptr, ptr) memory(none) nounwind willreturn']
    kinds = sorted(set(used.values()))
    library += [f'declare void @"{PARTIAL}{kind}"()' for kind in kinds]
    declares: list[str] = []
    for callee, kind in used.items():
        name = f"vividc.{callee.removeprefix('llvm.')}"
        wide = _WRITERS[kind](name)
        source = "i8" if kind == "memset" else "ptr"
        length = callee.rpartition(".")[2]
        declares.append(f"declare void @{name}(ptr, {source}, {length}, i1)")
        library.append(wide if length == "i64" else _narrow_length(wide))
    return "\n".join([text, *declares]), "\n".join(library)


def _narrow_length(text: str) -> str:
    """The same function for a length of 32 bits."""
    text = text.replace("i64 %bytes, i1 %volatile", "i32 %size, i1 %volatile")
    return text.replace("  %rest = ", "  %bytes = zext i32 %size to i64\n  %rest = ", 1)


def with_intrinsics(text: str) -> str:
    """The module with LLVM's functions instead of those of C's `math.h`."""
    defined = re.findall(r"^declare .*@(\w+)\(([^)]*)\)", text, re.MULTILINE)
    for name, params in defined:
        single = name.endswith("f") and name.removesuffix("f") in _MATH
        intrinsic = _MATH.get(name.removesuffix("f") if single else name)
        if intrinsic is None:
            continue
        kind, suffix = ("float", "f32") if single else ("double", "f64")
        callee = f"llvm.{intrinsic}.{suffix}"
        types = ", ".join([kind] * (params.count(",") + 1))
        text = re.sub(rf"^declare .*@{name}\(.*$", "", text, flags=re.MULTILINE)
        text = text.replace(f"@{name}(", f"@{callee}(")
        if not re.search(rf"^declare .*@{re.escape(callee)}\(", text, re.MULTILINE):
            text += f"\ndeclare {kind} @{callee}({types})\n"
    return text

"""Random `.ll` modules: kernels that are defined in C, among whatever else a file may hold, and
committed files with random damage.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random

from tests.fuzz.module_damage import EXTREMES, WIDE, committed, mutated

WORDS = 16
"""Elements of each array, which generated subscripts never leave."""
_FLOATS = (
    "0.0",
    "-0.0",
    "1.0",
    "-1.5",
    "0x7FF0000000000000",
    "0xFFF0000000000000",
    "0x7FF8000000000000",
    "0x36A0000000000000",
    "0x47EFFFFFE0000000",
    "1.0e10",
    "0.5",
)
_SHADOWED = (
    "sinf",
    "cosf",
    "expf",
    "sqrtf",
    "sin",
    "memcpy",
    "memset",
    "memmove",
    "malloc",
    "free",
    "main",
    "exit",
    "abort",
    "_start",
    "_init",
    "printf",
    "system2",
    "__cxa_atexit",
    "dlsym",
    "environ",
    "__divdi3",
    "fmodf",
    "powf",
    "floorf",
    "check",
    "check.block",
    "llvm.foo",
    "f0",
    "g0",
    "a0",
    "a b",
    "quo\\22te",
    "__libc_start_main",
    "mmap",
    "fork",
    "_exit",
    "write",
    "__stack_chk_fail",
)
_LINKAGES = (
    "",
    "internal",
    "private",
    "linkonce",
    "linkonce_odr",
    "weak",
    "weak_odr",
    "hidden",
    "protected",
    "dso_local",
    "available_externally",
    "dllexport",
    "external",
    "extern_weak",
)
_KEPT = ("internal", "private unnamed_addr", "dso_local", "weak_odr")
_ASSEMBLY = (".globl sinf", "sinf: ud2", ".section .init_array")
_ATTRIBUTES = (
    'gc "statepoint-example"',
    'gc "shadow-stack"',
    "noinline optnone",
    "naked",
    "alwaysinline",
    "sspreq",
    "safestack",
    "sanitize_address",
    '"patchable-function"="prologue-short-redirect"',
    "align 64",
    '"probe-stack"="evil"',
    "uwtable",
    "returns_twice",
    "noreturn",
    'section ".init_array"',
    "unnamed_addr",
    "strictfp",
    "cold",
    "presplitcoroutine",
    '"split-stack"',
    "prologue i32 -1",
    "prefix i32 7",
    'partition "p"',
    '"instrument-function-entry"="system"',
    'section ".text.startup"',
    '"fentry-call"="true"',
    "shadowcallstack",
    '"target-features"="+avx512f"',
    '"xray-instruction-threshold"="1"',
)
_BINARY = ("add", "sub", "mul", "and", "or", "xor")
_COMPARISONS = ("eq", "ne", "slt", "sle", "sgt", "sge", "ult", "ule", "ugt", "uge")
_TWO = ("smin", "smax", "umin", "umax", "sadd.sat", "ssub.sat", "uadd.sat", "usub.sat")
_ONE = ("bswap", "bitreverse", "ctpop")
_ZERO_FLAG = ("ctlz", "cttz")
_FLOAT_ONE = ("fabs", "floor", "ceil", "trunc", "sqrt", "rint", "round", "roundeven")
_FLOAT_TWO = ("minnum", "maxnum", "copysign")


@dataclass
class _Body:
    """Instructions so far, and the values of each type."""

    random: Random
    lines: list[str] = field(default_factory=list)
    values: dict[str, list[str]] = field(default_factory=dict)
    declares: set[str] = field(default_factory=set)
    count: int = 0

    def emit(self, type_: str, text: str) -> str:
        name = f"%v{self.count}" if self.random.random() < 0.95 else f'%"v {self.count}"'
        self.count += 1
        gap = "\n    " if self.random.random() < 0.05 else " "
        self.lines.append(f"  {name} ={gap}{text}")
        self.values.setdefault(type_, []).append(name)
        return name

    def value(self, type_: str) -> str:
        known = self.values.get(type_, [])
        if known and self.random.random() < 0.7:
            return self.random.choice(known)
        if type_ == "float":
            return self.random.choice(_FLOATS)
        bits = int(type_[1:])
        if bits == 1:
            return self.random.choice(("true", "false"))
        number = self.random.choice(WIDE if bits == 64 else EXTREMES)
        return str((number + 2 ** (bits - 1)) % 2**bits - 2 ** (bits - 1))

    def call(self, returns: str, name: str, types: Sequence[str], arguments: Sequence[str]) -> None:
        self.declares.add(f"declare {returns} @{name}({', '.join(types)})")
        listed = ", ".join(f"{t} {a}" for t, a in zip(types, arguments, strict=True))
        self.emit(returns, f"call {returns} @{name}({listed})")


def _arithmetic(body: _Body) -> None:
    type_ = body.random.choice(("i32", "i32", "i64", "i8", "i16"))
    body.emit(
        type_, f"{body.random.choice(_BINARY)} {type_} {body.value(type_)}, {body.value(type_)}"
    )


def _shift(body: _Body) -> None:
    type_ = body.random.choice(("i32", "i64"))
    most = int(type_[1:]) - 1
    count = body.emit(type_, f"and {type_} {body.value(type_)}, {most}")
    body.emit(
        type_, f"{body.random.choice(('shl', 'lshr', 'ashr'))} {type_} {body.value(type_)}, {count}"
    )


def _division(body: _Body) -> None:
    """By a number of 1 to 32767."""
    low = body.emit("i32", f"and i32 {body.value('i32')}, 32767")
    divisor = body.emit("i32", f"or i32 {low}, 1")
    kind = body.random.choice(("sdiv", "udiv", "srem", "urem"))
    body.emit("i32", f"{kind} i32 {body.value('i32')}, {divisor}")


def _conversion(body: _Body) -> None:
    narrow, wide = body.random.choice(
        (("i8", "i32"), ("i16", "i32"), ("i32", "i64"), ("i1", "i32"))
    )
    if body.random.random() < 0.5:
        body.emit(
            wide, f"{body.random.choice(('sext', 'zext'))} {narrow} {body.value(narrow)} to {wide}"
        )
    else:
        body.emit(narrow, f"trunc {wide} {body.value(wide)} to {narrow}")


def _comparison(body: _Body) -> None:
    type_ = body.random.choice(("i32", "i64", "i8"))
    which = body.random.choice(_COMPARISONS)
    truth = body.emit("i1", f"icmp {which} {type_} {body.value(type_)}, {body.value(type_)}")
    body.emit("i32", f"select i1 {truth}, i32 {body.value('i32')}, i32 {body.value('i32')}")


def _intrinsic(body: _Body) -> None:
    kind = body.random.choice(("two", "one", "flag", "shift", "abs", "overflow"))
    if kind == "two":
        name = f"llvm.{body.random.choice(_TWO)}.i32"
        body.call("i32", name, ("i32", "i32"), (body.value("i32"), body.value("i32")))
    elif kind == "one":
        body.call("i32", f"llvm.{body.random.choice(_ONE)}.i32", ("i32",), (body.value("i32"),))
    elif kind == "shift":
        name = f"llvm.{body.random.choice(('fshl', 'fshr'))}.i32"
        body.call("i32", name, ("i32",) * 3, [body.value("i32") for _ in range(3)])
    elif kind == "overflow":
        name = f"llvm.{body.random.choice(('sadd', 'usub', 'smul'))}.with.overflow.i32"
        body.call("{ i32, i1 }", name, ("i32", "i32"), (body.value("i32"), body.value("i32")))
        pair = body.values["{ i32, i1 }"][-1]
        body.emit("i32", f"extractvalue {{ i32, i1 }} {pair}, 0")
        body.emit("i1", f"extractvalue {{ i32, i1 }} {pair}, 1")
    else:
        name = "llvm.abs.i32" if kind == "abs" else f"llvm.{body.random.choice(_ZERO_FLAG)}.i32"
        body.call("i32", name, ("i32", "i1"), (body.value("i32"), "false"))


def _floating(body: _Body) -> None:
    """One operation on what a word or an array holds, so that rounding cannot add up."""
    x, y = (body.random.choice(_FLOATS) for _ in range(2))
    if body.random.random() < 0.6:
        word = body.emit("i32", f"and i32 {body.value('i32')}, 1048575")
        x = body.emit("word", f"sitofp i32 {word} to float")
    kind = body.random.choice(("binary", "one", "two", "compare"))
    if kind == "binary":
        name = body.random.choice(("fadd", "fsub", "fmul"))
        body.emit("float", f"{name} float {x}, {y}")
    elif kind == "one":
        name = body.random.choice(_FLOAT_ONE)
        body.call("float", f"llvm.{name}.f32", ("float",), (x,))
    elif kind == "two":
        name = body.random.choice(_FLOAT_TWO)
        body.call("float", f"llvm.{name}.f32", ("float", "float"), (x, y))
    else:
        which = body.random.choice(("oeq", "olt", "ogt", "une", "uno", "ord", "ult"))
        body.emit("i1", f"fcmp {which} float {x}, {y}")


def _subscript(body: _Body) -> str:
    low = body.emit("i32", f"and i32 {body.value('i32')}, {WORDS - 1}")
    return body.emit("i64", f"zext i32 {low} to i64")


def _access(body: _Body) -> None:
    array = body.random.choice(("%x", "%x", "@table", "%local"))
    pointer = body.emit("ptr", f"getelementptr inbounds i32, ptr {array}, i64 {_subscript(body)}")
    if array != "@table" and body.random.random() < 0.4:
        body.lines.append(f"  store i32 {body.value('i32')}, ptr {pointer}")
    else:
        body.emit("i32", f"load i32, ptr {pointer}")


def _bytes(body: _Body) -> None:
    array = body.random.choice(("@string", "%bytes"))
    pointer = body.emit("ptr", f"getelementptr i8, ptr {array}, i64 {_subscript(body)}")
    if array == "%bytes" and body.random.random() < 0.5:
        body.lines.append(f"  store i8 {body.value('i8')}, ptr {pointer}")
    else:
        body.emit("i8", f"load i8, ptr {pointer}")


def _block(body: _Body) -> None:
    kind = body.random.choice(("memset", "memcpy", "memmove"))
    size = body.random.choice((0, 1, 3, 4, 8, 12, 16))
    other = "i8 3" if kind == "memset" else "ptr %local"
    types = "ptr, i8" if kind == "memset" else "ptr, ptr"
    name = f"llvm.{kind}.p0{'' if kind == 'memset' else '.p0'}.i64"
    body.declares.add(f"declare void @{name}({types}, i64, i1)")
    body.lines.append(f"  call void @{name}(ptr %bytes, {other}, i64 {size}, i1 false)")


def _helper(body: _Body) -> None:
    body.emit("i32", f"call i32 @helper(i32 {body.value('i32')}, i32 {body.value('i32')})")


_STEPS: tuple[Callable[[_Body], None], ...] = (
    _arithmetic,
    _arithmetic,
    _shift,
    _division,
    _conversion,
    _comparison,
    _intrinsic,
    _intrinsic,
    _floating,
    _access,
    _access,
    _bytes,
    _block,
    _helper,
)


def random_module(seed: int, command: str) -> tuple[str, str, bool]:
    """A module's text, the name of its kernel, and whether that is defined in C on arrays of
    `WORDS` elements; `command` is what foreign code would give to `system`.
    """
    random = Random(seed)
    if random.random() < 0.4:
        text, name = committed(random)
        if random.random() < 0.3:
            text += _surroundings(random, command, name)
        return mutated(random, text), name, False
    text, name = _generated(random, command)
    if random.random() < 0.2:
        return mutated(random, text), name, False
    return text, name, True


def _generated(random: Random, command: str) -> tuple[str, str]:
    name = random.choice(_SHADOWED) if random.random() < 0.3 else "kernel"
    body = _Body(random)
    body.values = {"i32": ["%n", "%i"], "float": ["%a"], "i64": ["%m"]}
    for _ in range(random.randrange(2, 14)):
        random.choice(_STEPS)(body)
    pointer = body.emit("ptr", f"getelementptr i32, ptr %x, i64 {_subscript(body)}")
    lines = "\n".join([*body.lines, f"  store i32 {body.values['i32'][-1]}, ptr {pointer}"])
    returned = random.choice(("i32", "float", "i64", "i1"))
    helper = _Body(random, values={"i32": ["%a", "%b"]})
    for _ in range(random.randrange(4)):
        random.choice((_arithmetic, _shift, _comparison))(helper)
    linkage = random.choice(("", "", "internal ", "dso_local ", "weak "))
    attributes = f" {random.choice(_ATTRIBUTES)}" if random.random() < 0.3 else ""
    aggregate = _nested(random, random.choice((0, 1, 2, 5, 30)))
    values = ", ".join(f"i32 {random.choice(EXTREMES)}" for _ in range(WORDS))
    string = "".join(
        random.choice(("a", "\\\\", "\\00", "\\FF", "\\22", "$", "\\C2", ";")) for _ in range(WORDS)
    )
    declares = "\n".join(sorted(body.declares | helper.declares))
    text = f"""
%nested = type {aggregate}
@table = {random.choice(_KEPT)} constant [{WORDS} x i32] [{values}], align 16
@string = internal constant [{WORDS} x i8] c"{string}"
{_surroundings(random, command, name)}
define {linkage}i32 @helper(i32 %a, i32 %b) {{
{chr(10).join(helper.lines)}
  ret i32 {helper.values["i32"][-1]}
}}
define {returned} @"{name}"(ptr %x, i32 %n, float %a, i64 %m){attributes} {{
entry:
  %local = alloca [{WORDS} x i32], align 16
  %bytes = alloca [{WORDS} x i8]
  %spare = alloca %nested
  call void @llvm.memset.p0.i64(ptr %local, i8 0, i64 {4 * WORDS}, i1 false)
  call void @llvm.memset.p0.i64(ptr %bytes, i8 1, i64 {WORDS}, i1 false)
  %some = icmp sgt i32 %n, 0
  br i1 %some, label %loop, label %end
loop:
  %i = phi i32 [ 0, %entry ], [ %next, %loop ]
{lines}
  %next = add i32 %i, 1
  %more = icmp slt i32 %next, %n
  br i1 %more, label %loop, label %end
end:
  %result = phi {returned} [ {_zero(returned)}, %entry ], [ {_last(body, returned)}, %loop ]
  ret {returned} %result
}}
{declares}
"""
    if "declare void @llvm.memset.p0.i64" not in declares:
        text += "declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)\n"
    return text, name.replace("\\22", '"')


def _zero(type_: str) -> str:
    return {"float": "0.0", "i1": "false"}.get(type_, "0")


def _last(body: _Body, type_: str) -> str:
    return (body.values.get(type_) or [_zero(type_)])[-1]


def _nested(random: Random, depth: int) -> str:
    type_ = random.choice(("i32", "float", "i8", "[3 x i16]", "i64"))
    for _ in range(depth):
        type_ = (
            random.choice((f"[2 x {type_}]", f"{{ {type_} }}", f"{{ i8, {type_} }}"))
            if depth < 9
            else f"{{ {type_} }}"
        )
    return f"{{ {type_} }}"


def _surroundings(random: Random, command: str, kernel: str) -> str:
    """What else the file holds: nothing of it may run, nor change what the kernel computes."""
    size = len(command) + 1
    parts = [
        f'@command = private constant [{size} x i8] c"{command}\\00"',
        "declare i32 @system(ptr)",
    ]
    call = "  %r = call i32 @system(ptr @command)"
    names = [
        n for n in random.sample(_SHADOWED, random.randrange(4)) if n not in (kernel, "llvm.foo")
    ]
    for name in names:
        linkage = random.choice(("", "internal ", "weak ", "linkonce_odr ", "protected "))
        attribute = f" {random.choice(_ATTRIBUTES)}" if random.random() < 0.4 else ""
        signature = random.choice(("float %x", "ptr %x, ptr %y, i64 %z", "i32 %x", ""))
        returns = "float" if signature.startswith("float") else "i32"
        zero = "1.0" if returns == "float" else "1"
        parts.append(
            f'define {linkage}{returns} @"{name}"({signature}){attribute} '
            f"{{\n{call}\n  ret {returns} {zero}\n}}"
        )
    boot = f"define void @boot(){{\n{call}\n  ret void\n}}"
    kind = "{ i32, ptr, ptr }"
    listed = f"appending global [1 x {kind}] [{kind} {{ i32 1, ptr @boot, ptr null }}]"
    extras = {
        "ctors": f"{boot}\n@llvm.global_ctors = {listed}",
        "dtors": f"{boot}\n@llvm.global_dtors = {listed}",
        "init": f'{boot}\n@start = global ptr @boot, section ".init_array"',
        "asm": "".join(f'module asm "{line}"\n' for line in _ASSEMBLY),
        "tls": f"@thread = {random.choice(_LINKAGES[:4])} thread_local global i32 5",
        "alias": f"{boot}\n@other = alias void (), ptr @boot",
        "ifunc": "define internal ptr @resolve() {\n  ret ptr @helper\n}\n"
        "@chosen = ifunc i32 (), ptr @resolve",
        "used": f"{boot}\n@llvm.used = appending global [1 x ptr] [ptr @boot]",
        "odd": f"@odd = {random.choice(_LINKAGES)} global "
        f"[{random.choice((0, 1, 2**20, 2**40))} x i8] zeroinitializer",
        "pointers": "@list = constant [2 x ptr] [ptr @helper, ptr null]",
        "comdat": "$c = comdat any\n@c = linkonce_odr constant i32 3, comdat",
        "missing": "declare void @nowhere()\n"
        "define void @uses() {\n  call void @nowhere()\n  ret void\n}",
        "triple": f'target triple = "{random.choice(("wasm32", "x", "aarch64-none-elf", ""))}"',
        "layout": f'target datalayout = "{random.choice(("e", "E-p:16:16", "zzz", "e-p:64:64"))}"',
    }
    chosen = random.sample(sorted(extras), random.randrange(3))
    unique = dict.fromkeys(part for key in chosen for part in extras[key].split("\n@"))
    found = "\n".join(parts)
    for part in unique:
        found += "\n" + (
            part
            if part.startswith(("define", "module", "declare", "target", "@", "$"))
            else f"@{part}"
        )
    return found

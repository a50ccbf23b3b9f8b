"""A C kernel as a module that runs on the host and can do nothing but compute.

The file's text is never run as it stands. Only what the kernel reaches is written anew, token by
token: instructions from a list, no attributes and no metadata, all names ours, so that no function
of the file can take the place of one that LLVM or C's library has. Every access is checked against
the arrays of the call, the constants and the local arrays, which lie in variables instead of the
stack; calls lead to the file's own functions, to LLVM's that compute and to `math.h`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from vividc.errors import InternalError, KernelError, SourceLoc
from vividc.frontend.c.checks import Locate, reachable
from vividc.frontend.c.source import Body, bodies, without_strings
from vividc.frontend.llvm.child.work import ARRAYS, FAULT, HOST, MATH, REFERENCE
from vividc.frontend.llvm.layout import size_of, structs_of
from vividc.frontend.llvm.reader import ARITHMETIC, joined, label_of, signature
from vividc.frontend.llvm.tokens import Cursor, Structs, bare
from vividc.ssa.ir import LLVM_CASTS

_OTHERS = ("icmp", "fcmp", "select", "phi", "br", "switch", "ret")
_ADDRESSES = ("getelementptr", "extractvalue", "insertvalue")
_COMPUTES = LLVM_CASTS | ARITHMETIC | {*_OTHERS, *_ADDRESSES}
_INTRINSIC = re.compile(
    r"llvm\.(?:sqrt|sin|cos|tan|asin|acos|atan2?|sinh|cosh|tanh|pow|powi|exp2?|exp10|log|log2|log10|"
    r"ldexp|fma|fmuladd|fabs|copysign|min(?:num|imum|imumnum)|max(?:num|imum|imumnum)|canonicalize|"
    r"floor|ceil|trunc|round|roundeven|rint|nearbyint|l?lrint|l?lround|is\.fpclass|"
    r"[us](?:min|max|cmp)|abs|ctpop|ctlz|cttz|bswap|bitreverse|fsh[lr]|expect|is\.constant|"
    r"[us](?:add|sub|mul)\.with\.overflow|[us](?:add|sub|shl)\.sat|fpto[us]i\.sat)"
    r"(?:\.(?:i\d+|f32|f64))+"
)
_SAYS_NOTHING = re.compile(
    r"llvm\.(?:dbg\.|assume|lifetime\.|donothing|prefetch|experimental\.noalias\.scope\.decl)"
)
_BLOCK = re.compile(r"llvm\.(memcpy|memmove|memset)(?:\.inline)?\.[p0.]+\.(i32|i64)")
_BLOCK_TYPES = {kind: ("ptr", "ptr") for kind in ("memcpy", "memmove")} | {"memset": ("ptr", "i8")}
_VARIABLE = re.compile(r'^(@(?:"[^"]*"|[-\w$.]+)) = (.*)$', re.MULTILINE)
_STRUCT = re.compile(r'^%(?:"[^"]*"|\S+) = type .*$', re.MULTILINE)
_ODD_VARIABLE = {"alias": "an alias", "ifunc": "a function that is chosen at its first call"}
_HINT = "call functions of the same file, and those of math.h"
_UNKNOWN_HINT = "leave out --check, or write the operation in another way"
_MAX_BYTES = 1 << 28
_ODD_ADDRESS = 4097
_CHECK = f"""
declare void @"{FAULT}"(i64)
define internal void @check(ptr %p, i64 %size, i64 %place) {{
  %at = ptrtoint ptr %p to i64
  br label %try
try:
  %i = phi i64 [ 0, %0 ], [ %next, %more ]
  %entry = getelementptr [2 x i64], ptr @"{ARRAYS}", i64 %i
  %start = load i64, ptr %entry
  %room.at = getelementptr i64, ptr %entry, i64 1
  %room = load i64, ptr %room.at
  %small = icmp ule i64 %size, %room
  %last = sub i64 %room, %size
  %offset = sub i64 %at, %start
  %inside = icmp ule i64 %offset, %last
  %fits = and i1 %small, %inside
  br i1 %fits, label %done, label %more
more:
  %next = add i64 %i, 1
  %none = icmp eq i64 %next, {{count}}
  br i1 %none, label %fault, label %try
fault:
  call void @"{FAULT}"(i64 %place)
  unreachable
done:
  ret void
}}
define internal void @check.block(ptr %p, i64 %size, i64 %place) {{
  %nothing = icmp eq i64 %size, 0
  br i1 %nothing, label %done, label %some
some:
  call void @check(ptr %p, i64 %size, i64 %place)
  br label %done
done:
  ret void
}}
"""


@dataclass(frozen=True, slots=True)
class Fault:
    """What a place of a module to run is for: a line, and what went wrong there."""

    loc: SourceLoc | None
    reason: str


@dataclass(frozen=True, slots=True)
class ReferenceText:
    """A module to run, whose kernel is `REFERENCE`; `faults` by the numbers that it reports."""

    text: str
    faults: tuple[Fault, ...]


def reference_text(text: str, name: str, locate: Locate) -> ReferenceText:
    """Write the module of a kernel.

    Parameters
    ----------
    text
        The file's module as LLVM prints it.
    name
        The kernel.
    locate
        Source lines of instructions.

    Raises
    ------
    KernelError
        The kernel holds what is not run on the host.
    """
    by_name = {body.name: body for body in bodies(text)}
    used = reachable(by_name[name], by_name)
    writer = _Writer(dict(_VARIABLE.findall(text)), locate, structs_of(text))
    writer.functions = {body.name: f"@f{number}" for number, body in enumerate(used)}
    writer.functions[name] = f'@"{REFERENCE}"'
    written = [part for body in used for part in writer.function(body, exported=body.name == name)]
    arrays = sum(type_ == "ptr" for _, type_ in signature(by_name[name].lines[0])[0])
    ranges = ["[2 x i64] zeroinitializer"] * arrays + writer.ranges
    count = max(len(ranges), 1)
    table = ", ".join(ranges) or "[2 x i64] zeroinitializer"
    parts = [
        *_STRUCT.findall(text),
        *writer.variables.values(),
        *writer.declarations.values(),
        f'@"{ARRAYS}" = global [{count} x [2 x i64]] [{table}]',
        _CHECK.replace("{count}", str(count)),
        *written,
    ]
    return ReferenceText("\n".join(parts), tuple(writer.faults))


@dataclass
class _Writer:
    """`known`: variables of the file by their tokens. The rest is what was written so far:
    variables and declarations by name, `ranges` of memory for the table, places of faults.
    """

    known: Mapping[str, str]
    locate: Locate
    structs: Structs
    functions: dict[str, str] = field(default_factory=dict)
    variables: dict[str, str] = field(default_factory=dict)
    declarations: dict[str, str] = field(default_factory=dict)
    ranges: list[str] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)
    names: dict[str, str] = field(default_factory=dict)
    place: SourceLoc | None = None
    sizes: int = 0

    def function(self, body: Body, *, exported: bool) -> Iterator[str]:
        header, *lines = body.lines
        self.place = self.locate.definition(header)
        params, returns = signature(header)
        listed = ", ".join(f"{type_} {_local(name)}" for name, type_ in params)
        extend = "zeroext " if returns == "i1" else ""
        yield f"define {'' if exported else 'internal '}{extend}{returns} "
        yield f"{self.functions[body.name]}({listed}) {{"
        for line in joined(lines[:-1]):
            code = without_strings(line)
            if not code.strip() or code.lstrip().startswith("#"):
                continue
            label = label_of(line)
            if label:
                yield f"{_local(label)[1:]}:"
                continue
            self.place = self.locate(line) or self.place
            yield from self.instruction(_without_metadata(line))
        yield "}"

    def instruction(self, line: str) -> Iterator[str]:
        cursor = Cursor(line)
        _demand_all_read(cursor)
        result = ""
        if cursor.peek[:1] == "%":
            result = _written_local(cursor.take()) + " = "
            cursor.expect("=")
        start = cursor.position
        cursor.skip_flags()
        opcode = cursor.take()
        if opcode == "call":
            yield from self._call(cursor, result)
        elif opcode in ("load", "store"):
            yield from self._access(cursor, result, opcode)
        elif opcode == "alloca":
            yield self._local_array(cursor, result)
        elif opcode == "unreachable":
            yield f'call void @"{FAULT}"(i64 {self._fault("reaches what C leaves undefined")})'
            yield "unreachable"
        elif opcode in _COMPUTES:
            yield result + self._renamed(cursor.tokens[start:])
        else:
            raise self._refused(f"`{opcode}`")

    def _refused(self, what: str, hint: str = _UNKNOWN_HINT) -> KernelError:
        return KernelError(f"{what} is not run on this computer", loc=self.place, hint=hint)

    def _fault(self, reason: str) -> int:
        fault = Fault(self.place, reason)
        if not self.faults or self.faults[-1] != fault:
            self.faults.append(fault)
        return len(self.faults) - 1

    def _access(self, cursor: Cursor, result: str, opcode: str) -> Iterator[str]:
        cursor.skip_flags()
        type_ = self._type(cursor)
        value = f" {self._value(cursor)}" if opcode == "store" else ""
        cursor.expect(",")
        pointer_type = self._type(cursor)
        pointer = self._value(cursor)
        if pointer_type != "ptr":
            raise self._refused("a pointer to another address space")
        place = self._fault("accesses memory outside its arrays")
        size = f"ptrtoint (ptr getelementptr ({type_}, ptr null, i32 1) to i64)"
        yield f"call void @check(ptr {pointer}, i64 {size}, i64 {place})"
        yield f"{result}{opcode} {type_}{value}, ptr {pointer}, align 1"

    def _local_array(self, cursor: Cursor, result: str) -> str:
        """A variable: no recursion is compiled, so it is needed once."""
        type_ = self._type(cursor)
        if cursor.accept(",") and cursor.peek != "align":
            raise self._refused("a local array of variable size")
        name = f"@a{len(self.ranges)}"
        self.variables[name] = f"{name} = internal global {type_} zeroinitializer, align 16"
        self._allow(name, type_)
        return f"{result}getelementptr i8, ptr {name}, i64 0"

    def _allow(self, name: str, type_: str) -> None:
        bytes_ = size_of(type_.replace(" ", ""), self.structs) or 0
        if bytes_ > _MAX_BYTES:
            hint = "pass it as a parameter"
            raise KernelError(f"a variable of {bytes_} bytes", loc=self.place, hint=hint)
        size = f"ptrtoint (ptr getelementptr ({type_}, ptr null, i32 1) to i64)"
        self.ranges.append(f"[2 x i64] [i64 ptrtoint (ptr {name} to i64), i64 {size}]")

    def _call(self, cursor: Cursor, result: str) -> Iterator[str]:
        cursor.skip_flags()
        type_ = self._type(cursor)
        while cursor.peek[:1] not in ("@", "%", ""):  # a calling convention, attributes
            cursor.skip_parentheses() if cursor.peek == "(" else None
            if cursor.peek[:1] not in ("@", "%", ""):
                type_ = self._type(cursor)
        callee = bare(cursor.take())
        arguments = list(self._arguments(cursor))
        if _SAYS_NOTHING.match(callee):
            return
        block = _BLOCK.fullmatch(callee)
        if block is not None:
            yield from self._block(block, arguments)
            return
        listed = ", ".join(f"{kind} {value}" for kind, value in arguments)
        target = self._callee(callee, type_, [kind for kind, _ in arguments])
        yield f"{result}call {type_} {target}({listed})"

    def _arguments(self, cursor: Cursor) -> Iterator[tuple[str, str]]:
        cursor.expect("(")
        while not cursor.accept(")"):
            type_ = self._type(cursor)
            if type_ == "metadata":
                while cursor.peek not in (",", ")"):
                    cursor.skip_parentheses() if cursor.peek == "(" else cursor.take()
            else:
                cursor.skip_attributes()
                yield type_, self._value(cursor)
            cursor.accept(",")

    def _callee(self, name: str, returns: str, types: list[str]) -> str:
        if name in self.functions:
            return self.functions[name]
        if _INTRINSIC.fullmatch(name):
            self.declarations[name] = f"declare {returns} @{name}({', '.join(types)})"
            return f"@{name}"
        single = name.removesuffix("f") in MATH and name not in MATH
        kind = "float" if single else "double"
        second = "i32" if name.startswith("ldexp") else kind
        if (single or name in MATH) and [returns, *types] in (
            [kind] * 2,
            [kind, kind, second],
            [kind] * 4,
        ):
            target = f'@"{HOST}{name}"'
            self.declarations[name] = f"declare {returns} {target}({', '.join(types)})"
            return target
        raise self._refused(f"a call of `{name}`", _HINT)

    def _block(self, block: re.Match[str], arguments: list[tuple[str, str]]) -> Iterator[str]:
        """Block operations, their size as 64 bits."""
        kind, length = block.groups()
        (_, target), (_, source), (_, size) = arguments[:3]
        place = self._fault("accesses memory outside its arrays")
        if length == "i32":
            self.sizes += 1
            yield f"%vividc.size.{self.sizes} = zext i32 {size} to i64"
            size = f"%vividc.size.{self.sizes}"
        for pointer in (target,) if kind == "memset" else (target, source):
            yield f"call void @check.block(ptr {pointer}, i64 {size}, i64 {place})"
        types = _BLOCK_TYPES[kind]
        callee = f"llvm.{kind}.p0{'' if kind == 'memset' else '.p0'}.i64"
        self.declarations[callee] = f"declare void @{callee}({', '.join(types)}, i64, i1)"
        yield (
            f"call void @{callee}({types[0]} {target}, {types[1]} {source}, i64 {size}, i1 false)"
        )

    def _type(self, cursor: Cursor) -> str:
        start = cursor.position
        cursor.type()
        return " ".join(cursor.tokens[start : cursor.position])

    def _value(self, cursor: Cursor) -> str:
        """A value of any kind: a name, a number, or a constant with what is in its brackets."""
        start = cursor.position
        while cursor.peek not in ("", ",", ")", "]", "}"):
            token = cursor.take()
            if token in _BRACKETS:
                _to_closing(cursor)
        return self._renamed(cursor.tokens[start : cursor.position])

    def _renamed(self, tokens: list[str]) -> str:
        return " ".join(self._name(token) for token in tokens)

    def _name(self, token: str) -> str:
        if token[:1] == "%":
            return _written_local(token)
        if token[:1] != "@":
            return token
        name = bare(token)
        return self.functions[name] if name in self.functions else self._variable(name)

    def _variable(self, name: str) -> str:
        if name not in self.names:
            definitions = [text for key, text in self.known.items() if bare(key) == name]
            if not definitions:  # a function that nothing calls: only its address is taken
                self.names[name] = f"inttoptr (i64 {_ODD_ADDRESS + len(self.names)} to ptr)"
                return self.names[name]
            cursor = Cursor(definitions[0])
            _demand_all_read(cursor)
            while cursor.peek not in ("global", "constant"):
                token = cursor.take()
                if token in _ODD_VARIABLE:
                    raise self._refused(_ODD_VARIABLE[token], _HINT)
                cursor.skip_parentheses()
            kind = cursor.take()
            type_ = self._type(cursor)
            ours = self.names[name] = f"@g{len(self.names)}"
            if cursor.peek in ("", ","):
                raise self._refused(f"`{name}` of another file", _HINT)
            value = self._value(cursor)
            self.variables[ours] = f"{ours} = internal {kind} {type_} {value}, align 16"
            self._allow(ours, type_)
        return self.names[name]


_BRACKETS = frozenset("([{<")


def _to_closing(cursor: Cursor) -> None:
    depth = 1
    while depth:
        token = cursor.take()
        depth += (token in _BRACKETS) - (token in (")", "]", "}", ">"))


def _demand_all_read(cursor: Cursor) -> None:
    """No token may be lost: the module would be another one."""
    if "".join("".join(cursor.tokens).split()) != "".join(cursor.text.split()):
        raise InternalError(f"cannot read LLVM's text: {cursor.text.strip()}")


def _without_metadata(line: str) -> str:
    """An instruction without what is attached to it, attribute groups and comments."""
    cut = _ATTACHED.search(_QUOTED.sub(lambda m: "_" * len(m[0]), line))
    return _GROUP.sub("", line[: cut.start()] if cut else line)


_QUOTED = re.compile(r'"[^"]*"')
_ATTACHED = re.compile(r";|, ![\w.]+ !")
_GROUP = re.compile(r" #\d+(?=[ ,]|$)")


def _written_local(token: str) -> str:
    return _local(bare(token)) if token[1:2] == '"' else token


def _local(name: str) -> str:
    if re.fullmatch(r"[-\w$.]+", name, re.ASCII):
        return f"%{name}"
    raw = name.encode(errors="surrogateescape")
    return '%"' + "".join(f"\\{byte:02X}" for byte in raw) + '"'

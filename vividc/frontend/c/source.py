"""A `.ll` file as text: what is not LLVM IR is refused, and every instruction gets a source line.

A module compiled with `-g` names lines of its C file. In one without, each instruction is made to
name its own line of the `.ll` file, so that either way an error has a place.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.c.places import nesting
from vividc.frontend.llvm.child.client import Late, Lost, ask
from vividc.frontend.llvm.tokens import bare, quoted_global
from vividc.host.inputs import SOURCE_BYTES, demand_utf8_path, read_bytes

MAX_DEPTH = 100
"""Of brackets within brackets."""
_READ_LIMIT_S = 20
_FORM = "write it with `clang -O1 -g -emit-llvm -S file.c -o file.ll`"
_BITCODE = (b"BC\xc0\xde", b"\xde\xc0\x17\x0b")
_DEFINE = re.compile(r'^define\b.*?(?P<name>@(?:"[^"]*"|[-\w.$]+))\(')
_IR = re.compile(
    r"^(?:(?:define|declare|target|source_filename|attributes)\b|[@%!]\S+ =)", re.MULTILINE
)
_TYPED = re.compile(r"(?:\bi\d+|\bfloat|\bdouble|\bvoid|[\])}>]|%[\w.]+)\*+(?=[\s,)])")
_TYPED_LINES = ("define", "declare", "load", "store", "getelementptr", "call")
_IDENT = re.compile(r'!\{!"([^"]*version[^"]*)"\}')
_DIRECTORY = re.compile(r'(!DIFile\(filename: "[^"]*", directory: ")([^"]*)"')
_TARGET = re.compile(r"^target (?:datalayout|triple)\b.*$", re.MULTILINE)
_UNOPTIMISED = re.compile(r"\b(?:noinline|optnone)\b")
_NUMBERED = re.compile(r"^!(\d+) =", re.MULTILINE)
_LOCATED = re.compile(r"!dbg !\d+ (?:.* )?\{$")
_PARSE_PLACE = re.compile(r"<string>:(\d+):\d+: error: (.*)")
_DEBUG = re.compile(r"^.*(?:llvm\.dbg\.|#dbg_).*$|,? !dbg !\d+", re.MULTILINE)
_PATH_HINT = "check the path; on the command line the form is FILE.ll:FUNCTION"
_QUOTED = re.compile(r'c?"(?:[^"\\]|\\.)*"')


@dataclass(frozen=True, slots=True)
class Body:
    """A function's definition: its name, and its lines from `define` to `}`, the first being line
    `first` of the text.
    """

    name: str
    first: int
    lines: tuple[str, ...]


def read_ll(path: Path) -> str:
    """Text of a `.ll` file.

    Raises
    ------
    KernelError
        Its path is not UTF-8; the file is missing, is larger than `SOURCE_BYTES`, is bitcode or no
        text of LLVM IR, or nests brackets deeper than `MAX_DEPTH`.
    """
    demand_utf8_path(path, KernelError)
    data = read_bytes(path, SOURCE_BYTES, KernelError, _PATH_HINT)
    if data.startswith(_BITCODE):
        raise KernelError("LLVM bitcode, not its text", loc=str(path), hint="give clang `-S` too")
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        raise KernelError("not LLVM IR: no text", loc=str(path), hint=_FORM) from error
    if not _IR.search(text):
        raise KernelError("not LLVM IR", loc=str(path), hint=_FORM)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise KernelError("a NUL byte", loc=_at(path, line), hint=_FORM)
    depth, line = nesting(text)
    if depth > MAX_DEPTH:
        reason = f"brackets nested {depth} deep, where {MAX_DEPTH} is the most"
        raise KernelError(reason, loc=_at(path, line), hint="flatten the type or the constant")
    return text


def _at(path: Path, line: int) -> SourceLoc:
    return SourceLoc(os.path.abspath(path), line)


def printed(text: str, path: Path) -> str:
    """A file's text as LLVM prints it, one instruction a line.

    Raises
    ------
    KernelError
        LLVM cannot read it, for example because its pointers have types.
    """
    _refuse_typed_pointers(text, path)
    text = _TARGET.sub("", text)
    try:
        return _read(text, path)
    except Lost:
        # Of broken debug information LLVM ends the process; of most else it says why.
        try:
            _read(_DEBUG.sub("", text.replace('"Debug Info Version"', '"version"')), path)
        except Lost as lost:
            reason = f"LLVM cannot read it: it dies ({str(lost) or 'an error'})"
            raise KernelError(reason, loc=str(path), hint=_FORM) from lost
    raise KernelError("its debug information cannot be read", loc=str(path), hint=_FORM)


def _read(text: str, path: Path) -> str:
    try:
        answer, _ = ask({"do": "read", "text": text}, limit_s=_READ_LIMIT_S)
    except Late as late:
        reason = f"LLVM takes more than {_READ_LIMIT_S} s to read it"
        raise KernelError(reason, loc=str(path), hint="give a smaller file") from late
    if "text" in answer:
        return str(answer["text"])
    match = _PARSE_PLACE.search(answer["error"])
    loc = _at(path, int(match[1])) if match else str(path)
    what = match[2] if match else " ".join(answer["error"].split())
    raise KernelError(f"not LLVM IR that can be read: {what}", loc=loc, hint=_FORM)


def _refuse_typed_pointers(text: str, path: Path) -> None:
    for number, line in enumerate(text.split("\n"), start=1):
        code = without_strings(line)
        if any(word in code for word in _TYPED_LINES) and _TYPED.search(code):
            ident = _IDENT.search(text)
            writer = f", written by {ident[1]}" if ident else ""
            raise KernelError(
                f"pointers with element types{writer}",
                loc=_at(path, number),
                hint="compile with clang 15 or newer, whose pointers are opaque (`ptr`)",
            )


def without_strings(line: str) -> str:
    """A line of IR without string constants, comment and metadata."""
    if line.lstrip().startswith((";", "!")):
        return ""
    return re.split(r";|, !", _QUOTED.sub('""', line), maxsplit=1)[0]


def bodies(text: str) -> Iterator[Body]:
    """Function definitions in the order of the file."""
    lines = text.split("\n")
    start, name = -1, ""
    for index, line in enumerate(lines):
        match = _DEFINE.match(line)
        if match is not None:
            start, name = index, bare(match["name"])
        elif line == "}" and start >= 0:
            yield Body(name, start + 1, tuple(lines[start : index + 1]))
            start = -1


def located_module(text: str, path: Path, places: Mapping[str, tuple[int, ...]]) -> str:
    """A module as LLVM prints it with a source line on every instruction, for the machine instead
    of the host; `places` as of `instruction_lines` of the file.

    Functions that clang left unoptimised (`-O0`) may be optimised.
    """
    folder = os.path.abspath(path.parent)
    text = _DIRECTORY.sub(lambda m: f'{m[1]}{_escaped(_absolute(m[2], folder))}"', text)
    lines = text.splitlines()
    lines = [
        _UNOPTIMISED.sub('"optimised"', x) if x.startswith("attributes #") else x for x in lines
    ]
    number = max((int(match[1]) for match in _NUMBERED.finditer(text)), default=-1) + 1
    unit, file, kind = number, number + 1, number + 2
    added: list[str] = []
    for body in bodies(text):
        if _LOCATED.search(body.lines[0]):
            continue
        where = places.get(body.name) or (1,)
        scope = number + 4 + len(added)
        name = quoted_global(body.name)[1:]
        added.append(
            f"!{scope} = distinct !DISubprogram(name: {name}, file: !{file}, "
            f"line: {where[0]}, type: !{kind}, unit: !{unit}, spFlags: DISPFlagDefinition)"
        )
        for index, line in _with_places(body, scope, number + 4, added, where):
            lines[index] = line
    return "\n".join([*lines, *(_unit(text, path, number) if added else ()), *added, ""])


def _absolute(directory: str, folder: str) -> str:
    """Where a relative path of clang's `-fdebug-compilation-dir` leads: beside the `.ll` file."""
    return os.path.normpath(os.path.join(folder, directory))


def _escaped(name: str) -> str:
    return name.replace("\\", "\\5C").replace('"', "\\22")


def _unit(text: str, path: Path, number: int) -> Iterator[str]:
    if "Debug Info Version" not in text:
        # Module flags are one list: this adds to it.
        yield f'!{number + 3} = !{{i32 2, !"Debug Info Version", i32 3}}'
        yield f"!llvm.module.flags = !{{!{number + 3}}}"
    yield f"!llvm.dbg.cu = !{{!{number}}}"
    yield (
        f"!{number} = distinct !DICompileUnit(language: DW_LANG_C99, file: !{number + 1}, "
        "emissionKind: LineTablesOnly)"
    )
    name, folder = _escaped(path.name), _escaped(os.path.abspath(path.parent))
    yield f'!{number + 1} = !DIFile(filename: "{name}", directory: "{folder}")'
    yield f"!{number + 2} = !DISubroutineType(types: !{{null}})"


def _with_places(
    body: Body, scope: int, first: int, added: list[str], where: tuple[int, ...]
) -> Iterator[tuple[int, str]]:
    """(line index, new line) of the definition and of each instruction; appends locations, the
    node before `added` being `first`.
    """
    start = body.first - 1
    yield start, f"{body.lines[0].removesuffix('{')}!dbg !{scope} {{"
    lines = iter(where[1:])
    place, in_switch = where[0], False
    for offset, line in enumerate(body.lines[1:-1], start=1):
        code = without_strings(line).strip()
        if not code or code.endswith(":") or code.startswith("#"):
            continue
        if not in_switch:
            place = next(lines, place)
        in_switch = code.endswith("[") or (in_switch and not code.startswith("]"))
        if in_switch:  # it goes on until its closing bracket
            continue
        yield start + offset, f"{_without_comment(line)}, !dbg !{first + len(added)}"
        added.append(
            f"!{first + len(added)} = !DILocation(line: {place}, column: 1, scope: !{scope})"
        )


def _without_comment(line: str) -> str:
    return line if '"' in line else line.partition(";")[0].rstrip()

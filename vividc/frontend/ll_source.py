"""A `.ll` file as text: what is not LLVM IR is refused, and every instruction gets a source line.

A module compiled with `-g` names lines of its C file. In one without, each instruction is made to
name its own line of the `.ll` file, so that either way an error has a place.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from vividc.errors import KernelError, SourceLoc

_FORM = "write it with `clang -O1 -g -emit-llvm -S file.c -o file.ll`"
_BITCODE = (b"BC\xc0\xde", b"\xde\xc0\x17\x0b")
_DEFINE = re.compile(r'^define\b.*?@(?:"(?P<quoted>[^"]*)"|(?P<name>[-\w.$]+))\(')
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
_LOCATED = re.compile(r"!dbg !\d+.*\{$")
_QUOTED = re.compile(r'c?"(?:[^"\\]|\\.)*"')


@dataclass(frozen=True, slots=True)
class Body:
    """A function's definition: its name, and its lines from `define` to `}`, the first being line
    `first` of the file.
    """

    name: str
    first: int
    lines: tuple[str, ...]


def read_ll(path: Path) -> str:
    """Text of a `.ll` file.

    Raises
    ------
    KernelError
        The file is missing, is bitcode or no LLVM IR, or has typed pointers.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        hint = "the form is FILE.ll:FUNCTION"
        raise KernelError(f"cannot be read: {error.strerror}", loc=str(path), hint=hint) from error
    if data.startswith(_BITCODE):
        raise KernelError("LLVM bitcode, not its text", loc=str(path), hint="give clang `-S` too")
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        raise KernelError("not LLVM IR: no text", loc=str(path), hint=_FORM) from error
    if not _IR.search(text):
        raise KernelError("not LLVM IR", loc=str(path), hint=_FORM)
    _refuse_typed_pointers(text, path)
    return text


def _refuse_typed_pointers(text: str, path: Path) -> None:
    for number, line in enumerate(text.splitlines(), start=1):
        code = without_strings(line)
        if any(word in code for word in _TYPED_LINES) and _TYPED.search(code):
            ident = _IDENT.search(text)
            writer = f", written by {ident[1]}" if ident else ""
            raise KernelError(
                f"pointers with element types{writer}",
                loc=SourceLoc(os.path.abspath(path), number),
                hint="compile with clang 15 or newer, whose pointers are opaque (`ptr`)",
            )


def without_strings(line: str) -> str:
    """A line of IR without string constants, comment and metadata."""
    if line.lstrip().startswith((";", "!")):
        return ""
    return re.split(r";|, !", _QUOTED.sub('""', line), maxsplit=1)[0]


def bodies(text: str) -> Iterator[Body]:
    """Function definitions in the order of the file."""
    lines = text.splitlines()
    start, name = -1, ""
    for index, line in enumerate(lines):
        match = _DEFINE.match(line)
        if match is not None:
            start, name = index, match["quoted"] or match["name"]
        elif line == "}" and start >= 0:
            yield Body(name, start + 1, tuple(lines[start : index + 1]))
            start = -1


def located_module(text: str, path: Path) -> str:
    """The module with a source line on every instruction, for the machine instead of the host.

    Lines keep their numbers. Functions that clang left unoptimised (`-O0`) may be optimised.
    """
    text = _TARGET.sub("", text)
    folder = os.path.abspath(path.parent)
    text = _DIRECTORY.sub(lambda m: f'{m[1]}{_escaped(_absolute(m[2], folder))}"', text)
    lines = text.splitlines()
    lines = [_UNOPTIMISED.sub("", x) if x.startswith("attributes #") else x for x in lines]
    number = max((int(match[1]) for match in _NUMBERED.finditer(text)), default=-1) + 1
    unit, file, kind = number, number + 1, number + 2
    added: list[str] = []
    for body in bodies(text):
        if re.search(r"!dbg !\d+ .*\{$|!dbg !\d+ \{$", body.lines[0]):
            continue
        scope = number + 4 + len(added)
        added.append(
            f'!{scope} = distinct !DISubprogram(name: "{body.name}", file: !{file}, '
            f"line: {body.first}, type: !{kind}, unit: !{unit}, spFlags: DISPFlagDefinition)"
        )
        for index, line in _with_places(body, scope, number + 4 + len(added), added):
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


def _with_places(body: Body, scope: int, first: int, added: list[str]) -> Iterator[tuple[int, str]]:
    """(line index, new line) of the definition and of each instruction; appends locations."""
    start = body.first - 1
    yield start, f"{body.lines[0].removesuffix('{')}!dbg !{scope} {{"
    open_at = 0
    for offset, line in enumerate(body.lines[1:-1], start=1):
        code = without_strings(line).strip()
        if code.endswith("["):  # a switch goes on until its closing bracket
            open_at = offset
            continue
        if open_at and not code.startswith("]"):
            continue
        if not code or code.endswith(":") or code.startswith("#"):
            continue
        place = body.first + (open_at or offset)
        yield start + offset, f"{_without_comment(line)}, !dbg !{first}"
        added.append(f"!{first} = !DILocation(line: {place}, column: 1, scope: !{scope})")
        first += 1
        open_at = 0


def _without_comment(line: str) -> str:
    return line if '"' in line else line.partition(";")[0].rstrip()

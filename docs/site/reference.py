"""Reference pages made of the code's own tables: commands, API, exit codes, opcodes, words."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import vividc
from vividc import arch, errors
from vividc.machine.opcodes import OPCODES
from vividc.program.words.layout import OPCODE_NUMBERS, word_layout

MODULES: Final = {
    "vividc": "Compile, simulate, advise: what most users need.",
    "vividc.arch": "Fabrics and accelerators.",
    "vividc.dfg": "Dataflow graphs: reading, writing, checking, interpreting.",
    "vividc.mapper": "Mapping graphs onto fabrics; adding mappers and constraints.",
    "vividc.launch": "Jobs on an accelerator: moves and runs.",
    "vividc.lang": "Operations for kernels that Python cannot express.",
    "vividc.gemm": "Matrix products and networks on systolic arrays.",
    "vividc.render": "Scenes, cameras, reference renderers.",
    "vividc.render.array": "The renderers on the array.",
    "vividc.paper": "The paper's tables and figures, measured again.",
    "vividc.errors": "Errors and warnings.",
    "vividc.formats": "FP16, E4M3 and E5M2: codes, values, rounding.",
}
"""Public modules, and what each is for."""
_SCHEMAS: Final = re.compile(
    r'^(?:SCHEMA|SIZED|NESTED)(?:: Final)? = "(vividc\.[\w.]+/\d+)"', re.MULTILINE
)
_LINK_OUT: Final = re.compile(r"\[([^\]]+)\]\(\.\./[^)]*\)")


def write(folder: Path) -> None:
    """Write the generated pages into a folder of the sources, those that have changed."""
    folder.mkdir(exist_ok=True)
    pages = {
        "cli": _cli(),
        "exit-codes": _exit_codes(),
        "schemas": _schemas(),
        "opcodes": _opcodes(),
        "words": _words(),
        "presets": _presets(),
        "api": _api(),
        **{f"api-{name}": _module(name, what) for name, what in MODULES.items()},
    }
    for name, lines in pages.items():
        text = "\n".join(lines) + "\n"
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def without_links_out(text: str) -> str:
    """The text with links that leave the documentation replaced by their words."""
    return _LINK_OUT.sub(r"\1", text)


def _cli() -> Iterator[str]:
    yield "# Commands"
    yield ""
    yield "`vividc COMMAND --help` prints the same. [Exit codes](exit-codes.md) and the"
    yield "[schemas](schemas.md) of `--json` have pages of their own."
    yield ""
    commands = importlib.import_module("vividc.cli.commands")
    for found in pkgutil.iter_modules(commands.__path__):
        yield "```{eval-rst}"
        yield f".. click:: vividc.cli.commands.{found.name}:command"
        yield f"   :prog: vividc {found.name}"
        yield "```"
        yield ""


def _exit_codes() -> Iterator[str]:
    yield "# Exit codes"
    yield ""
    yield "| code | raised as | when |"
    yield "|---|---|---|"
    yield "| 0 | | done |"
    seen: dict[int, list[type]] = {}
    for value in vars(errors).values():
        if isinstance(value, type) and issubclass(value, Exception) and hasattr(value, "exit_code"):
            seen.setdefault(value.exit_code, []).append(value)
    for code, classes in sorted(seen.items()):
        names = ", ".join(f"`{cls.__name__}`" for cls in classes)
        yield f"| {code} | {names} | {_first(classes[0].__doc__)} |"
    yield "| 5 | | `--check`: the results differ from numba's |"
    yield "| 130 | | interrupted (Ctrl-C) |"


def _schemas() -> Iterator[str]:
    yield "# Schemas of JSON"
    yield ""
    yield "The key `schema` of what `--json` prints and of files says which form they have; its"
    yield "number rises when a reader of before would misread it."
    yield ""
    yield "| schema | written by |"
    yield "|---|---|"
    root = Path(vividc.__file__).parent
    for path in sorted(root.rglob("*.py")):
        for schema in _SCHEMAS.findall(path.read_text(encoding="utf-8")):
            yield f"| `{schema}` | `{path.relative_to(root.parent)}` |"


def _opcodes() -> Iterator[str]:
    yield "# Opcodes"
    yield ""
    yield "What an FU can issue; `docs/machine.md` says how operands and results travel."
    yield "The number is that of the field `op` of a [configuration word](words.md)."
    yield ""
    yield "| opcode | number | operands | result | latency class |"
    yield "|---|---|---|---|---|"
    numbers = {op: number for number, op in enumerate(OPCODE_NUMBERS)}
    for op, info in OPCODES.items():
        operands = ", ".join(kind.value for kind in info.operands) or "-"
        result = "-" if info.result is None else info.result.value
        yield (
            f"| `{op.value}` | {numbers.get(op, '-')} | {operands} | {result} "
            f"| {info.latency_class.value} |"
        )


def _words() -> Iterator[str]:
    yield "# The configuration word"
    yield ""
    yield "Fields of `vivid-tile`'s word, the lowest bit first; other fabrics' follow from their"
    yield "numbers (`vividc.program.word_layout`). [machine.md](../machine.md) says what they do."
    yield ""
    yield "| field | lowest bit | bits |"
    yield "|---|---|---|"
    for field in word_layout(arch.load_tile("vivid-tile")).fields:
        yield f"| `{field.name}` | {field.offset} | {field.width} |"


def _presets() -> Iterator[str]:
    yield "# Presets"
    yield ""
    yield "| fabric | |"
    yield "|---|---|"
    for name in arch.preset_names():
        yield f"| `{name}` | {repr(arch.load_tile(name))[1:-1]} |"
    yield ""
    yield "| accelerator | |"
    yield "|---|---|"
    for name in arch.accelerator_names():
        yield f"| `{name}` | {repr(arch.load_accelerator(name))[1:-1]} |"


def _api() -> Iterator[str]:
    yield "# Python API"
    yield ""
    yield "What these modules list in `__all__` is public: CONTRIBUTING.md says what that promises."
    yield ""
    yield "```{toctree}"
    yield ":maxdepth: 1"
    yield ""
    yield from (f"api-{name}" for name in MODULES)
    yield "```"


def _module(name: str, what: str) -> Iterator[str]:
    yield f"# `{name}`"
    yield ""
    yield what
    yield ""
    yield "```{eval-rst}"
    yield f".. automodule:: {name}"
    yield "```"


def _first(text: str | None) -> str:
    """The first sentence of a docstring, on one line."""
    words = " ".join((text or "").split())
    return words.split(". ")[0].rstrip(".")

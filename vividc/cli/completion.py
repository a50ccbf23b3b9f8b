"""What a shell's TAB offers for values; nothing of a user's is run, and little is loaded."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from vividc import arch
from vividc.host.inputs import SOURCE_BYTES

Offer = list[str] | list[CompletionItem]


def fabric(_: click.Context, __: click.Parameter, incomplete: str) -> Offer:
    """Names of fabrics and accelerators."""
    families = [name.replace("RxC", "4x4") for name in arch.family_names()]
    return _beginning(incomplete, (*arch.preset_names(), *arch.accelerator_names(), *families))


def accelerator(_: click.Context, __: click.Parameter, incomplete: str) -> Offer:
    """Names of accelerators."""
    return _beginning(incomplete, arch.accelerator_names())


def mapper(_: click.Context, __: click.Parameter, incomplete: str) -> Offer:
    """Names of mappers."""
    from vividc.mapper import mapper_names  # noqa: PLC0415 - loads the solver

    return _beginning(incomplete, mapper_names())


def costs(_: click.Context, __: click.Parameter, incomplete: str) -> Offer:
    """Names of cost tables."""
    from vividc.arch.cost.tables import cost_table_names  # noqa: PLC0415

    return _beginning(incomplete, cost_table_names())


def precision(_: click.Context, __: click.Parameter, incomplete: str) -> Offer:
    """FUNCTION=, then its formats."""
    from vividc.ssa.formats.precision import ALL, FORMAT_NAMES, NAMES  # noqa: PLC0415

    name, equals, _rest = incomplete.partition("=")
    if not equals:
        return _beginning(incomplete, (f"{known}=" for known in (*NAMES, ALL)))
    return _beginning(incomplete, (f"{name}={fmt}" for fmt in FORMAT_NAMES))


def passes(_: click.Context, __: click.Parameter, incomplete: str) -> Offer:
    """The next of a list of passes."""
    from vividc.compiler.passes import (  # noqa: PLC0415 - loads the compiler
        FUNCTION_PASSES,
        GRAPH_PASSES,
        LLVM_PASSES,
    )

    before, comma, begun = incomplete.rpartition(",")
    known = _beginning(begun, dict.fromkeys((*FUNCTION_PASSES, *GRAPH_PASSES, *LLVM_PASSES)))
    return [f"{before}{comma}{one}" for one in known]


def kernel(_: click.Context, __: click.Parameter, incomplete: str) -> Offer:
    """Files, and behind a colon the kernels of a Python file, which is read and not run."""
    file, colon, _begun = incomplete.rpartition(":")
    if not colon:
        return [CompletionItem(incomplete, type="file")]
    return _beginning(incomplete, (f"{file}:{name}" for name in _kernels_in(Path(file))))


def _kernels_in(file: Path) -> list[str]:
    try:
        if file.suffix != ".py" or file.stat().st_size > SOURCE_BYTES:
            return []
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    functions = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    return [node.name for node in functions if any(map(_is_kernel, node.decorator_list))]


def _is_kernel(decorator: ast.expr) -> bool:
    called = decorator.func if isinstance(decorator, ast.Call) else None
    name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
    return name == "kernel"


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]

"""What was done to each source loop, as a table."""

from __future__ import annotations

from collections.abc import Iterator

import click

from vividc import arch
from vividc.arch import Accelerator
from vividc.cli.reports.report import print_table
from vividc.compiler.advice.advise import LEAST_GAIN, Hint
from vividc.frontend import KernelFunction, LLKernel
from vividc.program import Program
from vividc.program.tables import LoopReport, TransformReport


def print_loops(program: Program) -> None:
    """Print how each loop of the source runs, what binds it, and what was tried on it."""
    print_table(
        "Loops of the source",
        ("line", "runs", "cycles as written", "cycles now", "binds", "notes"),
        (_loop(loop) for loop in program.loops),
        numeric=("line",),
    )
    tried = [row for loop in program.loops for row in _transforms(loop)]
    if tried:
        print_table(
            "Transformations, with estimated cycles of the kernel",
            ("line", "transformation", "by", "before", "after", "verdict"),
            tried,
            numeric=("line", "by", "before", "after"),
        )


def print_advice(hints: tuple[Hint, ...]) -> None:
    """Print what would save cycles, most first."""
    if not hints:
        click.echo(f"no change is known that would save {LEAST_GAIN:.0%} of the estimated cycles")
        return
    print_table(
        f"What would save cycles, of {hints[0].before:,.0f} by estimate",
        ("saves", "line", "do", "option", "if"),
        (_hint(hint) for hint in hints),
        numeric=("saves", "line"),
    )


def _hint(hint: Hint) -> tuple[object, ...]:
    saved = f"{hint.saved:,.0f} ({hint.saved / hint.before:.0%})"
    return (
        f"up to {saved}" if hint.at_most else saved,
        None if hint.loc is None else hint.loc.line,
        hint.action,
        hint.option or None,
        hint.condition or None,
    )


def print_product(program: Program, kernel: KernelFunction | LLKernel, fabric: str) -> None:
    """Print in which mode an accelerator runs a kernel that is made of matrix products, or why it
    is not.
    """
    machine = arch.load(fabric)
    if not isinstance(machine, Accelerator):
        return
    from vividc.compiler.products import products_of  # noqa: PLC0415 - these load launches
    from vividc.gemm.kernels.choice import explain  # noqa: PLC0415

    told = explain(program, machine)
    if not told:
        found = products_of(kernel)
        told = f"no matrix product: {found.reason}"
        if found.products:
            text = "; ".join(product.text for product in found.products)
            told = (
                f"matrix product {text}, on the tiles: the kernel is more than that: {found.reason}"
            )
    click.echo(told)


def _loop(loop: LoopReport) -> tuple[object, ...]:
    return (
        None if loop.loc is None else loop.loc.line,
        loop.outcome,
        _number(loop.cycles_before),
        _number(loop.cycles_after),
        loop.binds or None,
        "; ".join(loop.notes) or None,
    )


def _transforms(loop: LoopReport) -> Iterator[tuple[object, ...]]:
    for item in loop.transforms:
        yield (
            None if loop.loc is None else loop.loc.line,
            item.kind,
            item.factor or None,
            f"{item.before:,.0f}",
            None if item.after is None else f"{item.after:,.0f}",
            _verdict(item),
        )


def _verdict(item: TransformReport) -> str:
    return "chosen" if item.chosen else item.reason


def _number(cycles: float | None) -> str | None:
    return None if cycles is None else f"{cycles:.4g}"

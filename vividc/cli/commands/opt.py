"""`vividc opt`: passes on a function in SSA form or on a graph, read as text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import click

from vividc.cli import completion
from vividc.cli.files import check_apart, check_output
from vividc.cli.stages import printable_lines
from vividc.compiler.passes import (
    FUNCTION_PASSES,
    GRAPH_PASSES,
    LLVM_PASSES,
    STAGES,
    problems_of,
    text_of,
)
from vividc.dfg.forms.text import parse as parse_graph
from vividc.errors import DFGError, InternalError, SSAError
from vividc.host.files import write_whole
from vividc.host.inputs import GRAPH_BYTES, read_text
from vividc.ssa.ir import Function
from vividc.ssa.text import parse as parse_function


@click.command("opt")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False), required=False)
@click.option(
    "--passes",
    default="",
    show_default=False,
    metavar="A,B,...",
    help="Run these, in this order.",
    shell_complete=completion.passes,
)
@click.option("--list", "listed", is_flag=True, help="List the stages and the passes, and stop.")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="File for the text.  [default: stdout]"
)
def command(file: Path | None, passes: str, listed: bool, output: Path | None) -> None:
    """Run passes on a function in SSA form or on a dataflow graph.

    FILE is text as `vividc compile --print-after` prints it: it begins with `function` or `dfg`.
    What the passes leave is checked after each of them.
    """
    if listed:
        _list()
        return
    if file is None:
        raise click.UsageError("Missing argument 'FILE' (or give --list).")
    if output is not None:
        check_output(output, "--output")
        check_apart({"--output": output}, [file])
    text = read_text(file, GRAPH_BYTES)
    made = _optimised(text, str(file), [name.strip() for name in passes.split(",") if name.strip()])
    if output is None:
        click.echo(printable_lines(text_of(made)), nl=False)
    else:
        write_whole(output, text_of(made).encode())


def _optimised(text: str, file: str, names: list[str]) -> object:
    """What the passes make of the text."""
    first = next(
        (line for line in text.split("\n") if line.strip() and line.lstrip()[0] != "#"), ""
    )
    is_graph = first.lstrip().startswith("dfg")
    made: Any = parse_graph(text, file) if is_graph else parse_function(text, file)
    for name in names:
        if not any(name in table for table in _tables(is_graph)):
            known = ", ".join(one for table in _tables(is_graph) for one in table)
            what = "graphs" if is_graph else "functions"
            raise click.UsageError(f"no pass on {what} is called {name!r}: {known}")
    problems = problems_of(made)
    if problems:
        error = DFGError if is_graph else SSAError
        raise error(f"it breaks an invariant: {problems[0]}", loc=file)
    for name in names:
        made = _pass_of(made, name, file)(made)
        problems = problems_of(made)
        if problems:
            raise InternalError(f"{name} broke an invariant: {'; '.join(problems)}")
    return made


def _tables(is_graph: bool) -> tuple[Mapping[str, Callable[[Any], Any]], ...]:
    return (GRAPH_PASSES,) if is_graph else (LLVM_PASSES, FUNCTION_PASSES)


def _pass_of(made: object, name: str, file: str) -> Callable[[Any], Any]:
    """The pass of that name, which works on what was made."""
    if not isinstance(made, Function):
        return GRAPH_PASSES[name]
    table = LLVM_PASSES if made.is_llvm else FUNCTION_PASSES
    if name in table:
        return table[name]
    is_now, wanted = ("LLVM's", "words") if made.is_llvm else ("words", "LLVM's")
    raise SSAError(
        f"{name} works on {wanted}, and the function's operations are {is_now}", loc=file
    )


def _list() -> None:
    click.echo("Stages, for --print-after and --stop-after:")
    for stage in STAGES:
        click.echo(f"  {stage.name:32}{stage.leaves.__name__:10}{stage.does}")
    click.echo("Passes on functions with LLVM's operations, for --passes:")
    click.echo(f"  {', '.join(LLVM_PASSES)}")
    click.echo("Passes on functions of words:")
    click.echo(f"  {', '.join(FUNCTION_PASSES)}")
    click.echo("Passes on graphs:")
    click.echo(f"  {', '.join(GRAPH_PASSES)}")

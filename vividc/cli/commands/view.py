"""`vividc view`: a program as a page for a browser."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Final

import click

import vividc
from vividc.cli import options
from vividc.cli.arrays import read_arguments
from vividc.cli.files import check_apart, check_output
from vividc.cli.reference import scalars_unpacked
from vividc.cli.reports.report import print_json
from vividc.host.files import write_whole
from vividc.host.progress import progress
from vividc.machine.params import given
from vividc.page.runs import WINDOW
from vividc.page.write import page

SCHEMA: Final = "vividc.view/1"


@click.command("view")
@click.argument("program", metavar="P.vivid", type=options.FILE)
@click.option(
    "-o", "--output", type=options.FILE, metavar="P.html", help="[default: beside P.vivid]"
)
@click.option(
    "--inputs",
    type=options.FILE,
    metavar="IN.npz",
    help="Run it, too: the kernel's arguments, by parameter name.",
)
@click.option(
    "--cycles",
    callback=options.window,
    metavar="FIRST:END",
    help="Cycles of the run that are recorded. [default: {}:{}]".format(*WINDOW),
)
@click.option(
    "--source",
    type=options.FILE,
    metavar="FILE",
    help="The kernel's source, if it is not the file that was compiled, or was changed since.",
)
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
@options.as_json
def command(
    program: Path,
    output: Path | None,
    inputs: Path | None,
    cycles: tuple[int, int] | None,
    source: Path | None,
    opens: bool,
    as_json: bool,
) -> None:
    """Show a program, and a run of it, as one HTML page that works offline.

    The page has the source with its hot lines, each region's dataflow graph, the array context by
    context, the schedule in time and space, and what binds; with --inputs, a run cycle by cycle.
    Nothing in P.vivid is executed on this computer.
    """
    if cycles is not None and inputs is None:
        raise click.UsageError("--cycles needs --inputs")
    path = program.with_suffix(".html") if output is None else output
    check_output(path, "--output")
    read = [file for file in (program, inputs, source) if file is not None]
    check_apart({"--output": path}, read)
    loaded = vividc.load(program)
    args = None
    if inputs is not None:
        params = given(loaded.params)
        args = scalars_unpacked(read_arguments(inputs, params), params)
    with progress(f"drawing {loaded.name}"):
        text = page(loaded, args, cycles=cycles or WINDOW, source=source, folder=program.parent)
    data = text.encode()
    write_whole(path, data)
    if as_json:
        print_json(SCHEMA, {"program": str(program), "output": str(path), "bytes": len(data)})
    else:
        click.echo(f"written: {path}")
    if opens:
        webbrowser.open(path.resolve().as_uri())

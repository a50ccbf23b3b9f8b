"""`vividc compile`: from a kernel in a Python or `.ll` file to a `.vivid` program."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

import vividc
from vividc.cli import completion, options
from vividc.cli.files import check_apart, check_output, make_folder
from vividc.cli.kernels import kernel_file, load_kernel
from vividc.cli.loops import loop_options
from vividc.cli.reports.binds import what_binds
from vividc.cli.reports.loop import print_advice, print_loops, print_product
from vividc.cli.reports.program import print_regions
from vividc.cli.reports.report import print_json
from vividc.cli.stages import Look, look_options
from vividc.dfg import to_dot, to_json
from vividc.frontend import KernelFunction, LLKernel
from vividc.gemm.modes import MODES
from vividc.host.files import write_whole
from vividc.host.progress import progress
from vividc.machine.params import sizes_text
from vividc.program import Program

SCHEMA = "vividc.compile/1"
_NOT_PLANNED = ("mapper", "mode", "cache")
"""Options that no plan depends on."""


@click.command("compile")
@click.argument("kernel", metavar="FILE[:KERNEL]", shell_complete=completion.kernel)
@options.fabric
@options.mapper
@options.time_limit
@options.effort("normal")
@click.option(
    "--strict-fp", is_flag=True, help="Refuse float64 arithmetic instead of narrowing it."
)
@click.option(
    "--contract/--no-contract",
    default=True,
    help="Fuse a multiplication and an addition into one operation with one rounding.",
)
@click.option(
    "--reassociate", is_flag=True, help="Balance sums of floats, which changes their rounding."
)
@loop_options
@click.option(
    "--precision",
    multiple=True,
    metavar="FUNCTION=FORMAT",
    callback=options.formats,
    shell_complete=completion.precision,
    help="Compute exp, exp2, fma (arithmetic) or all in fp16, fp8, e5m2 or fp32.",
)
@click.option(
    "--mode",
    type=click.Choice(["auto", "gpu", *MODES]),
    default="auto",
    help="How an accelerator runs a kernel that is a matrix product.",
)
@click.option(
    "--sizes",
    "like",
    multiple=True,
    metavar="NAME=SIZE,...",
    callback=options.sizes,
    help="Shapes and integers, as in A=20x30,n=16, of every launch: they become constants.",
)
@click.option(
    "--explain",
    is_flag=True,
    help="Say what was done to each loop, and why, and what would save cycles; takes up to as long "
    "again.",
)
@click.option(
    "-o", "--output", type=options.FILE, metavar="OUT.vivid", help="[default: KERNEL.vivid]"
)
@click.option(
    "--cache/--no-cache",
    default=True,
    help="Take the program from the cache if the same was compiled before, and keep it there.",
)
@click.option(
    "--dfg",
    "graphs",
    type=options.FOLDER,
    metavar="DIR",
    help="Write each region's dataflow graph: NAME.dot and NAME.json.",
)
@click.option(
    "--plot",
    "pictures",
    type=options.FOLDER,
    metavar="DIR",
    help="Draw each region's graph and mapping: NAME-dfg.svg and NAME-mapping.svg.",
)
@look_options
@options.as_json
def command(
    kernel: str,
    fabric: str,
    explain: bool,
    output: Path | None,
    graphs: Path | None,
    pictures: Path | None,
    as_json: bool,
    look: Look,
    **how: Any,
) -> None:
    """Compile a kernel for a fabric and write the program.

    FILE is a Python file, which is run to find its kernels, or a `.ll` file, as `clang -O1 -g
    -emit-llvm -S` writes it, and KERNEL a C function in it. KERNEL may be left out if there is one.
    """
    if as_json and look.prints:
        raise click.UsageError(
            "--json prints one object: give --print-to a folder, or leave it out"
        )
    function = load_kernel(kernel)
    path = Path(f"{function.name}.vivid") if output is None else output
    check_output(path, "--output")
    check_apart({"--output": path}, [kernel_file(kernel), Path(fabric)])
    for option, folder in (("--dfg", graphs), ("--plot", pictures)):
        if folder is not None:
            make_folder(folder, option)
    with progress(f"compiling {function.name}") as report, look.watching() as done:
        # what is not named here has the name of the keyword
        program = vividc.compile(function, fabric, progress=report, **how)
    if done.stopped:
        return
    program.save(path)
    _write_regions(program, graphs, pictures)
    hints = _hints(function, fabric, program, how) if explain else None
    if as_json:
        print_json(SCHEMA, {**_as_object(program, path), "advice": _as_objects(hints)})
        return
    print_regions(program)
    if program.sizes:
        click.echo(f"for {sizes_text(program.sizes)} only")
    if hints is not None:
        print_loops(program)
        print_product(program, function, fabric)
        print_advice(hints)
    for written in (path, graphs, pictures):
        if written is not None:
            click.echo(f"written: {written}")


def _write_regions(program: Program, graphs: Path | None, pictures: Path | None) -> None:
    """Write graphs and pictures of regions, by their number and name."""
    for number, region in enumerate(program.regions):
        name = f"{number}-{region.name}"
        if graphs is not None:
            text = json.dumps(to_json(region.dfg), indent=1) + "\n"
            write_whole(graphs / f"{name}.json", text.encode())
            write_whole(graphs / f"{name}.dot", to_dot(region.dfg).encode())
        if pictures is not None:
            region.dfg.plot(pictures / f"{name}-dfg.svg")
            if region.mapping is not None:
                region.mapping.plot(pictures / f"{name}-mapping.svg")


def _hints(
    kernel: KernelFunction | LLKernel, fabric: str, program: Program, how: dict[str, Any]
) -> tuple[vividc.Hint, ...]:
    """What would save cycles; of the options those that a plan depends on."""
    given = {name: value for name, value in how.items() if name not in _NOT_PLANNED}
    with progress(f"planning {kernel.name} with other options") as report:
        return vividc.advise(kernel, fabric, program=program, progress=report, **given)


def _as_objects(hints: tuple[vividc.Hint, ...] | None) -> list[dict[str, object]] | None:
    if hints is None:
        return None
    return [
        {**asdict(hint), "loc": None if hint.loc is None else str(hint.loc), "saved": hint.saved}
        for hint in hints
    ]


def _as_object(program: Program, path: Path) -> dict[str, object]:
    return {
        "kernel": program.name,
        "fabric": program.fabric_name,
        "output": str(path),
        "regions": [
            {
                "name": region.name,
                "kind": region.kind,
                "loc": None if region.loc is None else str(region.loc),
                "ii": region.ii,
                "mii": region.mii,
                "lower_bound": region.lower_bound,
                "status": region.status,
                "utilization": region.utilization,
                "operations": region.operations,
                "bounds": [
                    {"name": bound.name, "ii": bound.ii, "reason": bound.reason}
                    for bound in region.bounds
                ],
                "binds": what_binds(region),
                "refuted": [{"ii": item.ii, "by": item.by} for item in region.refuted],
                "memory_order_assumed": region.rests_on_assumed,
                "wall_s": region.wall_s,
            }
            for region in program.regions
        ],
        "loops": [
            {
                **asdict(loop),
                "loc": None if loop.loc is None else str(loop.loc),
                "memory_order_assumed": loop.rests_on_assumed,
            }
            for loop in program.loops
        ],
        "sizes": program.sizes,
        "products": None if program.products is None else asdict(program.products),
        "stopped_by_clock": program.hurried,
        "warnings": [str(warning) for warning in program.warnings],
    }

"""`vividc simulate`: runs a program on the machine, and compares it with the host if asked."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click
import numpy as np

import vividc
from vividc.arch import Accelerator, load_accelerator
from vividc.cli import completion, options
from vividc.cli.arrays import RETURN_KEY, Array, read_arguments, write_results
from vividc.cli.files import check_apart, check_output
from vividc.cli.reference import (
    Mismatch,
    Tolerance,
    find_kernel,
    mismatches,
    run_reference,
    scalars_unpacked,
)
from vividc.cli.reports.cycle_progress import cycle_progress
from vividc.cli.reports.job import print_job
from vividc.cli.reports.report import percent, print_json, print_table
from vividc.cli.reports.views import Views, view_options
from vividc.gemm.kernels.choice import accelerator_of
from vividc.host.progress import progress
from vividc.launch import JobResult
from vividc.machine.params import given
from vividc.program import CUT_SHORT, Program
from vividc.sim import AUTO, CYCLE_LIMIT, ENGINES, Result
from vividc.sim.run import shown, simulate
from vividc.ssa.results import named_leaves

SCHEMA = "vividc.simulate/1"
MISMATCH: Final = 5


@click.command("simulate")
@click.argument("program", metavar="P.vivid", type=options.FILE)
@click.option(
    "--inputs",
    type=options.FILE,
    required=True,
    metavar="IN.npz",
    help="The kernel's arguments, by parameter name.",
)
@click.option(
    "--outputs",
    type=options.FILE,
    metavar="OUT.npz",
    help="Write the arrays after the run, and the returned value as `return`, parts of a tuple as "
    "`return0`, `return1`, and so on.",
)
@click.option(
    "--check",
    is_flag=True,
    help="Run the kernel's source on this computer (numba, or LLVM for C), and compare.",
)
@click.option(
    "--source",
    "--kernel",
    "source",
    metavar="FILE[:KERNEL]",
    shell_complete=completion.kernel,
    help="The source that --check runs, if it is not the file that was compiled.",
)
@click.option("--rtol", type=float, callback=options.finite, default=1e-5, metavar="R")
@click.option("--atol", type=float, callback=options.finite, default=1e-6, metavar="A")
@click.option(
    "--cycle-limit",
    type=click.IntRange(min=1),
    default=CYCLE_LIMIT,
    metavar="N",
    help="Stop the run after N cycles.",
)
@click.option(
    "--engine",
    type=click.Choice([*ENGINES]),
    default=AUTO,
    help="Native code, the reference engine, or whichever is likely to finish first.",
)
@view_options
@click.option(
    "--fabric",
    metavar="F",
    help="An accelerator (vivid, vivid-unit, or a YAML file): spread loops over its tiles. "
    "[default: what P.vivid was compiled for]",
    shell_complete=completion.accelerator,
)
@options.as_json
def command(
    program: Path,
    inputs: Path,
    outputs: Path | None,
    check: bool,
    source: str | None,
    rtol: float,
    atol: float,
    cycle_limit: int,
    engine: str,
    fabric: str | None,
    as_json: bool,
    views: Views,
) -> None:
    """Run a program on the machine, cycle by cycle.

    Nothing in P.vivid is executed on this computer. With --check, the kernel's source is: the file
    that P.vivid names, if you compiled it here and it has not changed since, or the one that
    --source names; which one is said first. Floats may differ by ATOL + RTOL times the reference,
    integers not at all; a mismatch gives exit code 5.
    """
    _refuse_nonsense(source, check, fabric, views)
    _check_outputs(outputs, views, (program, inputs))
    loaded = vividc.load(program)
    arguments = read_arguments(inputs, given(loaded.params))
    host = find_kernel(loaded, program, source) if check else None
    # The run changes the arguments in place, and the host needs them as they were.
    copies = {name: array.copy() for name, array in arguments.items()}
    machine = _machine_of(loaded, fabric, views)
    job = None
    if machine is not None:
        job = _simulate_job(loaded, arguments, cycle_limit, engine, machine)
    result = _simulate(loaded, arguments, cycle_limit, engine, views) if job is None else job
    # Last: the host checks no index, and an access that the run refuses would destroy its memory.
    expected = None if host is None else _with_value(*run_reference(host, copies))
    if outputs is not None:
        write_results(outputs, arguments, result.value)
    views.write(loaded, result, machine)
    wrong = _compare(arguments, result, expected, Tolerance(rtol, atol))
    if as_json:
        body = _as_object(loaded, result, outputs, expected is not None, wrong)
        print_json(SCHEMA, {**body, **_shown(loaded, result, machine, views)})
    else:
        _print(loaded, result, machine, views)
        _print_outcome(loaded, result, outputs, expected is not None, wrong)
    for item in wrong:
        click.echo(f"vividc: mismatch: {item}", err=True)
    if wrong:
        raise click.exceptions.Exit(MISMATCH)


def _refuse_nonsense(source: str | None, check: bool, fabric: str | None, views: Views) -> None:
    if source is not None and not check:
        raise click.UsageError("--source needs --check")
    if fabric is not None and {"vcd", "plot"} & views.files.keys():
        raise click.UsageError("--vcd and --plot show the cycles of one tile, not --fabric's")


def _machine_of(program: Program, fabric: str | None, views: Views) -> Accelerator | None:
    """The accelerator to run on; None: one tile, of which alone --vcd and --plot can show all."""
    if fabric is not None:
        return load_accelerator(fabric)
    return None if {"vcd", "plot"} & views.files.keys() else accelerator_of(program)


def _check_outputs(outputs: Path | None, views: Views, inputs: tuple[Path, ...]) -> None:
    written = {f"--{name}": path for name, path in views.files.items()}
    if outputs is not None:
        check_output(outputs, "--outputs")
        written["--outputs"] = outputs
    check_apart(written, inputs)


def _shown(
    program: Program, result: Result | JobResult, machine: Accelerator | None, views: Views
) -> dict[str, object]:
    shown = views.as_object(program, result, machine)
    return shown if machine is None else {**shown, "fabric": machine.name}


def _print(
    program: Program, result: Result | JobResult, machine: Accelerator | None, views: Views
) -> None:
    if isinstance(result, JobResult):
        print_job(program, "" if machine is None else machine.name, result)
    else:
        _print_regions(program, result)
    if program.hurried:
        click.echo(f"compiling {CUT_SHORT}")
    views.print(program, result, machine)


def _simulate(
    program: Program, arguments: dict[str, Array], cycle_limit: int, engine: str, views: Views
) -> Result:
    values = scalars_unpacked(arguments, given(program.params))
    views.record(program, values)
    observer = None if views.trace is None else views.timeline.add
    with cycle_progress(f"simulating {program.name}") as report:
        return simulate(
            program,
            *values,
            progress=report,
            cycle_limit=cycle_limit,
            engine=engine,
            observer=observer,
        )


def _simulate_job(
    program: Program,
    arguments: dict[str, Array],
    cycle_limit: int,
    engine: str,
    machine: Accelerator,
) -> JobResult:
    values = scalars_unpacked(arguments, given(program.params))
    with progress(f"simulating {program.name} on {machine.name}"):
        return vividc.simulate(
            program, *values, fabric=machine, cycle_limit=cycle_limit, engine=engine
        )


def _with_value(arguments: dict[str, Array], value: object) -> dict[str, Array]:
    return {**arguments, **dict(named_leaves(value, RETURN_KEY))}


def _compare(
    arguments: dict[str, Array],
    result: Result | JobResult,
    expected: dict[str, Array] | None,
    tolerance: Tolerance,
) -> list[Mismatch]:
    if expected is None:
        return []
    return mismatches(_with_value(arguments, result.value), expected, tolerance)


def _as_object(
    program: Program,
    result: Result | JobResult,
    outputs: Path | None,
    checked: bool,
    wrong: list[Mismatch],
) -> dict[str, object]:
    return {
        "kernel": program.name,
        "fabric": program.fabric_name,
        "stopped_by_clock": program.hurried,
        "cycles": result.cycles,
        "value": _plain(result.value),
        "stats": result.stats,
        "check": {"passed": not wrong, "mismatches": wrong} if checked else None,
        "outputs": None if outputs is None else str(outputs),
    }


def _plain(value: object) -> object:
    """What JSON can hold."""
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def _print_regions(program: Program, result: Result) -> None:
    stats = result.stats
    columns = ("region", "kind", "II", "entries", "iterations", "cycles", "stalls", "use")
    rows = [
        (
            region["name"],
            region["kind"],
            region["ii"],
            region["entries"],
            region["iterations"],
            region["cycles"],
            sum(region["stalls"].values()),
            percent(region["utilization"]),
        )
        for region in stats["regions"]
    ]
    title = f"{program.name} on {program.fabric_name}"
    print_table(
        title, columns, rows, numeric=("II", "entries", "iterations", "cycles", "stalls", "use")
    )
    brought, between = stats["reload_cycles"], f"{stats['switch_cycles']} between regions"
    between += f", {brought} of them to bring contexts" if brought else ""
    click.echo(f"cycles: {result.cycles} ({between})")


def _print_outcome(
    program: Program,
    result: Result | JobResult,
    outputs: Path | None,
    checked: bool,
    wrong: list[Mismatch],
) -> None:
    if result.value is not None:
        click.echo(f"value: {shown(result.value)}")
    if checked and not wrong:
        in_c = program.provenance.kernel_file.endswith(".ll")
        click.echo(f"check: agrees with {'LLVM on this computer' if in_c else 'numba'}")
    if outputs is not None:
        click.echo(f"written: {outputs}")

"""What `vividc simulate` shows besides results: energy, traces, value changes, pictures."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import wraps
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from vividc.arch import Accelerator
from vividc.arch.cost.tables import DEFAULT_TABLE, CostTable, load_costs
from vividc.cli import completion, options
from vividc.cli.files import check_output
from vividc.cli.reports.energy import print_energy
from vividc.errors import VividcError
from vividc.host.files import write_whole
from vividc.host.plot import Picture, check_picture_path, encode
from vividc.launch import JobResult
from vividc.launch.cost import job_roofline, work_of_job
from vividc.program import Program
from vividc.sim import Result
from vividc.sim.cost import EnergyReport, energy, work_of
from vividc.sim.view import (
    Timeline,
    heat_map,
    job_trace,
    record,
    roofline,
    run_trace,
    tile_points,
    tile_roof,
    to_vcd,
)

_LONGEST_VCD: Final = 100_000
_LONGEST_HEAT_MAP: Final = 2_000_000
_R = TypeVar("_R")


@dataclass(frozen=True)
class Views:
    """The views asked for. `timeline` fills while the program runs."""

    trace: Path | None
    vcd: Path | None
    plot: Path | None
    roofline: Path | None
    window: tuple[int, int]
    costs: CostTable | None
    node_nm: float | None
    timeline: Timeline = field(default_factory=Timeline)

    @property
    def files(self) -> dict[str, Path]:
        """What is to be written, by option."""
        paths = {
            "trace": self.trace,
            "vcd": self.vcd,
            "plot": self.plot,
            "roofline": self.roofline,
        }
        return {name: path for name, path in paths.items() if path is not None}

    def check(self) -> None:
        """Refuse what cannot be written, before anything runs.

        Raises
        ------
        VividcError
            A path cannot be written, or the window is too long.
        """
        for name, path in self.files.items():
            if name in ("plot", "roofline"):
                check_picture_path(path, f"--{name}")
            check_output(path, f"--{name}")
        length = self.window[1] - self.window[0]
        for name, most in (("vcd", _LONGEST_VCD), ("plot", _LONGEST_HEAT_MAP)):
            if name in self.files and length > most:
                raise VividcError(
                    f"{length:,} cycles are more than --{name} takes, {most:,}",
                    loc="--window",
                    hint="name the cycles of interest: --window FIRST:END",
                )

    def record(self, program: Program, values: Sequence[object]) -> None:
        """Write what needs every cycle; before the run, which changes the arrays."""
        if self.vcd is None and self.plot is None:
            return
        words = self.vcd is not None
        recording = record(program, values, {}, window=self.window, words=words)
        if recording.end <= self.window[0] and recording.stopped is None:
            raise VividcError(
                f"the run ends before cycle {self.window[0]:,}",
                loc="--window",
                hint="name cycles of the run: --window FIRST:END",
            )
        if self.vcd is not None:
            _write(self.vcd, to_vcd(recording))
        if self.plot is not None:
            _draw(self.plot, heat_map(recording))

    def write(
        self, program: Program, result: Result | JobResult, machine: Accelerator | None
    ) -> None:
        """Write what the run itself tells; `machine`: the accelerator of a job."""
        if self.trace is not None:
            trace = self._trace_of(program, result, machine)
            _write(self.trace, json.dumps(trace, allow_nan=False) + "\n")
        if self.roofline is not None:
            _draw(self.roofline, _roofline_of(program, result, machine))

    def energy(
        self, program: Program, result: Result | JobResult, machine: Accelerator | None
    ) -> EnergyReport | None:
        """The run's energy, if asked for."""
        if self.costs is None:
            return None
        if isinstance(result, JobResult):
            assert machine is not None
            tiles = len(machine.tiles)
            work = work_of_job(result.stats, tiles)
        else:
            work = work_of(result.stats)
        return energy(work, program.fabric, self.costs, node_nm=self.node_nm)

    def as_object(
        self, program: Program, result: Result | JobResult, machine: Accelerator | None
    ) -> dict[str, object]:
        """What the JSON object says of the views."""
        return {
            "energy": self.energy(program, result, machine),
            "views": {name: str(path) for name, path in self.files.items()},
        }

    def print(
        self, program: Program, result: Result | JobResult, machine: Accelerator | None
    ) -> None:
        """Print the views that are text."""
        report = self.energy(program, result, machine)
        if report is not None:
            print_energy(report)
        for path in self.files.values():
            click.echo(f"written: {path}")

    def _trace_of(
        self, program: Program, result: Result | JobResult, machine: Accelerator | None
    ) -> dict[str, object]:
        if isinstance(result, JobResult):
            assert machine is not None
            clock = program.fabric.clock_ghz
            return job_trace(result.events, name=machine.name, clock_ghz=clock)
        return run_trace(program, self.timeline.spans, dropped=self.timeline.dropped)


def _roofline_of(
    program: Program, result: Result | JobResult, machine: Accelerator | None
) -> Picture:
    if isinstance(result, JobResult):
        assert machine is not None
        return job_roofline(machine, result.stats, program.name)
    points = tile_points(result.stats, program.name)
    title = f"{program.name} on {program.fabric_name}: roofline"
    return roofline(points, len(program.fabric.pes), [tile_roof(program)], title)


def view_options(command: Callable[..., _R]) -> Callable[..., _R]:
    """The options, handed to the command as one argument `views`."""

    @wraps(command)
    def wrapper(*args: Any, **kwargs: Any) -> _R:  # click's own: one argument an option
        asked, table = kwargs.pop("energy"), kwargs.pop("costs")
        node = kwargs.pop("node")
        if not asked and (table is not None or node is not None):
            raise click.UsageError("--costs and --node need --energy")
        costs = load_costs(str(table or DEFAULT_TABLE)) if asked else None
        names = ("trace", "vcd", "plot", "roofline", "window")
        given: dict[str, Any] = {name: kwargs.pop(name) for name in names}
        views = Views(**given, costs=costs, node_nm=node)
        views.check()
        return command(*args, views=views, **kwargs)

    for option in reversed(_OPTIONS):
        wrapper = option(wrapper)
    return wrapper


_OPTIONS: Final = (
    click.option("--energy", is_flag=True, help="Report energy, from a cost table with sources."),
    click.option(
        "--costs",
        metavar="TABLE",
        help=f"Cost table, by name or YAML file. [{DEFAULT_TABLE}]",
        shell_complete=completion.costs,
    ),
    click.option(
        "--node",
        type=float,
        callback=options.node,
        metavar="NM",
        help="Node to scale energy to, 7 to 45.",
    ),
    click.option(
        "--trace", type=options.FILE, metavar="T.json", help="Write a trace for Perfetto."
    ),
    click.option(
        "--vcd", type=options.FILE, metavar="T.vcd", help="Write a waveform of the window's cycles."
    ),
    click.option(
        "--plot",
        type=options.FILE,
        metavar="PICTURE",
        help="Draw which PEs are in use (.svg, .png).",
    ),
    click.option(
        "--roofline", type=options.FILE, metavar="PICTURE", help="Draw the roofline (.svg, .png)."
    ),
    click.option(
        "--window",
        default="0:2000",
        callback=options.window,
        metavar="FIRST:END",
        help="Cycles for --vcd and --plot, which run on the reference engine up to END.",
    ),
)


def _write(path: Path, text: str) -> None:
    write_whole(path, text.encode())


def _draw(path: Path, picture: Picture) -> None:
    write_whole(path, encode(picture, path))

"""What `vividc simulate --fabric` prints about a job on an accelerator."""

from __future__ import annotations

import click

from vividc.cli.reports.report import percent, print_table
from vividc.launch import JobResult
from vividc.program import Program


def print_job(program: Program, fabric: str, result: JobResult) -> None:
    """Where the cycles of each tile went, and the bytes that moved."""
    stats = result.stats
    uses = [name for name, count in stats["cycles_by_use"].items() if count]
    causes = [name for name, count in stats["stalls"].items() if count]
    columns = ("tile", "runs", *uses, *causes, "utilization")
    rows = [
        (
            tile["tile"],
            tile["runs"],
            *(tile["cycles"][name] for name in uses),
            *(tile["stalls"][name] for name in causes),
            percent(tile["utilization"]),
        )
        for tile in stats["tiles"]
    ]
    title = f"{program.name} on {fabric}: cycles of each tile"
    print_table(title, columns, rows, numeric=columns)
    moved = stats["bytes"]
    click.echo(
        f"DRAM: {moved['dram_read']} bytes read, {moved['dram_written']} written, busy for "
        f"{percent(stats['busy']['dram'] / max(result.cycles, 1))} of the cycles"
    )
    click.echo(f"cycles: {result.cycles} ({stats['runs']} runs of {len(stats['tiles'])} tiles)")

"""`vividc reproduce`: the paper's tables and figures, measured here."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import click

from vividc.cli import options
from vividc.cli.reports.report import print_json, print_table
from vividc.cli.say import say
from vividc.paper.exhibit import Exhibit
from vividc.paper.page import number
from vividc.paper.reproduce import EXHIBITS, SCHEMA, Report, data, reproduce


@click.command("reproduce")
@click.option(
    "-o",
    "--output",
    type=options.FOLDER,
    metavar="DIR",
    default="report",
    show_default=True,
    help="Folder of the page, its data and its pictures; a run goes on with the frames in it.",
)
@click.option(
    "--only",
    multiple=True,
    type=click.Choice(EXHIBITS),
    help="This table or figure; may be given several times. Without: all.",
)
@click.option(
    "--quick", is_flag=True, help="Pictures of 200x200 in place of 800x800: a first look."
)
@click.option(
    "--scenes",
    multiple=True,
    type=options.FOLDER,
    metavar="DIR",
    help="Folder with `mic/` and `playbot/`; several: the first that has a file.",
)
@options.as_json
def command(
    output: Path, only: tuple[str, ...], quick: bool, scenes: tuple[Path, ...], as_json: bool
) -> None:
    """Measure the paper's tables and figures, and write them beside the paper's as one HTML page.

    All of it takes 45 minutes or so on two cores; it says how long before it starts, and an
    interrupted run resumes.
    """
    report = reproduce(
        output, only=only, quick=quick, scenes=scenes, tell=lambda line: say(line, err=True)
    )
    if as_json:
        print_json(SCHEMA, {**data(report.exhibits), "page": str(report.page)})
        return
    for exhibit in report.exhibits:
        _print(exhibit)
    _print_end(report)


def _print(exhibit: Exhibit) -> None:
    rows: list[tuple[object, ...]] = [
        (
            line.what,
            f"{number(line.ours)} {line.unit}".strip(),
            number(line.theirs),
            f"{line.verdict}: {line.because}" if line.because else line.verdict,
        )
        for line in exhibit.lines
    ]
    columns = ("figure", "ours", "the paper's", "verdict")
    print_table(exhibit.title, columns, rows, numeric=columns[1:3])


def _print_end(report: Report) -> None:
    verdicts = Counter(line.verdict for exhibit in report.exhibits for line in exhibit.lines)
    found = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
    click.echo(f"{found}; {report.measured} frames rendered, {report.kept} kept from before")
    click.echo(f"written: {report.page}")

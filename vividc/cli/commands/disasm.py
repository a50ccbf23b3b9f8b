"""`vividc disasm`: the configuration words of a program, in readable form."""

from __future__ import annotations

from pathlib import Path

import click

import vividc
from vividc.cli import options
from vividc.cli.reports.report import print_json
from vividc.cli.say import say
from vividc.program import disassemble

SCHEMA = "vividc.disasm/1"


@click.command("disasm")
@click.argument("program", metavar="P.vivid", type=options.FILE)
@options.as_json
def command(program: Path, as_json: bool) -> None:
    """Print what each PE does in each context of a program."""
    text = disassemble(vividc.load(program))
    if as_json:
        print_json(SCHEMA, {"program": str(program), "text": text})
    else:
        say(text)

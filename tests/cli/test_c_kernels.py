"""C functions on the command line: compile, simulate, check."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from vividc.cli.main import cli

KERNELS = Path(__file__).resolve().parents[2] / "kernels" / "c"


def invoke(*args: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(cli, [str(arg) for arg in args])
    return result.exit_code, result.stdout, result.stderr

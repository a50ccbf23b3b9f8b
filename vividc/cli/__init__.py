"""The command line: what a user gives, one module a command, and what is printed.

In order: `files`, `arrays`, `kernels`, `precision`, `reference` (`--check`), `options` (shared by
commands), `stages` (what is looked at between stages); `reports/`, `commands/`; `main`.
"""

from vividc.cli.main import main

__all__ = ["main"]

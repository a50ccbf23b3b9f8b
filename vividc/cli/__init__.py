"""The command line: what a user gives, one module a command, and what is printed.

In order: `say`, `files`, `arrays`, `kernels`, `reference` (`--check`), `completion`, `options`
(shared by commands), `loops` (transformations), `stages` (what is seen between stages); `reports/`,
`commands/`; `main`; and `ship`, which is run when vividc is installed.
"""

from vividc.cli.main import main

__all__ = ["main"]

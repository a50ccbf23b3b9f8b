"""The command line: one module a command; logic lives in the rooms below."""

from vividc.cli.main import main

__all__ = ["main"]

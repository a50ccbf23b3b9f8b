"""Writes the compiled kernels of all renderers to a folder, `programs/` of a package that becomes a
wheel: `python -m vividc.render.array.device.ship FOLDER`, as `make wheel` does.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import vividc
from vividc.render.array.device.ahead import compile_ahead
from vividc.render.array.device.kernels import Wanted, all_kernels
from vividc.render.array.device.programs import Programs


def ship(programs: Programs, kernels: Sequence[Wanted], folder: Path) -> None:
    """Write the programs of kernels to a folder, and remove what else is in it.

    Raises
    ------
    VividcError
        A kernel cannot be compiled, the clock ended a search for its mapping, or the folder cannot
        be written.
    """
    compile_ahead(programs, kernels)
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    for kernel, options in kernels:
        programs.ship(folder, kernel, **options)


if __name__ == "__main__":
    machine = vividc.arch.load_accelerator("vivid")
    told = Programs(machine, lambda line: print(line, file=sys.stderr))
    ship(told, all_kernels(), Path(sys.argv[1]))

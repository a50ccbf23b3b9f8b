"""Writes the machine code of all inner loops to the package, where no user has to wait for it:
`python -m vividc.cli.ship [FOLDER]`, as `make setup` and `make wheel` do.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Final

from vividc.host.machine_code import shipped, units

COMPILED: Final = (
    "vividc.launch.hazards.races",
    "vividc.launch.timing.simulation",
    "vividc.mapper.engines.greedy",
    "vividc.mapper.engines.negotiate",
    "vividc.mapper.resources.waits",
)
"""What has all functions of each unit that computes no vectors, which suit a processor."""


def ship(folder: Path) -> None:
    """Write the object files of all units to a folder, and remove what else is in it.

    Raises
    ------
    OSError
        It cannot be written.
    """
    for module in COMPILED:
        import_module(module)
    made = [unit.portable() for unit in units]
    shipped.write(folder, {name: code for one in made for name, code in one.items()})


if __name__ == "__main__":
    ship(Path(sys.argv[1]) if len(sys.argv) > 1 else shipped.FOLDER)

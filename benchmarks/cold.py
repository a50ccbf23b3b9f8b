"""Each kernel of `kernels/`, compiled in a process of its own that finds no cache."""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from benchmarks.start import Times, timed
from vividc.cli.kernels import kernels_of

TITLE: Final = "Every kernel, compiled cold"
NOTES: Final = """\
`vividc compile FILE:KERNEL` as it is, in a process of its own, with empty caches of vividc and
numba; bytecode and the mapper's machine code are there since installation. `cpu`: seconds of user
CPU, which an idle machine spreads over its cores. The machine did nothing else.
""".splitlines()
HEADER: Final = "| kernel | s | cpu s |\n|---|---|---|"
_ROOT: Final = Path(__file__).resolve().parents[1]
_ASKED_S: Final = 5.0
_SHOWN: Final = 20


def rows(fabric: str) -> Iterator[str]:
    """Yield the slowest kernels, and what all of them come to."""
    found: dict[str, Times] = {}
    for kernel in _kernels():
        with tempfile.TemporaryDirectory() as home:
            command = ("-m", "vividc", "compile", kernel, "--fabric", fabric)
            found[kernel] = timed((sys.executable, *command, "-o", f"{home}/out.vivid"), home)
    slowest = sorted(found, key=lambda kernel: -found[kernel].wall)
    for kernel in slowest[:_SHOWN]:
        yield f"| {kernel} | {found[kernel].wall:.1f} | {found[kernel].cpu:.1f} |"
    walls = sorted(times.wall for times in found.values())
    mean = math.exp(sum(map(math.log, walls)) / len(walls))
    above = sum(wall > _ASKED_S for wall in walls)
    yield ""
    yield (
        f"{len(walls)} kernels: {above} take more than {_ASKED_S:g} s, the median "
        f"{walls[len(walls) // 2]:.1f}, the geometric mean {mean:.1f}."
    )


def _kernels() -> Iterator[str]:
    for file in sorted((_ROOT / "kernels").rglob("*.py")):
        if file.name != "__init__.py":
            yield from (f"{file.relative_to(_ROOT)}:{one.name}" for one in kernels_of(file))

"""Programs that were compiled before, in the user's cache: known by all that they follow from."""

from __future__ import annotations

import os
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Final

from vividc.arch import Accelerator, load_text
from vividc.arch.fabric import Fabric
from vividc.host import time_limit
from vividc.host.watch import is_watched
from vividc.mapper.registry import BUILT_IN
from vividc.program import Program
from vividc.program.kept import COMPILER, read_program, source_digest, text_of, write_program
from vividc.ssa.ir import Function

VARIABLE: Final = "VIVIDC_CACHE_PROGRAMS"
"""0: nothing is kept or taken, whatever `compile` is told."""

_KIND: Final = "program"


@dataclass(frozen=True, slots=True)
class Place:
    """Where the program of a lowered kernel is kept; without a key: nowhere."""

    function: Function
    key: str = ""

    def read(self) -> Program | None:
        """The program, if it was kept."""
        program = read_program(_KIND, self.key) if self.key else None
        if program is None or program.name != self.function.name:
            return None
        return program

    def write(self, program: Program) -> None:
        """Keep the program, unless another run may find a better one, as the clock has cut
        something short, or its fabric was changed after it was read, and its text is another one's.
        """
        limit = time_limit.current()
        was_cut = program.hurried or (limit is not None and limit.cut)
        if self.key and not was_cut and _is_of_its_text(program.fabric):
            write_program(_KIND, self.key, program)


def place_of(function: Function, machine: Fabric | Accelerator, mapper: str, *how: object) -> Place:
    """Where the program is kept that follows from a lowered kernel, a machine and `how`.

    Nowhere if somebody looks at the stages on the way, if the mapper is a guest, whose code is not
    known, or if the user wants no programs to be kept.
    """
    wanted = os.environ.get(VARIABLE, "") != "0"
    if not wanted or is_watched() or mapper not in BUILT_IN:
        return Place(function)
    parts = (
        text_of(function),
        _content(function.file),
        text_of(machine),
        mapper,
        *map(text_of, how),
        source_digest(*COMPILER),
    )
    digests = (sha256(part.encode("utf-8", "surrogatepass")).hexdigest() for part in parts)
    return Place(function, " ".join(digests))


def _is_of_its_text(fabric: Fabric) -> bool:
    return bool(fabric.source) and text_of(load_text(fabric.source)) == text_of(fabric)


def _content(file: str) -> str:
    """A hash of the file: programs name it, with that."""
    try:
        return sha256(Path(file).read_bytes()).hexdigest() if file else ""
    except OSError:
        return ""

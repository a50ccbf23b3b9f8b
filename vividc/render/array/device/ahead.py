"""Kernels are compiled before they are needed, on all cores.

As a module it is a helper (`vividc.host.processes.crew`): kernels come over the pipe, and their
programs are left in the user's cache.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Final

import vividc
from vividc.errors import VividcError
from vividc.host import cache
from vividc.host.processes import crew
from vividc.render.array.device.kernels import Wanted
from vividc.render.array.device.programs import Programs

HELPER: Final = "vividc.render.array.device.ahead"


def compile_ahead(programs: Programs, kernels: Sequence[Wanted]) -> None:
    """Have those of these kernels compiled that are not yet; without a cache there is no other
    process that could.

    Raises
    ------
    VividcError
        A kernel cannot be compiled.
    """
    missing = [one for one in kernels if not programs.is_at_hand(one[0], **one[1])]
    count = crew.processes_for(len(missing))
    if count == 1 or cache.folder() is None or not programs.machine.source:
        return

    def compiled(wanted: Wanted) -> bool:
        programs.get(wanted[0], **wanted[1])
        return True

    if programs.tell is not None:
        programs.tell(f"compiling {len(missing)} kernels in {count} processes")
    greeting = programs.machine.source, programs.mapping_s, programs.common
    crew.share_out(missing, compiled, crew.Helpers(count - 1, HELPER, greeting))


def serve(pipe: Connection) -> None:
    """Answer each kernel with True, or None where it has an error."""
    machine, mapping_s, common = pipe.recv()
    programs = Programs(vividc.arch.load_accelerator_text(machine), None, mapping_s, common)
    pipe.send("ready")
    while True:
        try:
            kernel, options = pipe.recv()
        except EOFError:
            return
        try:
            programs.get(kernel, **options)
        except VividcError:
            pipe.send(None)
        else:
            pipe.send(True)


if __name__ == "__main__":
    with Connection(int(sys.argv[1])) as connection:
        serve(connection)

"""Machine code of a program: from this process, from the user's cache, or compiled now."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from hashlib import sha256
from itertools import count
from threading import Lock
from typing import Final

from vividc.host import cache
from vividc.program import Program
from vividc.sim.native.compiler import Native, host, loaded, object_code
from vividc.sim.native.module import Plan, module_text, plan, spill_words
from vividc.sim.native.state import Blank

_KEPT: Final = 256
_KIND: Final = "engine"
_LOCK: Final = Lock()
known_code: OrderedDict[str, Native] = OrderedDict()
_names = count()


@dataclass(frozen=True, slots=True)
class Compiled:
    """A program ready to run.

    Attributes
    ----------
    blank
        Makes the state at a launch.
    """

    plan: Plan
    blank: Blank
    native: Native


def compiled(program: Program) -> Compiled:
    """Compile a program, or find its machine code.

    The code is known by a hash of the text it is compiled from and of what it is compiled for:
    equal keys cannot mean different code.
    """
    planned = plan(program)
    text = module_text(program, planned)
    key = sha256(f"{host()}\n{text}".encode()).hexdigest()
    words = planned.layout.spill + spill_words(planned, program.fabric.scratchpad.banks)
    return Compiled(planned, Blank(program, planned.layout, words), _native(key, text))


def _native(key: str, text: str) -> Native:
    with _LOCK:
        if key in known_code:
            known_code.move_to_end(key)
            return known_code[key]
    code = cache.read(_KIND, key)
    if code is None:
        code = object_code(text)
        cache.write(_KIND, key, code)
    native = loaded(code, f"vividc.{next(_names)}")
    with _LOCK:
        known_code[key] = native
        if len(known_code) > _KEPT:
            known_code.popitem(last=False)
    return native

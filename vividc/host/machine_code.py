"""Functions over flat arrays as machine code: inner loops that are too slow in Python.

They allocate nothing, so reference counting is off: counting the arrays of every argument took
nineteen twentieths of the time. Divisors are never 0, so none is checked.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any, Final, Protocol, TypeVar, cast

import numba
import numba.extending
import numpy as np
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler as NumbaCompiler
from numba.core.compiler import DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.dispatcher import Dispatcher
from numba.core.typed_passes import NativeLowering

from vividc.host import kept_code, made_of
from vividc.host.kept_code import KeptCode, KeyedCompiler

_Function = TypeVar("_Function", bound=Callable[..., object])

_OPTIONS: Final[dict[str, Any]] = {
    "error_model": "numpy",
    "nogil": True,
    "_nrt": False,
    "no_cfunc_wrapper": True,
}


class Compiler(Protocol):
    """A decorator that keeps a function's type."""

    def __call__(self, function: _Function, /) -> _Function: ...


def compiler(module: str) -> Compiler:
    """Return the decorator of a folder's functions; `module` is the `__file__` of a module there.

    A function is compiled at its first call and kept in the user's cache; without one it is
    compiled again in each process.

    What is kept holds the functions that it calls, too, whatever file they are in: it is good for
    this state of them, of the whole folder, and of the files that compile it.
    """
    stamp = _stamp(Path(module).parent)

    def compiled(function: _Function) -> _Function:
        made = numba.njit(pipeline_class=KeyedCompiler, **_OPTIONS)(function)
        if isinstance(made, Dispatcher):  # else numba's compiling is switched off
            made._cache = KeptCode(cast(FunctionType, function), stamp)
        return cast(_Function, made)

    return compiled


def inlined(function: _Function) -> _Function:
    """Have a function put into each compiled one that calls it; called by Python it is Python.

    A call would copy every array of every tuple it is given, some hundred words each: that took two
    thirds of the annealer's time. Only the callers are optimised and become machine code: numba by
    itself does both with each function, which took two fifths of the compilation.
    """
    jitable = numba.extending.register_jitable(
        forceinline=True, no_cpython_wrapper=True, pipeline_class=_PartCompiler, **_OPTIONS
    )
    return cast(_Function, jitable(function))


def constant(number: int) -> int:
    """Return a number such that functions it is passed to are compiled once, not anew for it."""
    return cast(int, np.int64(number))


def _stamp(folder: Path) -> str:
    text = hashlib.sha256()
    own = (Path(file) for file in (__file__, kept_code.__file__, made_of.__file__))
    for path in (*own, *sorted(folder.glob("*.py"))):
        text.update(path.read_bytes())
    return text.hexdigest()


class _Part(JITCodeLibrary):  # type: ignore[misc]
    """LLVM IR of a function and of all that it calls, for the optimiser of its callers."""

    def finalize(self) -> None:
        """As numba's, but for optimisation and machine code."""
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerPart(NativeLowering):  # type: ignore[misc]
    """Numba's lowering of a function that gets no address."""

    _name = "vividc_lower_part"

    def run_pass(self, state: Any) -> bool:
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        # Numba keys a function's lowering by its address; any builtin of its own serves.
        lowered = state["cr"]._replace(cfunc=[].append)
        state.targetctx.insert_user_function(lowered.cfunc, lowered.fndesc, [state.library])
        state["cr"] = lowered
        return True


class _PartCompiler(NumbaCompiler):  # type: ignore[misc]
    """Numba's passes with the lowering of a part."""

    def define_pipelines(self) -> list[PassManager]:
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state, "part")
        passes.passes = [
            (_LowerPart if made is NativeLowering else made, text) for made, text in passes.passes
        ]
        passes.finalize()
        return [passes]

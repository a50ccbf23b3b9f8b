"""Numba's own code of kernels, which the tests compare with, at less than it takes numba.

Numba makes machine code of each function that a kernel calls, down to its own helpers, with a
wrapper for C, and links and optimises each twice; all that is ever called is the kernel. Here
helpers are linked as they were lowered, and code is made where an address is asked for. What is
typed and lowered is numba's, and so is what LLVM makes of it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import pytest
from numba import _dynfunc
from numba.core import codegen, cpu
from numba.core.typing import templates

_RECURSION = codegen.RuntimeLinker.PREFIX


class _Library(codegen.JITCodeLibrary):  # type: ignore[misc]
    """The functions of one compilation. `environment`: name and value of the variable that stands
    for its module, of which no address is known yet.
    """

    environment: tuple[str, object] | None = None

    def add_linking_library(self, library: _Library) -> None:
        self._linking_libraries.append(library)

    def finalize(self) -> None:
        self._linking_libraries = self._all_linked()
        super().finalize()
        for library in (self, *self._linking_libraries):
            if isinstance(library, _Library):
                library.tell_environment()

    def tell_environment(self) -> None:
        """Where the code that was made last has the variable."""
        if self.environment is not None:
            name, value = self.environment
            if self._codegen._engine.is_symbol_defined(name):
                self._codegen.set_env(name, value)

    def is_helper(self, wrapper: str) -> bool:
        """Whether only functions that are linked with it call it."""
        module = self._final_module
        recursive = any(one.name.startswith(_RECURSION) for one in module.global_variables)
        return not recursive and all(one.name != wrapper for one in module.functions)

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None and not self._finalized:
            module = self._final_module.clone()
            for one in module.functions:
                if not one.is_declaration and one.linkage is codegen.ll.Linkage.external:
                    one.linkage = "linkonce_odr"
            self._shared_module = module
        return super()._get_module_for_linking() if self._finalized else self._shared_module

    def _all_linked(self) -> list[_Library]:
        """All libraries that it needs, once each."""
        seen: dict[_Library, None] = {}
        waiting = list(self._linking_libraries)
        while waiting:
            library = waiting.pop(0)
            if library not in seen:
                seen[library] = None
                waiting += library._linking_libraries
        return list(seen)


_executable = cpu.CPUContext.get_executable


def _executable_if_called(context: Any, library: Any, fndesc: Any, env: Any) -> Any:
    """As numba's `get_executable`; a helper's address is that of nothing, which nobody calls."""
    if not isinstance(library, _Library) or not library.is_helper(fndesc.llvm_cpython_wrapper_name):
        return _executable(context, library, fndesc, env)
    library.environment = (context.get_env_name(fndesc), env)
    name = fndesc.qualname.split(".")[-1]
    return _dynfunc.make_function(fndesc.lookup_module(), name, "", 0, env, (library,))


_decorator = templates._OverloadFunctionTemplate._get_jit_decorator


def _without_wrapper(template: Any) -> Callable[..., Any]:
    """Numba's decorator of what it calls for a function of Python's or numpy's: nobody calls it
    from C.
    """
    return functools.partial(_decorator(template), no_cfunc_wrapper=True)


def make_less(patch: pytest.MonkeyPatch) -> None:
    """Until the patch is undone."""
    patch.setattr(codegen.JITCPUCodegen, "_library_class", _Library)
    patch.setattr(cpu.CPUContext, "get_executable", _executable_if_called)
    patch.setattr(templates._OverloadFunctionTemplate, "_get_jit_decorator", _without_wrapper)

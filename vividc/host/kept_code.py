"""Machine code of compiled functions in the user's cache, in place of numba's own files.

Numba keeps pickles, which run whatever is in them, and an index beside them. An entry here is facts
as JSON, object code, and bitcode for callers that are compiled later; the callable is built from
the arguments' types at hand. Relies on numba's internals.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable
from hashlib import sha256
from types import FunctionType
from typing import Any, Final
from weakref import WeakKeyDictionary

import numba
from llvmlite import binding
from numba.core import config, sigutils, types
from numba.core.caching import NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler as NumbaCompiler
from numba.core.compiler import CompileResult
from numba.core.compiler_machinery import PassManager
from numba.core.environment import Environment, lookup_environment
from numba.core.funcdesc import PythonFunctionDescriptor

from vividc.host import cache, time_limit
from vividc.host.made_of import made_of

_KIND: Final = "loops"
_RESULTS: Final = {
    str(kind): kind
    for kind in (types.none, types.boolean, types.int64, types.uint64, types.float32, types.float64)
}
"""Types of results by name; a function that returns another is compiled in each process."""
_OF_NO_EFFECT: Final = ("CACHE", "CUDA", "NUM_THREADS")
"""Parts of the names of numba's settings that do not change the code."""
_code_of: WeakKeyDictionary[Callable[..., object], KeptCode] = WeakKeyDictionary()
_made: Counter[str] = Counter()
"""How often code of a key got names in this process."""


class KeptCode(NullCache):  # type: ignore[misc]
    """What a dispatcher asks before it compiles, and gives what it compiled."""

    def __init__(self, function: FunctionType, stamp: str) -> None:
        self._function, self._stamp = function, stamp
        _code_of[function] = self

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """The kept code for arguments of these types, if there is some to trust."""
        return self.kept(sigutils.normalize_signature(sig)[0], target_context)

    def kept(self, args: tuple[Any, ...], target_context: Any) -> CompileResult | None:
        """As `load_overload`, by the arguments' types."""
        target_context.refresh()
        key = self.key(args, target_context.codegen())
        entry = cache.read(_KIND, key)
        if entry is None:
            return None
        try:
            return _rebuilt(entry, args, target_context)
        except (ValueError, KeyError, TypeError) as fault:
            cache.discard(_KIND, key, f"holds no machine code ({type(fault).__name__}: {fault})")
            return None

    def save_overload(self, sig: Any, cres: CompileResult) -> None:
        """`KeyedCompiler` keeps it, while no other process makes the same."""

    def keep(self, args: tuple[Any, ...], cres: CompileResult) -> None:
        """Keep code, if it depends on nothing but its arguments."""
        if _is_plain(cres):
            cache.write(_KIND, self.key(args, cres.codegen), _entry(cres))

    def key(self, sig: Any, codegen: Any) -> str:
        """All that the code depends on."""
        args, result = sigutils.normalize_signature(sig)
        return "\n".join(
            (
                repr((binding.llvm_version_info, codegen.magic_tuple(), sys.byteorder)),
                _settings(),
                self._stamp,
                made_of(self._function),
                *map(_type_text, args),
                str(result),
            )
        )


class KeyedCompiler(NumbaCompiler):  # type: ignore[misc]
    """Numba's passes; names in the code are bound to what it was made from.

    Numba numbers functions as they come, so that code of two processes may have a name in common
    that means two things. It takes up to a minute, once an installation, which no time limit
    counts; processes that need the same wait for the first.
    """

    def compile_extra(self, func: Callable[..., object]) -> CompileResult:
        """What another process has made by now, or what numba makes."""
        code, args = _code_of[func], tuple(self.state.args)
        with time_limit.not_counted(), cache.alone(_KIND):
            made = code.kept(args, self.state.targetctx)
            if made is not None:
                self.state.targetctx.insert_user_function(
                    made.entry_point, made.fndesc, [made.library]
                )
                return made
            made = super().compile_extra(func)
            code.keep(args, made)
        return made

    def define_pipelines(self) -> list[PassManager]:
        state = self.state
        code = _code_of[state.func_id.func]
        key = code.key(tuple(state.args), state.targetctx.codegen())
        number = int(sha256(key.encode()).hexdigest()[:12], 16)
        _made[key] += 1
        state.func_id.unique_id = f"{number}x{_made[key]}"
        state.func_id.unique_name = f"{state.func_id.func_qualname}${state.func_id.unique_id}"
        pipelines: list[PassManager] = super().define_pipelines()
        return pipelines


class _KeptLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Object code, and bitcode that is read only if a caller is compiled."""

    def __init__(self, codegen: Any, name: str, code: bytes, bitcode: bytes) -> None:
        super().__init__(codegen, name)
        self._bitcode = bitcode
        self._shared_module: Any = None
        self.enable_object_caching()
        self._set_compiled_object(code)
        self._finalize_final_module()

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = binding.parse_bitcode(self._bitcode)
        return self._shared_module


def _settings() -> str:
    """Numba's settings, which are the environment's and those of a file in the current folder."""
    return repr(
        {
            name: str(value)
            for name, value in sorted(vars(config).items())
            if name.isupper()
            and isinstance(value, bool | int | float | str | None)
            and not any(part in name for part in _OF_NO_EFFECT)
        }
    )


def _type_text(kind: Any) -> str:
    """Numba writes a tuple's class and types, not where it is from and its fields."""
    if isinstance(kind, types.BaseTuple):
        made = getattr(kind, "instance_class", tuple)
        inner = ", ".join(map(_type_text, kind.types))
        return f"{made.__module__}.{made.__qualname__}{getattr(kind, 'fields', ())}({inner})"
    return f"{type(kind).__name__} {kind}"


def _is_plain(cres: CompileResult) -> bool:
    """Whether the code needs nothing of this process: no Python objects, addresses, or set-up."""
    if cres.objectmode or cres.lifted or cres.reload_init or cres.library.has_dynamic_globals:
        return False
    if str(cres.signature.return_type) not in _RESULTS or cres.fndesc.global_dict is not None:
        return False
    names = (item.name for item in cres.library._final_module.global_variables)
    needed = (lookup_environment(name) for name in names if name.startswith("_ZN08NumbaEnv"))
    return not any(environment.consts for environment in needed if environment is not None)


def _entry(cres: CompileResult) -> bytes:
    library, described = cres.library, cres.fndesc
    code: bytes = library._get_compiled_object()
    facts = {
        "module": described.modname,
        "name": described.qualname,
        "number": described.uid,
        "tags": list(described.abi_tags),
        "parameters": list(described.args),
        "result": str(described.restype),
        "bytes": len(code),
    }
    bitcode: bytes = library._get_module_for_linking().as_bitcode()
    return json.dumps(facts).encode() + b"\n" + code + bitcode


def _rebuilt(entry: bytes, args: tuple[Any, ...], context: Any) -> CompileResult | None:
    """What `_entry` was made from; None: this process has code of these names already.

    Raises
    ------
    ValueError, KeyError, TypeError
        The facts are not those that `_entry` writes.
    """
    head, _, rest = entry.partition(b"\n")
    facts = json.loads(head)
    described = PythonFunctionDescriptor(
        native=True,
        modname=facts["module"],
        qualname=facts["name"],
        unique_name=f"{facts['name']}${facts['number']}",
        doc="",
        typemap=None,
        restype=_RESULTS[facts["result"]],
        calltypes=None,
        args=tuple(facts["parameters"]),
        kws=(),
        mangler=context.mangler,
        argtypes=args,
        abi_tags=facts["tags"],
        uid=facts["number"],
    )
    codegen = context.codegen()
    entered = described.llvm_cpython_wrapper_name
    if codegen._engine.is_symbol_defined(entered):
        return None
    size = facts["bytes"]
    library = _KeptLibrary(codegen, facts["name"], rest[:size], rest[size:])
    codegen._engine._defined_symbols |= {entered, described.llvm_func_name}
    environment = Environment.from_fndesc(described)
    return CompileResult(
        typing_context=context.typing_context,
        target_context=context,
        entry_point=context.get_executable(library, described, environment),
        typing_error=None,
        type_annotation="",
        signature=numba.core.typing.signature(described.restype, *args),
        objectmode=False,
        lifted=(),
        fndesc=described,
        library=library,
        call_helper=None,
        environment=environment,
        metadata=None,
        reload_init=(),
        referenced_envs=(),
    )

"""Unoptimised LLVM IR of a Python function, typed and lowered by a numba target of our own.

Relies on numba's internals, as do its helpers in this folder. The target is
numba's CPU without everything that an array has not: code generation, reference counting, Python
wrappers, exceptions. A raise becomes a call of a function named after it, so that a reachable one
can be reported with its line. An array index is taken as a 32-bit word, since any other is outside
its array, which numba leaves undefined.
"""

from __future__ import annotations

import functools
import operator
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numba
from llvmlite import binding, ir
from numba.core import cgutils, compiler, cpu, errors, sigutils, types
from numba.core.codegen import Codegen, CodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.descriptors import TargetDescriptor
from numba.core.dispatcher import Dispatcher
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.core.target_extension import (
    CPU,
    dispatcher_registry,
    jit_registry,
    target_override,
    target_registry,
)
from numba.np import arrayobj, npyimpl
from numba.np.ufunc.dufunc import DUFunc
from numba.np.ufunc.gufunc import GUFunc
from numba.stencils.stencil import StencilFunc

import vividc.frontend.numba.library.covariance
import vividc.frontend.numba.library.linalg
import vividc.frontend.numba.library.solve
import vividc.frontend.numba.library.sums
import vividc.frontend.numba.library.triangles
import vividc.frontend.numba.library.where
import vividc.frontend.numba.lists.kept  # noqa: F401 - all register functions with numba
from vividc.frontend.llvm.passes import DATA_LAYOUT
from vividc.frontend.numba.arrays import (
    NoRuntime,
    arrays_are_ours,
    broadcast_onto,
    constant_array,
    pick,
    reshape,
    transpose,
)
from vividc.frontend.numba.division import division
from vividc.frontend.numba.expressions.assign import assigned_in_place
from vividc.frontend.numba.expressions.inplace import TARGET_NAME
from vividc.frontend.numba.expressions.loops import copied
from vividc.frontend.numba.expressions.stencils import OwnStencil, own_stencil
from vividc.frontend.numba.expressions.views import followed_views
from vividc.frontend.numba.integer import integer_loops, integer_operator
from vividc.frontend.numba.library.math import complex_power, float_loops
from vividc.frontend.numba.library.order import argsort, is_argsort
from vividc.frontend.numba.library.sort import is_sort, sort
from vividc.frontend.numba.lines import Lines
from vividc.frontend.numba.lists.fixed import lists_are_tuples
from vividc.frontend.numba.lists.growing import list_of, lists_are_ours
from vividc.frontend.numba.raises.convention import NUMPY, CallConv, model_of
from vividc.frontend.numba.ranges import RANGE_RULES, parallel_range
from vividc.frontend.numba.subscripts import marked_subscripts
from vividc.frontend.numba.time import TimedTyping, ask, in_time
from vividc.frontend.numba.vectorized.elementwise import call_on_numbers, vectorized_type
from vividc.frontend.numba.vectorized.generalized import call_whole, generalized_type


class Callee:
    """What a kernel must be that another one calls.

    Attributes
    ----------
    py_func
        The Python function.
    numba_signature
        Its numba signature, or the tuple of its argument types: a call casts to them.
    """

    py_func: Callable[..., Any]
    numba_signature: Any


@dataclass(frozen=True, slots=True)
class NumbaModule:
    """What numba made of a function.

    Attributes
    ----------
    texts
        LLVM IR modules as text, the kernel's first, then all it needs.
    symbol
        Name of the kernel in the first module: `i32 (ptr retval, flattened arguments...)`.
    returned
        Numba's type of what it returns (`types.none` if nothing).
    """

    texts: tuple[str, ...]
    symbol: str
    returned: Any


class _Target(CPU):  # type: ignore[misc]
    """Numba's name tag of the target: inherits all overloads made for CPUs."""


class _Library(CodeLibrary):  # type: ignore[misc]
    """Keeps the modules' text; links, optimises and compiles nothing."""

    def __init__(self, codegen: Codegen, name: str) -> None:
        super().__init__(codegen, name)
        self.texts: list[str] = []
        self.linked: dict[str, _Library] = {}

    def add_ir_module(self, ir_module: ir.Module) -> None:
        self.texts.append(cgutils.normalize_ir_text(str(ir_module)))

    def add_linking_library(self, library: _Library) -> None:
        self.linked[f"{library.name} {id(library)}"] = library

    def finalize(self) -> None:
        self._finalized = True

    def get_function(self, name: str) -> Any:
        raise KeyError(name)

    def get_llvm_str(self) -> str:
        return "\n".join(self.texts)

    def get_asm_str(self) -> str:
        return ""

    def all_texts(self) -> tuple[str, ...]:
        """Texts of this library and, once each, of all it links."""
        seen: dict[int, _Library] = {}
        pending = [self]
        while pending:
            library = pending.pop(0)
            if id(library) not in seen:
                seen[id(library)] = library
                pending.extend(library.linked.values())
        return tuple(text for library in seen.values() for text in library.texts)


class _Codegen(Codegen):  # type: ignore[misc]
    _library_class = _Library

    def __init__(self) -> None:
        self._data_layout = DATA_LAYOUT
        self._target_data = binding.create_target_data(DATA_LAYOUT)

    def _create_empty_module(self, name: str) -> ir.Module:
        module = ir.Module(cgutils.normalize_ir_text(name))
        module.data_layout = DATA_LAYOUT
        return module

    def _add_module(self, module: Any) -> None:
        """There is no engine to add to."""

    def magic_tuple(self) -> tuple[str, ...]:
        """Numba's key of the code generator in caches."""
        return (TARGET_NAME,)

    def insert_unresolved_ref(self, *_: Any) -> None:
        """Numba asks for it to lower a recursive call."""
        raise errors.UnsupportedError("a recursive call cannot run on the array")


class _TypingContext(TimedTyping):
    def resolve_value_type(self, val: Any) -> Any:
        """A jitted helper or another kernel becomes a function of this target, typed anew."""
        if isinstance(val, Callee):
            val = _own_dispatcher(val, val.py_func, (val.numba_signature,))
        elif isinstance(val, Dispatcher) and not isinstance(val, _Dispatcher):
            fixed = () if val._can_compile else tuple(val.nopython_signatures)
            val = _own_dispatcher(val, val.py_func, fixed, val.locals)
        elif isinstance(val, DUFunc):
            return vectorized_type(val)
        elif isinstance(val, GUFunc):
            return generalized_type(val)
        elif isinstance(val, StencilFunc) and not isinstance(val, OwnStencil):
            model = model_of(val)
            target = _Dispatcher.targetdescr.target_context
            val = own_stencil(val, self, target, _flags(model), model)
        return super().resolve_value_type(val)


class _Context(cpu.CPUContext):  # type: ignore[misc]
    DIBuilder = Lines
    enable_boundscheck = False
    # Without it numba types no function that returns an array, such as np.empty.
    enable_nrt = True

    def init(self) -> None:
        self.is32bit = False
        self._internal_codegen = _Codegen()
        self._sizes: dict[str, int] = {}

    def load_additional_registries(self) -> None:
        # The runtime belongs to the host's context: were it made with this one, numba itself would
        # break.
        rtsys.initialize(cpu_target.target_context)
        super().load_additional_registries()

    @functools.cached_property
    def nrt(self) -> NoRuntime:
        """Nothing is counted; what needs the heap is an error."""
        return NoRuntime(self, False)

    @property
    def call_conv(self) -> CallConv:
        return CallConv(self)

    def apply_target_attributes(self, *_: Any, **__: Any) -> None:
        """No host, no attributes."""

    def post_lowering(self, mod: Any, library: Any) -> None:
        """Numba links its runtime here."""

    def compile_internal(
        self, builder: Any, impl: Any, sig: Any, args: Any, locals: Any = None
    ) -> Any:
        """As numba's; the shape that arrays are broadcast to is straight code."""
        if impl is npyimpl._broadcast_onto:
            return broadcast_onto(builder, args)
        return super().compile_internal(builder, impl, sig, args, locals or {})

    def get_abi_sizeof(self, ty: Any) -> int:
        """As numba's; LLVM reads a module to tell it, of each type once."""
        name = str(ty)
        if name not in self._sizes:
            self._sizes[name] = super().get_abi_sizeof(ty)
        return self._sizes[name]

    def make_constant_array(self, builder: Any, typ: Any, ary: Any) -> Any:
        """Constant arrays are typed globals; numba's are bytes."""
        return constant_array(self, builder, typ, ary)

    def get_ufunc_info(self, ufunc_key: Any) -> Any:
        """As numba's, but integer powers stay integers, and roots are those of the array."""
        numbas = super().get_ufunc_info(ufunc_key)
        return {**numbas, **integer_loops(ufunc_key), **float_loops(ufunc_key)}

    def get_function(self, fn: Any, sig: Any, _firstcall: bool = True) -> Any:
        """As numba's, except for ranges, tuples, integer operators and float remainders."""
        ask()
        iteration = RANGE_RULES.get((fn, type(sig.args[0]))) if isinstance(fn, str) else None
        if iteration is not None:
            return functools.partial(iteration, self, sig)
        operation = getattr(fn, "typing_key", fn)  # numba's own lowering asks for operators
        divide = division(operation, sig.args)
        if divide is not None:
            return functools.partial(divide, self, sig)
        if operation is numba.prange:
            general = super().get_function(fn, sig, _firstcall)
            return functools.partial(parallel_range, sig, general)
        rule = _our_rule(fn, operation, sig)
        if rule is not None:
            called = sig if rule in (sort, argsort) else sig.as_function()
            return functools.partial(_ours, rule, self, called)
        general = super().get_function(fn, sig, _firstcall)
        return integer_operator(self, fn, sig, general)


def _our_rule(fn: Any, operation: Any, sig: Any) -> Any:
    """What stands in for numba's lowering of a call on tuples, lists and arrays, and for functions
    that numba has made of a user's; None: nothing.
    """
    if isinstance(operation, DUFunc) and isinstance(sig.return_type, types.Number | types.Boolean):
        return functools.partial(call_on_numbers, function=operation)
    if isinstance(operation, GUFunc):
        return functools.partial(call_whole, function=operation)
    if operation is operator.getitem and isinstance(sig.args[0], types.UniTuple):
        return pick
    if operation is list and sig.args:
        return list_of
    if operation in _POWERS and isinstance(sig.args[0], types.Complex):
        return complex_power
    return _array_rule(fn, operation, sig)


def _array_rule(fn: Any, operation: Any, sig: Any) -> Any:
    """As `_our_rule`, of methods of arrays."""
    if "array.reshape" in (fn, operation) and isinstance(sig.args[-1], types.BaseTuple):
        return reshape
    if "array.transpose" in (fn, operation) and getattr(sig.return_type, "ndim", 0) > 1:
        given = [one for one in sig.args if not isinstance(one, types.NoneType | types.Array)]
        return transpose if given else None
    if is_argsort(operation, sig):
        return argsort
    return sort if is_sort(operation, sig) else None


_POWERS = (operator.pow, operator.ipow, pow)


def _ours(rule: Any, context: _Context, sig: Any, builder: ir.IRBuilder, args: Any, *_: Any) -> Any:
    return rule(context, builder, sig, args)


class _Descriptor(TargetDescriptor):  # type: ignore[misc]
    options = cpu.CPUTargetOptions

    @functools.cached_property
    def typing_context(self) -> _TypingContext:
        return _TypingContext()

    @functools.cached_property
    def target_context(self) -> _Context:
        return _Context(self.typing_context, TARGET_NAME)


def _flags(model: str) -> compiler.Flags:
    flags = compiler.Flags()
    flags.no_compile = True
    flags.no_cpython_wrapper = True
    flags.no_cfunc_wrapper = True
    flags.debuginfo = True
    flags.dbg_directives_only = True
    flags.error_model = model
    return flags


class _Dispatcher(Dispatcher):  # type: ignore[misc]
    """A helper function of the target, compiled on demand for the types of each call."""

    targetdescr = _Descriptor(TARGET_NAME)
    model = NUMPY

    def compile(self, sig: Any) -> object:
        args, return_type = sigutils.normalize_signature(sig)
        existing = self.overloads.get(tuple(args))
        if existing is not None:
            return existing.entry_point
        with self._compiling_counter:
            result = _compile(self.py_func, args, return_type, self.model, self.locals)
        # Numba keys a helper's lowering by its address; it has none, so any unique object serves.
        result = result._replace(entry_point=_EntryPoint())
        self.targetctx.insert_user_function(result.entry_point, result.fndesc, [result.library])
        self.overloads[tuple(args)] = result
        return result.entry_point


class _EntryPoint:
    """Stands for the address of a function that is never loaded."""


def _own_dispatcher(
    host: Any, py_func: Callable[..., Any], signatures: tuple[Any, ...], locals_: Any = None
) -> _Dispatcher:
    """The dispatcher of our target for what the host calls `host`, limited to `signatures`."""
    model = model_of(host)
    name = f"_vividc_dispatcher_{model}"
    own: _Dispatcher | None = getattr(host, name, None)
    if own is None:
        own = _Dispatcher(py_func, locals_ or {})
        own.model = model
        setattr(host, name, own)
        try:
            for signature in signatures:
                own.compile(signature)
        except errors.NumbaError:
            delattr(host, name)
            raise
        if signatures:
            own.disable_compile()
    return own


def _jit(*_: Any, **__: Any) -> Callable[[Any], _Dispatcher]:
    """What numba calls to make a function of this target out of an overload's implementation."""
    return _Dispatcher


def _compile(py_func: Any, args: Any, return_type: Any, model: str, locals_: Any = None) -> Any:
    descriptor = _Dispatcher.targetdescr
    return compiler.compile_extra(
        descriptor.typing_context,
        descriptor.target_context,
        py_func,
        args=args,
        return_type=return_type,
        flags=_flags(model),
        locals=locals_ or {},
    )


def _word_index(context: Any, builder: ir.IRBuilder, type_: Any, index: Any, size: Any) -> Any:
    """Numba's `fix_integer_index` on words: a negative index counts from the end."""
    if not type_.signed:
        return context.cast(builder, index, type_, types.uintp)
    wide = context.cast(builder, index, type_, types.intp)
    word = builder.trunc(wide, ir.IntType(32))
    from_end = builder.add(word, builder.trunc(size, ir.IntType(32)))
    is_negative = builder.icmp_signed("<", word, ir.Constant(word.type, 0))
    return builder.sext(builder.select(is_negative, from_end, word), wide.type)


@contextmanager
def _indices_are_words() -> Iterator[None]:
    """Numba looks the function up in its module whenever it lowers an index."""
    original = arrayobj.fix_integer_index
    arrayobj.fix_integer_index = _word_index
    try:
        yield
    finally:
        arrayobj.fix_integer_index = original


@contextmanager
def _in_our_way() -> Iterator[None]:
    """What numba does otherwise in every function."""
    with _indices_are_words(), arrays_are_ours(), lists_are_tuples(), lists_are_ours():
        yield


def _register() -> None:
    target_registry[TARGET_NAME] = _Target
    dispatcher_registry[_Target] = _Dispatcher
    jit_registry[_Target] = _jit


_register()


def numba_module(
    py_func: Callable[..., object], args: tuple[Any, ...], return_type: Any
) -> NumbaModule:
    """Type and lower `py_func` with numba, without optimisation, in the error model of
    `raises.of_model`.

    Parameters
    ----------
    args, return_type
        Numba types; a `return_type` of None is inferred.

    Raises
    ------
    numba.core.errors.NumbaError
        Numba cannot type or lower the function.
    TimeLimit
        Time is up (`time_limit`).
    """
    with global_compiler_lock, target_override(TARGET_NAME), warnings.catch_warnings():
        # A helper without a source file has inexact lines: that is no matter of the user's.
        warnings.simplefilter("ignore", errors.NumbaDebugInfoWarning)
        warnings.simplefilter("ignore", errors.NumbaExperimentalFeatureWarning)
        with (
            in_time(),
            _in_our_way(),
            marked_subscripts(py_func, args),
            assigned_in_place(py_func, copied),
            followed_views(py_func, args),
        ):
            result = _compile(py_func, args, return_type, model_of(None))
    texts, described = result.library.all_texts(), result.fndesc
    return NumbaModule(texts, described.llvm_func_name, result.signature.return_type)

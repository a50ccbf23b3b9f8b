"""`@kernel`: a Python function with a numba signature, which runs through numba and lowers for the
array.
"""

from __future__ import annotations

import copy
import functools
import inspect
import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal, TypeAlias

import numba
import numpy as np
from numba.core import sigutils, types
from numba.core.typing import Signature

from vividc.errors import KernelError, SourceLoc, quoted
from vividc.formats import F16
from vividc.frontend.like import Like, with_sizes
from vividc.frontend.lower import lower
from vividc.frontend.numba.raises.convention import ERROR_MODELS, NUMPY, of_model
from vividc.frontend.numba.ranges import calls_prange, prange_lines
from vividc.frontend.numba.target import Callee
from vividc.frontend.numba.vectorized.functions import as_function
from vividc.host.inputs import demand_utf8_path
from vividc.lang.numba_types import TYPES, for_numba, in_arrays
from vividc.lang.numba_words import plain
from vividc.machine.params import MAX_NDIM, MAX_SPREAD, DType, Param
from vividc.ssa.ir import Function

_DTYPES = {
    types.float32: DType.F32,
    types.int32: DType.I32,
    types.uint32: DType.U32,
    types.int16: DType.I16,
    types.uint16: DType.U16,
    types.int8: DType.I8,
    types.uint8: DType.U8,
    types.boolean: DType.BOOL,
}
_DTYPES |= {types.complex64: DType.C64}
_ELEMENTS = _DTYPES | {TYPES[F16]: DType.F16}
_SCALARS = _DTYPES | {types.int64: DType.I64, types.uint64: DType.U64}
_SUPPORTED = (
    "scalars and arrays are float32, int32, uint32, int16, uint16, int8, uint8, bool or complex64, "
    "scalars also int64 and uint64, arrays also float16; arrays in C order, as in float32[::1] or "
    "uint8[:, ::1]"
)


_Signature: TypeAlias = str | Signature | tuple[Any, ...]
_SIGNATURE_HINT = 'write for example @vividc.kernel("void(float32[::1], int32)")'


class KernelFunction(Callee):
    """A kernel. Calling it runs it through numba; `lower` gives it to the compiler.

    Attributes
    ----------
    py_func
        The function as written.
    name
        Name of the kernel.
    signature
        Numba's signature.
    params
        Parameters in order, with the sizes that are known of them.
    file, line
        Where it is defined.
    error_model
        Numba's: what divisions by zero do.
    fastmath
        It is made of a function that numba has compiled with leave to sum floats in any order.
    """

    def __init__(
        self,
        py_func: Callable[..., Any],
        signature: _Signature,
        name: str | None,
        error_model: str = NUMPY,
        fastmath: bool = False,
    ) -> None:
        functools.update_wrapper(self, py_func)
        self.py_func = py_func
        self.name = name or py_func.__name__
        self.error_model = error_model
        self.fastmath = fastmath
        self.file = os.path.abspath(inspect.getsourcefile(py_func) or py_func.__code__.co_filename)
        self.line = py_func.__code__.co_firstlineno
        args, self._return_type = _parse(signature, self.loc)
        self._args = (*args, *default_types(py_func, len(args)))
        self.signature = Signature(self._return_type, self._args, None)
        self.params = _params(py_func, self._args, self.loc)
        self._lowered: dict[tuple[object, ...], Function] = {}

    def sized(self, like: Like) -> KernelFunction:
        """The kernel for sizes that are known, as of `vividc.compile`.

        Raises
        ------
        ArgumentError
            They do not fit its parameters.
        """
        made = copy.copy(self)
        made.params = with_sizes(self.name, self.params, like)
        return made

    @property
    def loc(self) -> SourceLoc:
        """Where the kernel is defined."""
        return SourceLoc(self.file, self.line)

    def __repr__(self) -> str:
        params = ", ".join(f"{param.name}: {param.type_text}" for param in self.params)
        returns = "" if self._return_type in (None, numba.none) else f" -> {self._return_type}"
        return f"<kernel {self.name}({params}){returns}>"

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Run the kernel on the host, compiled by numba for exactly its signature."""
        named = {name: for_numba(value) for name, value in kwargs.items()}
        given = map(for_numba, args)
        if any(param.default for param in self.params):
            bound = inspect.signature(self.py_func).bind(*given, **named)
            bound.apply_defaults()
            return self._host(*bound.args)
        return self._host(*given, **named)

    @property
    def numba_signature(self) -> Any:
        """The signature, or the argument types if the return type is inferred."""
        return self._args if self._return_type is None else self.signature

    @property
    def _numba_type_(self) -> Any:
        """Numba's type of a kernel that another function calls."""
        return self._host._numba_type_

    @functools.cached_property
    def _host(self) -> Any:
        jit = numba.njit(
            self.numba_signature,
            error_model=self.error_model,
            fastmath=False,
            boundscheck=False,
            no_cfunc_wrapper=True,  # nobody calls it from C
        )
        return jit(self.py_func)

    @property
    def prange_lines(self) -> frozenset[int]:
        """Lines in which loops over `numba.prange` begin."""
        return prange_lines(self.py_func)

    @property
    def called_prange(self) -> str:
        """Name of a function that the kernel calls, with a loop over `prange`; "" if none has."""
        return calls_prange(self.py_func)

    def lower(
        self, strict_fp: bool = False, spread: bool = False, words_at: frozenset[int] = frozenset()
    ) -> Function:
        """The kernel as SSA words, once per option.

        Parameters
        ----------
        strict_fp
            Refuse float64 arithmetic; else it runs in float32 with a warning for each line.
        spread
            Arrays may be long: a launch cuts them into pieces.
        words_at
            Lines whose integers of 64 bits are taken to be cast to int32: for an estimate of what
            the casts would bring.

        Raises
        ------
        KernelError
            The kernel uses something that cannot be compiled; its file's path is not UTF-8.
        """
        key = (self.params, strict_fp, spread, words_at)
        if key not in self._lowered:
            demand_utf8_path(self.file, KernelError)
            longest = MAX_SPREAD if spread else 0
            with of_model(self.error_model):
                self._lowered[key] = lower(
                    self.py_func,
                    self.name,
                    tuple(replace(p, longest=longest) if p.ndim else p for p in self.params),
                    self._args,
                    self._return_type,
                    self.loc,
                    strict_fp=strict_fp,
                    words_at=words_at,
                )
        return self._lowered[key]


def kernel(
    signature: _Signature,
    *,
    name: str | None = None,
    like: Like | None = None,
    error_model: Literal["numpy", "python"] = NUMPY,
) -> Callable[[Callable[..., Any]], KernelFunction]:
    """Mark a function as a kernel, or one that numba has compiled: of its options `fastmath` is
    leave to reassociate, `error_model` is as below, and others make no difference.

    Parameters
    ----------
    signature
        Numba's signature, such as "void(float32[::1], float32[::1], int32)", as text or as numba's
        own object, or a tuple of the parameters' types.
    name
        Name of the kernel; the function's if None.
    like
        Sizes that `vividc.compile` takes for known where it is given none (docs/known-sizes.md).
    error_model
        Numba's. "numpy": floats divided by zero are infinite or NaN, integers 0, as on its GPUs.
        "python": a division by zero is an error of the run, as numba raises ZeroDivisionError; a
        check costs a comparison and a store where a divisor is not known to be none
        (docs/math.md).

    Raises
    ------
    KernelError
        When applied: the signature is malformed, has types that no array can hold, or does not fit
        the function's parameters.
    ArgumentError
        When applied: the sizes do not fit its parameters.
    """

    if inspect.isfunction(signature):
        code = signature.__code__
        place = SourceLoc(os.path.abspath(code.co_filename), code.co_firstlineno)
        raise KernelError("a kernel without a signature", loc=place, hint=_SIGNATURE_HINT)
    if not isinstance(signature, str | Signature | tuple):
        raise KernelError(f"{quoted(signature)} is no signature", hint=_SIGNATURE_HINT)

    if error_model not in ERROR_MODELS:
        hint = 'give error_model="numpy" or error_model="python"'
        raise KernelError(f"{quoted(error_model)} is no error model", hint=hint)

    def decorate(py_func: Callable[..., Any]) -> KernelFunction:
        options = getattr(py_func, "targetoptions", {})  # of a function that numba has compiled
        py_func = as_function(py_func)
        if not inspect.isfunction(py_func):
            hint = "decorate a plain Python function; vividc passes it to numba by itself"
            raise KernelError(f"a kernel cannot be made of {quoted(py_func)}", hint=hint)
        model = options.get("error_model", error_model)
        fast = _may_reassociate(options.get("fastmath", False))
        made = KernelFunction(py_func, signature, name, model, fast)
        return made if like is None else made.sized(like)

    return decorate


def _may_reassociate(fastmath: object) -> bool:
    """Whether numba's option is leave to sum in any order."""
    flags = fastmath if isinstance(fastmath, set | frozenset | list | tuple) else ()
    return fastmath is True or not {"reassoc", "fast"}.isdisjoint(flags)


def _parse(signature: _Signature, loc: SourceLoc) -> tuple[tuple[Any, ...], Any]:
    hint = _SIGNATURE_HINT
    try:
        parsed = sigutils.normalize_signature(signature)
    except (SyntaxError, NameError, TypeError, AttributeError, ValueError, KeyError) as error:
        what = error.msg if isinstance(error, SyntaxError) else plain(str(error))
        reason = f"the signature {quoted(signature)} cannot be read: {what}"
        raise KernelError(reason, loc=loc, hint=hint) from error
    args, return_type = parsed
    return tuple(map(in_arrays, args)), return_type


def _params(
    py_func: Callable[..., Any], args: tuple[Any, ...], loc: SourceLoc
) -> tuple[Param, ...]:
    declared = inspect.signature(py_func).parameters.values()
    for parameter in declared:
        if parameter.kind is not inspect.Parameter.POSITIONAL_OR_KEYWORD:
            raise KernelError(
                f"parameter {parameter.name} is not an ordinary one",
                loc=loc,
                hint="a kernel has positional parameters only",
            )
    if len(declared) != len(args):
        raise KernelError(
            f"the signature and the function have {len(args)} and {len(declared)} parameters",
            loc=loc,
            hint="give one type for each parameter",
        )
    made = (_param(p.name, type_, loc) for p, type_ in zip(declared, args, strict=True))
    return tuple(_with_default(m, p.default) for m, p in zip(made, declared, strict=True))


def _with_default(param: Param, default: object) -> Param:
    """The parameter with the number that the function gives it where the caller does not."""
    if isinstance(default, np.generic):
        default = default.item()
    if param.ndim or not isinstance(default, bool | int | float):
        return param
    return replace(param, default=(default,))


def default_types(py_func: Callable[..., Any], given: int) -> tuple[Any, ...]:
    """Types of the parameters that a signature leaves out, as their defaults have: integers of 64
    bits, and floats of 32.
    """
    rest = [*inspect.signature(py_func).parameters.values()][given:]
    if not rest or not all(isinstance(p.default, bool | int | float | np.generic) for p in rest):
        return ()
    return tuple(
        types.float32 if isinstance(p.default, float) else numba.typeof(p.default) for p in rest
    )


def _param(name: str, type_: Any, loc: SourceLoc) -> Param:
    if type_ in _SCALARS:
        dtype = _SCALARS[type_]
        return Param(name, dtype, words=1 + (dtype is DType.C64))
    if not isinstance(type_, types.Array) or type_.dtype not in _ELEMENTS:
        reason = f"parameter {name} has type {plain(str(type_))}, which the array cannot hold"
        raise KernelError(reason, loc=loc, hint=_SUPPORTED)
    if type_.layout != "C":
        reason = f"array {name} is not contiguous in C order ({plain(str(type_))})"
        hint = f"write {plain(str(type_.copy(layout='C')))}, and pass np.ascontiguousarray(array)"
        raise KernelError(reason, loc=loc, hint=hint)
    if not 1 <= type_.ndim <= MAX_NDIM:
        reason = f"array {name} has {type_.ndim} dimensions"
        raise KernelError(reason, loc=loc, hint=f"arrays have one to {MAX_NDIM} dimensions")
    return Param(name, _ELEMENTS[type_.dtype], type_.ndim)

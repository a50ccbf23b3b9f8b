"""From a Python function to `ssa.ir.Function`: the stages in order, and numba's errors as
the user's.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from numba.core.errors import NumbaError, UnsupportedBytecodeError

from vividc.errors import InternalError, KernelError, SourceLoc, warn
from vividc.frontend.advice import Advice
from vividc.frontend.llvm.passes import ENTRY
from vividc.frontend.llvm.reader import read_function
from vividc.frontend.memory.user_raises import hold_raises
from vividc.frontend.narrow.counting import word_parameters
from vividc.frontend.narrow.in_words import in_words
from vividc.frontend.narrow.narrow import narrow
from vividc.frontend.numba.entry import optimised_ir
from vividc.frontend.numba.returned import parts_of
from vividc.frontend.numba.target import NumbaModule, numba_module
from vividc.frontend.refused.diagnose import behind, construct_at, diagnose, returned_at
from vividc.frontend.refused.length import refuse_long, refuse_long_code
from vividc.frontend.stages import SIMPLIFYING, TIDYING, without_pointers
from vividc.host.watch import aside, run_passes, seldom, watched
from vividc.lang.numba_words import is_numbas, plain
from vividc.machine.params import WIDE_DTYPES, DType, Param
from vividc.ssa.check import check_function
from vividc.ssa.ir import Function

# What numba raises for functions that it did not foresee.
_NUMBA_FAULTS: tuple[type[Exception], ...] = (
    NumbaError,
    UnsupportedBytecodeError,
    NotImplementedError,
    ImportError,
    LookupError,
    TypeError,
    ValueError,
    SyntaxError,
    RecursionError,
    AttributeError,
)
_RETURNS = {dtype.value: dtype for dtype in DType if dtype is not DType.C64} | {"none": None}


_DEMOTED = (
    "float64 arithmetic",
    "runs in float32",
    Advice("write np.float32(...) around constants", c="write constants as 1.0f, not 1.0"),
)
_SATURATED = (
    "a float converted to a 64-bit integer",
    "saturates at 32 bits",
    Advice("write np.int32(...) around the float", c="cast the float to int32_t"),
)


@seldom()
def lower(
    py_func: Callable[..., object],
    name: str,
    params: tuple[Param, ...],
    args: tuple[Any, ...],
    return_type: Any,
    loc: SourceLoc,
    *,
    strict_fp: bool = False,
    words_at: Collection[int] = (),
) -> Function:
    """Lower a kernel.

    Parameters
    ----------
    params, args
        The parameters as the compiler sees them, and as numba types.
    return_type
        Numba type, or None to infer it.
    loc
        Where the kernel is defined.
    strict_fp
        Refuse float64 arithmetic instead of warning about it.
    words_at
        Lines whose 64-bit integers are taken to be cast to int32, as of `in_words`.

    Raises
    ------
    KernelError
        The function uses something that cannot be compiled.

    Warns
    -----
    VividcWarning
        Once for each line whose float64 arithmetic runs in float32, or whose conversion of a float
        to an integer saturates at 32 bits.
    """
    module = _typed(py_func, args, return_type, loc)
    kind = str(module.returned)
    parts = None if kind in _RETURNS else parts_of(module.returned)
    if kind not in _RETURNS and parts is None:
        raise _no_result(kind, py_func.__name__, loc)
    with _in_python(loc, py_func.__name__), located(loc):
        kernel, params = _read(module, params, loc, words_at)
        if parts is not None and kernel.results is not None:
            kernel = replace(kernel, results=replace(kernel.results, form=parts.form))
        returns = _RETURNS.get(kind)
        return lower_words(kernel, name, params, returns, loc, strict_fp=strict_fp)


def _no_result(kind: str, name: str, loc: SourceLoc) -> KernelError:
    """The error of what no kernel returns, by numba's name of its type."""
    if "generator(" in kind:
        return construct_at(loc, name) or KernelError("a generator", loc=loc)
    hint = "return numbers, arrays of float32, complex64, bool or integers, or tuples of them"
    kind = plain(kind)
    what = "a string" if kind.startswith("'") else kind
    return KernelError(f"the kernel returns {what}", loc=returned_at(loc, name), hint=hint)


def _read(
    module: NumbaModule, params: tuple[Param, ...], loc: SourceLoc, words_at: Collection[int]
) -> tuple[Function, tuple[Param, ...]]:
    """The kernel without pointers, and its parameters with the words each needs."""

    def read() -> Function:
        text = optimised_ir(module, params, loc)
        made = without_pointers(read_function(text, ENTRY, loc.file), text)
        refuse_long(made, loc)
        return in_words(made, words_at) if words_at else made

    params = tuple(replace(p, words=2) if p.dtype in WIDE_DTYPES else p for p in params)
    kernel = read()
    words = counting_parameters(kernel, params)
    params = tuple(replace(p, words=1) if p.name in words else p for p in params)
    return (read() if words else kernel), params


def counting_parameters(kernel: Function, params: tuple[Param, ...]) -> frozenset[str]:
    """Names of the 64-bit parameters that only count or index: one word each."""
    if all(param.words == 1 or param.known for param in params):
        return frozenset()
    with aside():
        params = (*params, *kernel.params)
        return word_parameters(run_passes(SIMPLIFYING, replace(kernel, params=params)))


@contextmanager
def located(loc: SourceLoc) -> Iterator[None]:
    """Give an error that names no line the kernel's."""
    try:
        yield
    except KernelError as error:
        if error.loc is not None:
            raise
        raise KernelError(error.reason, loc=loc, hint=error.hint) from error


@contextmanager
def _in_python(loc: SourceLoc, name: str) -> Iterator[None]:
    """Numba compiles some of what no array runs, such as print, to calls of its runtime: name the
    construct instead of the call.
    """
    try:
        yield
    except KernelError as error:
        better = behind(error, loc, name)
        if better is None:
            raise
        raise better from error


def lower_words(
    kernel: Function,
    name: str,
    params: tuple[Param, ...],
    returns: DType | None,
    loc: SourceLoc,
    *,
    file: str = "",
    strict_fp: bool = False,
    worded: Callable[[str], str] = str,
) -> Function:
    """Narrow a function without pointers to words; errors, warnings and parameters as of `lower`.

    Parameters
    ----------
    file
        What the program names as its source; the file of `loc` if empty.
    worded
        Puts advice in the words of the kernel's language.
    """
    params = (*params, *kernel.params)  # of the kernel itself those are that it makes
    function = replace(kernel, name=name, params=params, returns=returns, file=file or loc.file)
    with located(loc):
        function = hold_raises(run_passes(SIMPLIFYING, function))
        narrowed = watched("narrow", lambda: narrow(function))
    for lines, (*what, instead) in (
        (narrowed.demoted, _DEMOTED),
        (narrowed.saturated, _SATURATED),
    ):
        _report(lines, loc, (*what, worded(instead)), strict_fp=strict_fp)
    words = run_passes(TIDYING, narrowed.function)
    problems = check_function(words)
    if problems:
        raise InternalError(f"the lowered kernel {name} is malformed: {'; '.join(problems)}")
    return words


def _typed(
    py_func: Callable[..., object], args: tuple[Any, ...], return_type: Any, loc: SourceLoc
) -> NumbaModule:
    refuse_long_code(py_func, loc)
    try:
        return numba_module(py_func, args, return_type)
    except (AssertionError, RuntimeError) as error:
        if not isinstance(error, _NUMBA_FAULTS) and not is_numbas(error):
            raise
        raise diagnose(error, loc, py_func.__name__) from error
    except _NUMBA_FAULTS as error:
        raise diagnose(error, loc, py_func.__name__) from error


def _report(
    lines: tuple[SourceLoc | None, ...],
    kernel: SourceLoc,
    difference: tuple[str, ...],
    *,
    strict_fp: bool,
) -> None:
    """Warn of (what, what happens to it, what to write instead) once a line, or refuse it."""
    what, happens, instead = difference
    for loc in sorted({loc or kernel for loc in lines}):
        if strict_fp:
            raise KernelError(what, loc=loc, hint=instead)
        warn(f"{loc}: {what} {happens}; {instead}")

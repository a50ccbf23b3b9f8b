"""From a Python function to `cfg.Function`: the frontend's stages in order, and numba's errors as
the user's.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from numba.core.errors import NumbaError

from vividc.dfg.cfg import MAX_DIMENSION, WIDE_DTYPES, DType, Function, Param
from vividc.dfg.cfg_check import check_function
from vividc.errors import InternalError, KernelError, SourceLoc, VividcWarning
from vividc.frontend.counting import word_parameters
from vividc.frontend.flags import load_flags
from vividc.frontend.floor_division import recover_divisions, truncate_divisions
from vividc.frontend.hoist import hoist_invariants
from vividc.frontend.interval import Interval
from vividc.frontend.llvm import ENTRY, optimised_ir
from vividc.frontend.llvm_text import read_function
from vividc.frontend.memory import resolve_memory
from vividc.frontend.narrow import Narrowed, narrow, refuse_calls
from vividc.frontend.numba_target import NumbaModule, numba_module
from vividc.frontend.ranges import Ranges
from vividc.frontend.simplify import fold_by_ranges, recover_extensions
from vividc.frontend.single_trip import straighten_single_trips
from vividc.frontend.ssa import WideFunction, remove_dead, remove_unreachable
from vividc.frontend.subword import extend_loads, store_low_bits
from vividc.frontend.value_numbering import merge_equal

_ESCAPE = re.compile(r"\x1b\[[0-9;]*m")
_PLACE = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+)')
_RETURNS = {dtype.value: dtype for dtype in DType} | {"none": None}


_DEMOTED = (
    "float64 arithmetic",
    "runs in float32",
    "write np.float32(...) around constants",
)
_SATURATED = (
    "a float converted to a 64-bit integer",
    "saturates at 32 bits",
    "write np.int32(...) around the float",
)


def lower(
    py_func: Callable[..., object],
    name: str,
    params: tuple[Param, ...],
    args: tuple[Any, ...],
    return_type: Any,
    loc: SourceLoc,
    *,
    strict_fp: bool = False,
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
    if module.return_type not in _RETURNS:
        hint = "return one float32, bool or integer, or store results into an array"
        raise KernelError(f"the kernel returns {module.return_type}", loc=loc, hint=hint)
    with located(loc):
        wide, params = _read(module, params, loc)
    return lower_words(wide, name, params, _RETURNS[module.return_type], loc, strict_fp=strict_fp)


def _read(
    module: NumbaModule, params: tuple[Param, ...], loc: SourceLoc
) -> tuple[WideFunction, tuple[Param, ...]]:
    """The kernel without pointers, and its parameters with the words each needs."""

    def read() -> WideFunction:
        return prepared(read_function(optimised_ir(module, params, loc), ENTRY, loc.file))

    params = tuple(replace(p, words=2) if p.dtype in WIDE_DTYPES else p for p in params)
    wide = read()
    if all(p.words == 1 for p in params):
        return wide, params
    words = word_parameters(_simplified(wide, params))
    params = tuple(replace(p, words=1) if p.name in words else p for p in params)
    return (read() if words else wide), params


@contextmanager
def located(loc: SourceLoc) -> Iterator[None]:
    """Give an error that names no line the kernel's."""
    try:
        yield
    except KernelError as error:
        if error.loc is not None:
            raise
        raise KernelError(error.reason, loc=loc, hint=error.hint) from error


def lower_words(
    wide: WideFunction,
    name: str,
    params: tuple[Param, ...],
    returns: DType | None,
    loc: SourceLoc,
    *,
    file: str = "",
    strict_fp: bool = False,
    reword: Callable[[str], str] = str,
) -> Function:
    """Narrow a function without pointers to words; errors, warnings and parameters as of `lower`.

    Parameters
    ----------
    file
        What the program names as its source; the file of `loc` if empty.
    reword
        Puts the advice of warnings in the words of another language than Python.
    """
    with located(loc):
        narrowed = _narrowed(wide, name, params, returns, file or loc.file)
    for lines, (*what, instead) in (
        (narrowed.demoted, _DEMOTED),
        (narrowed.saturated, _SATURATED),
    ):
        _report(lines, loc, (*what, reword(instead)), strict_fp=strict_fp)
    function = merge_equal(hoist_invariants(narrowed.function))
    problems = check_function(function)
    if problems:
        raise InternalError(f"the lowered kernel {name} is malformed: {'; '.join(problems)}")
    return function


def prepared(wide: WideFunction) -> WideFunction:
    """What was read from LLVM, without dead code, calls that cannot run, and pointers.

    Raises
    ------
    KernelError
        The kernel calls what the array cannot run, never ends, or uses pointers other than into
        arrays.
    """
    wide = recover_divisions(remove_dead(remove_unreachable(wide)))
    refuse_calls(wide)
    if all(block.exit.targets for block in wide.blocks):
        raise KernelError("the kernel never ends", hint="give its loop a condition or a break")
    # Memory first: the other stages know no pointers.
    return straighten_single_trips(recover_extensions(resolve_memory(wide)))


def _narrowed(
    wide: WideFunction, name: str, params: tuple[Param, ...], returns: DType | None, file: str
) -> Narrowed:
    wide = _simplified(wide, params)
    return narrow(wide, Ranges(wide, _bounds(params)), name, params, returns, file)


def _simplified(wide: WideFunction, params: tuple[Param, ...]) -> WideFunction:
    """Without small integers in memory, and without what the ranges of values decide."""
    wide = load_flags(wide, _flag_arrays(params))
    wide = store_low_bits(extend_loads(wide))
    bounds = _bounds(params)
    wide = fold_by_ranges(wide, Ranges(wide, bounds))
    return truncate_divisions(wide, Ranges(wide, bounds))


def _flag_arrays(params: tuple[Param, ...]) -> frozenset[str]:
    return frozenset(param.name for param in params if param.ndim and param.dtype is DType.BOOL)


def _bounds(params: tuple[Param, ...]) -> dict[str, Interval]:
    """Shapes: an array must fit in the scratchpad (checked at launch)."""
    bounds = {}
    for param in params:
        for axis in range(param.ndim):
            bounds[f"{param.name}.shape{axis}"] = (0, MAX_DIMENSION)
    return bounds


def _typed(
    py_func: Callable[..., object], args: tuple[Any, ...], return_type: Any, loc: SourceLoc
) -> NumbaModule:
    try:
        return numba_module(py_func, args, return_type)
    except (NumbaError, NotImplementedError, ImportError) as error:
        hint = None
        if "NRT required" in str(error):
            hint = "a kernel cannot make arrays, lists or copies of slices: pass arrays"
        raise KernelError(_readable(error), loc=_place(error, loc), hint=hint) from error


def _readable(error: Exception) -> str:
    """Numba's message without its colours, banner and advice."""
    lines = [line.strip() for line in _ESCAPE.sub("", str(error)).splitlines()]
    text = [
        line
        for line in lines
        if line and not line.startswith(("Failed in", "File ", "During:", ">>>"))
    ]
    return f"numba: {' '.join(text[:3])}"


def _place(error: Exception, loc: SourceLoc) -> SourceLoc:
    """The line in the user's file that numba names last: its messages go from the outer to the
    inner fault.
    """
    places = [
        int(match["line"])
        for match in _PLACE.finditer(_ESCAPE.sub("", str(error)))
        if loc.file.endswith(match["file"].lstrip("./"))
    ]
    return SourceLoc(loc.file, places[-1]) if places else loc


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
        warnings.warn(f"{loc}: {what} {happens}; {instead}", VividcWarning, stacklevel=2)

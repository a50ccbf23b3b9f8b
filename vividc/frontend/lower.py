"""From a Python function to `cfg.Function`: the frontend's stages in order, and numba's errors as
the user's.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from numba.core.errors import NumbaError, UnsupportedBytecodeError

from vividc.dfg.cfg import MAX_DIMENSION, MAX_ELEMENTS, DType, Function, Param
from vividc.dfg.cfg_check import check_function
from vividc.errors import InternalError, KernelError, SourceLoc, VividcWarning
from vividc.frontend.diagnose import construct_at, diagnose
from vividc.frontend.hoist import hoist_invariants
from vividc.frontend.interval import Interval
from vividc.frontend.llvm import ENTRY, optimised_ir
from vividc.frontend.llvm_text import read_function
from vividc.frontend.local_arrays import bounds_of_loads, hold_arrays, with_locals
from vividc.frontend.memory import resolve_memory
from vividc.frontend.narrow import Narrowed, narrow, refuse_calls
from vividc.frontend.numba_target import NumbaModule, numba_module
from vividc.frontend.overlap import fold_overlaps
from vividc.frontend.ranges import Ranges
from vividc.frontend.simplify import fold_by_ranges, recover_extensions
from vividc.frontend.single_trip import straighten_single_trips
from vividc.frontend.sizes import bounds_of_sizes
from vividc.frontend.ssa import remove_dead, remove_unreachable

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
        if "generator(" in module.return_type:
            raise construct_at(loc, py_func.__name__) or KernelError("a generator", loc=loc)
        hint = "return one float32, int32, uint32, int64 or bool, or store results into an array"
        raise KernelError(f"the kernel returns {module.return_type}", loc=loc, hint=hint)
    text = optimised_ir(module, params, loc)
    try:
        narrowed = _narrowed(text, name, params, _RETURNS[module.return_type], loc)
    except KernelError as error:
        if isinstance(error.loc, SourceLoc):
            # Numba compiles some of what no array runs, such as print, to calls of its runtime.
            is_call = "call" in error.reason
            better = construct_at(loc, py_func.__name__, error.loc.line) if is_call else None
            if better is None:
                raise
            raise better from error
        raise KernelError(error.reason, loc=loc, hint=error.hint) from error
    _report(narrowed.demoted, loc, _DEMOTED, strict_fp=strict_fp)
    _report(narrowed.saturated, loc, _SATURATED, strict_fp=strict_fp)
    function = hoist_invariants(narrowed.function)
    problems = check_function(function)
    if problems:
        raise InternalError(f"the lowered kernel {name} is malformed: {'; '.join(problems)}")
    return function


def _narrowed(
    text: str, name: str, params: tuple[Param, ...], returns: DType | None, loc: SourceLoc
) -> Narrowed:
    wide = remove_dead(remove_unreachable(read_function(text, ENTRY, loc.file)))
    holding = hold_arrays(fold_overlaps(wide), text)
    wide = remove_dead(holding.function)
    refuse_calls(wide)
    if all(block.exit.targets for block in wide.blocks):
        raise KernelError("the kernel never ends", hint="give its loop a condition or a break")
    # Memory first: the other stages know no pointers.
    wide = straighten_single_trips(recover_extensions(resolve_memory(wide, holding.arrays)))
    bounds = _bounds(params) | bounds_of_loads(wide, holding.arrays)
    bounds |= bounds_of_sizes(wide, MAX_ELEMENTS)
    wide = fold_by_ranges(wide, Ranges(wide, bounds))
    narrowed = narrow(wide, Ranges(wide, bounds), name, params, returns, loc.file)
    return replace(narrowed, function=with_locals(narrowed.function, holding.arrays))


def _bounds(params: tuple[Param, ...]) -> dict[str, Interval]:
    """Shapes: an array must fit in the scratchpad. Integer parameters are words (checked at
    launch).
    """
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
    except _NUMBA_FAULTS as error:
        raise diagnose(error, loc, py_func.__name__) from error


def _report(
    lines: tuple[SourceLoc | None, ...],
    kernel: SourceLoc,
    difference: tuple[str, str, str],
    *,
    strict_fp: bool,
) -> None:
    """Warn of (what, what happens to it, what to write instead) once a line, or refuse it."""
    what, happens, instead = difference
    for loc in sorted({loc or kernel for loc in lines}):
        if strict_fp:
            raise KernelError(what, loc=loc, hint=instead)
        warnings.warn(f"{loc}: {what} {happens}; {instead}", VividcWarning, stacklevel=2)

"""From a Python function to `cfg.Function`: the frontend's stages in order, and numba's errors as
the user's.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from typing import Any

from numba.core.errors import NumbaError

from vividc.dfg.cfg import MAX_DIMENSION, DType, Function, Param
from vividc.dfg.cfg_check import check_function
from vividc.dfg.transform.hoist import hoist_invariants
from vividc.errors import InternalError, KernelError, SourceLoc, VividcWarning
from vividc.frontend.interval import Interval
from vividc.frontend.llvm import ENTRY, optimised_ir
from vividc.frontend.llvm_text import read_function
from vividc.frontend.memory import resolve_memory
from vividc.frontend.narrow import Narrowed, narrow, refuse_calls
from vividc.frontend.numba_target import NumbaModule, numba_module
from vividc.frontend.ranges import Ranges
from vividc.frontend.simplify import fold_by_ranges, recover_extensions
from vividc.frontend.single_trip import straighten_single_trips
from vividc.frontend.ssa import remove_dead, remove_unreachable

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
        hint = "return one float32, int32, uint32, int64 or bool, or store results into an array"
        raise KernelError(f"the kernel returns {module.return_type}", loc=loc, hint=hint)
    text = optimised_ir(module, params, loc)
    try:
        narrowed = _narrowed(text, name, params, _RETURNS[module.return_type], loc)
    except KernelError as error:
        if error.loc is not None:
            raise
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
    refuse_calls(wide)
    if all(block.exit.targets for block in wide.blocks):
        raise KernelError("the kernel never ends", hint="give its loop a condition or a break")
    # Memory first: the other stages know no pointers.
    wide = straighten_single_trips(recover_extensions(resolve_memory(wide)))
    bounds = _bounds(params)
    wide = fold_by_ranges(wide, Ranges(wide, bounds))
    return narrow(wide, Ranges(wide, bounds), name, params, returns, loc.file)


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

"""Functions made by `numba.stencil`: numba writes the loops around them, which are typed and
lowered for our target as any other function is.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import compiler, errors, types
from numba.extending import overload, register_jitable
from numba.stencils import stencil
from numba.stencils.stencil import StencilFunc

from vividc.lang.formats import MISUSE

_overload: Callable[..., Callable[..., Any]] = functools.partial(overload, target="vividc")
_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable


class OwnStencil(StencilFunc):  # type: ignore[misc]
    """A stencil in kernels: numba's, with contexts and flags of our target."""

    def __init__(self, given: StencilFunc, typing: Any, target: Any, flags: Any) -> None:
        super().__init__(given.kernel_ir, given.mode, given.options)
        self._typingctx, self._targetctx, self._flags = typing, target, flags
        self._install_type(typing)

    def _type_me(self, argtys: tuple[Any, ...], kwtys: Any) -> Any:
        """The types of a call: numba's, but what is returned has the type of `out`, if given."""
        if not argtys or not isinstance(argtys[0], types.Array):
            hint = "pass the array whose elements it is computed of"
            raise errors.NumbaValueError(f"{MISUSE}a stencil of what is no array: {hint}")
        found = super()._type_me(argtys, kwtys)
        return found.replace(return_type=kwtys["out"]) if "out" in kwtys else found

    def compile_for_argtys(
        self, argtys: tuple[Any, ...], kwtys: Any, return_type: Any, sigret: Any
    ) -> Any:
        """The loops for arrays of these types; numba asks for them where it lowers a call."""
        with _written_for(self._flags):
            return super().compile_for_argtys(argtys, kwtys, return_type, sigret)


@contextmanager
def _written_for(flags: Any) -> Iterator[None]:
    """Numba looks these up in its modules whenever it writes the loops."""
    flags_before, check_before = compiler.DEFAULT_FLAGS, stencil.raise_if_incompatible_array_sizes
    compiler.DEFAULT_FLAGS, stencil.raise_if_incompatible_array_sizes = flags, _demand_sizes
    try:
        yield
    finally:
        compiler.DEFAULT_FLAGS = flags_before
        stencil.raise_if_incompatible_array_sizes = check_before


@_helper
def _demand_sizes(a: Any, *args: Any) -> None:
    """As numba's check of further arrays, without a loop over arrays of different types."""
    _demand_each(a, args)


def _demand_each(a: Any, others: Any) -> None:
    """Stands for `_overload_demand_each`."""


@_overload(_demand_each)
def _overload_demand_each(a: Any, others: Any) -> Callable[..., None]:
    def one_by_one(a: Any, others: Any) -> None:
        if a.ndim != others[0].ndim:
            raise ValueError(
                "Secondary stencil array does not have same number  of dimensions as the first "
                "stencil input."
            )
        for axis in range(a.ndim):
            if a.shape[axis] > others[0].shape[axis]:
                raise ValueError(
                    "Secondary stencil array has some dimension smaller the same dimension in the "
                    "first stencil input."
                )
        _demand_each(a, others[1:])

    def nothing(a: Any, others: Any) -> None:
        return None

    return one_by_one if len(others) else nothing


def own_stencil(given: StencilFunc, typing: Any, target: Any, flags: Any, model: str) -> OwnStencil:
    """The stencil of our target for one of the host's, in an error model."""
    name = f"_vividc_stencil_{model}"
    own: OwnStencil | None = getattr(given, name, None)
    if own is None:
        own = OwnStencil(given, typing, target, flags)
        setattr(given, name, own)
    return own

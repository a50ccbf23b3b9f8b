"""Functions made by `numba.guvectorize`: loops over the dimensions that their layout does not name,
around calls of what they were made of.

As on the host, a dimension of one element is broadcast, sizes that do not fit raise ValueError, and
a function with signatures converts numbers to those of the first that fits.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator
from typing import Any, Final

import numba
import numpy as np
from numba.core import types
from numba.core.cgutils import is_nonelike
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate
from numba.extending import overload
from numba.np import numpy_support
from numba.np.ufunc.gufunc import GUFunc

from vividc.frontend.numba.vectorized.written import free_name, function_like, function_of

_NO_FIT: Final = "operands could not be broadcast together"
_NO_CORE: Final = "operands differ in a core dimension"


@functools.lru_cache(maxsize=256)
def generalized_type(function: GUFunc) -> types.Function:
    """Its type in calls on arrays and numbers, with the arrays that it fills."""

    def generic(self: Any, args: Any, kws: Any) -> Any:
        made = None if kws else _loops_of(function, tuple(map(types.unliteral, args)))
        if made is None or is_nonelike(args[-1]):
            return None
        typed = self.context.resolve_value_type(made)
        found = typed.get_call_type(self.context, args, {})
        return None if found is None else signature(types.none, *args)

    name = f"generalized {function.__name__}"
    return types.Function(type(name, (AbstractTemplate,), {"key": function, "generic": generic}))


def call_whole(context: Any, builder: Any, sig: Any, args: Any, function: GUFunc) -> Any:
    """What a call on whole arrays does."""
    made = _loops_of(function, tuple(map(types.unliteral, sig.args)))
    return context.compile_internal(builder, made.py_func, sig, args)


def function_of_inputs(function: GUFunc, written: Callable[..., Any]) -> Callable[..., Any]:
    """A function, for numba, that makes and returns the results where they are left out or None.

    Parameters
    ----------
    written
        What `function` was made of.
    """
    names = tuple(inspect.signature(written).parameters)
    first = len(names) if function.is_dynamic else len(function.gufunc_builder.sin)
    heads = (*names[:first], *(f"{name}=None" for name in names[first:]))
    given = ", ".join(names)

    def loops(*kinds: Any) -> Any:
        made = _loops_of(function, tuple(map(types.unliteral, kinds)))
        return made and function_like(written, heads, f"{called}({given})", {called: made})

    called = free_name("_loops", {*names, written.__name__})
    stub = function_like(written, heads, "None", {})
    typing = function_like(written, heads, f"{called}({given})", {called: loops})
    overload(stub)(typing)
    return stub


@functools.lru_cache(maxsize=256)
def _loops_of(function: GUFunc, kinds: tuple[Any, ...]) -> Any:
    """The call on arguments of these types, written out, for numba; None: they do not fit."""
    builder = function.gufunc_builder
    cores = (*builder.sin, *builder.sout)
    inputs = len(builder.sin)
    if len(kinds) != len(cores):
        return None
    is_new = all(map(is_nonelike, kinds[inputs:]))
    for kind, core in zip(kinds[: inputs if is_new else None], cores, strict=False):
        if not isinstance(kind, types.Array | types.Number | types.Boolean):
            return None
        if getattr(kind, "ndim", 0) < len(core):
            return None
    inner = _inner_types(function, kinds, inputs, is_new=is_new)
    return inner and numba.njit(_Loops(function, kinds, inner, is_new=is_new).written())


def _inner_types(
    function: GUFunc, given: tuple[Any, ...], inputs: int, *, is_new: bool
) -> tuple[Any, ...] | None:
    """Numba's types of what it is called on for each step of the loops: those of its first
    signature that the arguments' can be converted to.
    """
    elements = function._get_ewise_dtypes(given)
    if function.is_dynamic:
        fitting = function._get_function_type(*given)
        return None if is_new else tuple(fitting.args)
    known = inputs if is_new else len(elements)
    for typed in function.gufunc_builder._sigs:
        compiled = function.gufunc_builder._cres[typed].signature.args
        wanted = function._get_ewise_dtypes(compiled)
        if all(map(_converts, elements[:inputs], wanted)) and (
            elements[inputs:known] == wanted[inputs:known]
        ):
            return tuple(compiled)
    return None


def _converts(kind: Any, wanted: Any) -> bool:
    return bool(np.can_cast(numpy_support.as_dtype(kind), numpy_support.as_dtype(wanted), "safe"))


class _Loops:
    """A function that is written out.

    The arguments of each step are parts of arrays: along the dimensions of the loops an element, in
    place of a number that the function takes as an array a part of one element.
    """

    def __init__(
        self,
        function: GUFunc,
        given: tuple[Any, ...],
        inner: tuple[Any, ...],
        *,
        is_new: bool,
    ) -> None:
        builder = function.gufunc_builder
        self._function = builder.py_func
        self._cores = (*builder.sin, *builder.sout)
        self._inputs = len(builder.sin)
        self._given, self._inner, self._is_new = given, inner, is_new
        self._names = [f"a{number}" for number in range(len(self._cores))]
        self._known: dict[str, Any] = {}
        taken = range(self._inputs if is_new else len(given))
        self._depth = max(self._loops(number) for number in taken)

    def _loops(self, number: int) -> int:
        """Dimensions of an argument that are looped over."""
        if number >= self._inputs and self._is_new:
            return self._depth
        return getattr(self._given[number], "ndim", 0) - len(self._cores[number])

    def _global(self, name: str, value: Any) -> str:
        """The name by which the function reads a value: its own name is taken."""
        name = free_name(name, {self._function.__name__})
        self._known[name] = value
        return name

    def written(self) -> Callable[..., Any]:
        """The function."""
        lines = [*self._checks(), *self._results(), *self._steps()]
        if self._is_new:
            lines.append(f"return {', '.join(map(self._returned, self._outputs))}")
        body = "\n".join(f"    {line}" for line in lines)
        text = f"def {self._function.__name__}({', '.join(self._names)}):\n{body}\n"
        return function_of(self._function, text, self._known)

    @property
    def _outputs(self) -> range:
        return range(self._inputs, len(self._cores))

    def _returned(self, number: int) -> str:
        """An array, or the number that it is of."""
        is_number = not self._depth and not self._cores[number]
        return f"r{number}[0]" if is_number else f"r{number}"

    def _result(self, number: int) -> str:
        """An argument that the call fills has its own name: a parameter keeps its type."""
        return f"r{number}" if number >= self._inputs and self._is_new else self._names[number]

    def _sizes(self, number: int) -> Iterator[tuple[int, str]]:
        """The loops that an argument has dimensions of, and their sizes."""
        count = self._loops(number)
        for axis in range(count):
            yield self._depth - count + axis, f"{self._result(number)}.shape[{axis}]"

    def _checks(self) -> Iterator[str]:
        """Sizes of the loops, and of the dimensions that the layout names."""
        known: dict[str, str] = {}
        for number in range(self._inputs if self._is_new else len(self._cores)):
            for loop, size in self._sizes(number):
                wrong = f"{size} != n{loop}"
                if f"n{loop}" not in known:
                    known[f"n{loop}"] = size
                    yield f"n{loop} = {size}"
                    continue
                if number < self._inputs:
                    yield f"if n{loop} == 1: n{loop} = {size}"
                    wrong = f"{size} != 1 and {wrong}"
                yield f"if {wrong}: raise ValueError({_NO_FIT!r})"
            for axis, symbol in enumerate(self._cores[number], self._loops(number)):
                size = f"{self._names[number]}.shape[{axis}]"
                if symbol in known:
                    yield f"if {size} != {known[symbol]}: raise ValueError({_NO_CORE!r})"
                else:
                    known[symbol] = f"c{len(known)}"
                    yield f"{known[symbol]} = {size}"
        self._symbols = known

    def _results(self) -> Iterator[str]:
        for number in self._outputs if self._is_new else ():
            loops = [f"n{loop}" for loop in range(self._depth)]
            shape = loops + [self._symbols[symbol] for symbol in self._cores[number]]
            of = numpy_support.as_dtype(self._inner[number].dtype).type
            kind, empty = self._global(f"t{number}", of), self._global("empty", np.empty)
            yield f"r{number} = {empty}(({', '.join(shape or ['1'])},), {kind})"

    def _steps(self) -> Iterator[str]:
        for loop in range(self._depth):
            yield f"{'    ' * loop}for i{loop} in range(n{loop}):"
        parts = map(self._part, range(len(self._cores)))
        inner = self._global("inner", numba.njit(self._function))
        yield f"{'    ' * self._depth}{inner}({', '.join(parts)})"

    def _part(self, number: int) -> str:
        """What a step takes of an argument."""
        name, core, inner = self._result(number), self._cores[number], self._inner[number]
        is_array = isinstance(inner, types.Array)
        if isinstance(self._given[number], types.Number | types.Boolean):
            value = self._converted(number, name)
            return f"{self._global('array', np.array)}([{value}])" if is_array else value
        places = []
        for loop, size in self._sizes(number):
            is_broadcast = number < self._inputs
            places.append(f"(i{loop} if {size} != 1 else 0)" if is_broadcast else f"i{loop}")
        if is_array and not core and places:
            places[-1] = f"{places[-1]}:{places[-1]} + 1"
        places += [":"] * len(core)
        part = f"{name}[{', '.join(places)}]" if places else name
        return self._converted(number, part)

    def _converted(self, number: int, part: str) -> str:
        """With elements of the type that the signature has."""
        inner = self._inner[number]
        wanted = getattr(inner, "dtype", inner)
        given = self._given[number]
        if number >= self._inputs or getattr(given, "dtype", given) == wanted:
            return part
        kind = self._global(f"t{number}", numpy_support.as_dtype(wanted).type)
        is_part = isinstance(given, types.Array) and isinstance(inner, types.Array)
        return f"{part}.astype({kind})" if is_part else f"{kind}({part})"

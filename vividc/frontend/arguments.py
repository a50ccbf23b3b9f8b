"""Arguments that numba takes and no program holds: None and strings are constants of a program,
tuples are as many arguments as they have parts.

A function that takes such is a kernel by another one, of the arguments that are left, which calls
it: `def scaled(x, by_0, by_1): return _given(x, (by_0, by_1), None)`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numba

from vividc.frontend.numba.vectorized.functions import as_function
from vividc.frontend.numba.vectorized.written import free_name, function_like


@dataclass(frozen=True, slots=True)
class Constant:
    """An argument that is a constant: None or a string."""

    value: str | None


@dataclass(frozen=True, slots=True)
class Parts:
    """An argument that is a tuple of arguments; `kind`: its class."""

    kind: type
    forms: tuple[Form, ...]


Form = Constant | Parts | None
"""What an argument is; None: an array or a number."""


def form_of(value: object) -> Form:
    """What an argument is."""
    if value is None or isinstance(value, str):
        return Constant(value)
    if isinstance(value, tuple):
        return Parts(type(value), tuple(map(form_of, value)))
    return None


def left_of(name: str, value: object, form: Form) -> Iterator[tuple[str, object]]:
    """The arrays and numbers of an argument, by name."""
    if form is None:
        yield name, value
    elif isinstance(form, Parts):
        assert isinstance(value, tuple)
        for number, (part, its_form) in enumerate(zip(value, form.forms, strict=True)):
            yield from left_of(f"{name}_{number}", part, its_form)


def function_of_rest(
    given: Callable[..., Any], forms: Sequence[Form], error_model: str
) -> Callable[..., Any]:
    """A function of the arrays and numbers that are left of the arguments of `given`.

    Parameters
    ----------
    given
        A Python function, or one that numba has compiled, whose options it has.
    forms
        What each of its arguments is.
    error_model
        Numba's, of a Python function.
    """
    written = as_function(given)
    options = {"error_model": error_model} | getattr(given, "targetoptions", {})
    options = {name: options[name] for name in ("error_model", "fastmath") if name in options}
    is_open = getattr(given, "_can_compile", False)  # numba's, without signatures of its own
    called = given if is_open else numba.njit(**options)(written)
    names: list[str] = []
    texts: list[str] = []
    declared = inspect.signature(written).parameters
    taken = frozenset((*declared, written.__name__))
    own = free_name("_given", taken)
    known: dict[str, Any] = {own: called}
    for name, form in zip(declared, forms, strict=False):
        texts.append(_text(name, form, names, known, taken))
    made = function_like(written, names, f"{own}({', '.join(texts)})", known)
    function: Callable[..., Any] = numba.njit(**options)(made)
    return function


def _text(
    name: str, form: Form, names: list[str], known: dict[str, Any], taken: frozenset[str]
) -> str:
    """An argument as it is passed on; what it consists of is added to the names."""
    if isinstance(form, Constant):
        return repr(form.value)
    if form is None:
        names.append(name)
        return name
    parts: list[str] = []
    for number, part in enumerate(form.forms):
        its_name = free_name(f"{name}_{number}", {*taken, *names, *known})
        parts.append(_text(its_name, part, names, known, taken))
    if form.kind is tuple:
        return f"({', '.join(parts)},)" if parts else "()"
    kind = free_name(f"_{name}", {*taken, *names, *known})
    known[kind] = form.kind
    return f"{kind}({', '.join(parts)})"

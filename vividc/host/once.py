"""Immutable objects: what follows from one is computed only once for it, and many are made soon."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from functools import partial, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

_Object = TypeVar("_Object")
_Rest = ParamSpec("_Rest")
_Result = TypeVar("_Result")
_Kept = dict[tuple[object, ...], _Result]


def once_each(
    function: Callable[Concatenate[_Object, _Rest], _Result],
) -> Callable[Concatenate[_Object, _Rest], _Result]:
    """`function`, whose results are kept as long as its first argument lives: nobody may change
    them. Other arguments are given by position.

    By the object's identity: equal ones are not looked for (a fabric has no hash, and comparing
    SSA functions takes longer than most analyses). A result that leads to the object would keep it
    for ever. What lets results go is not Python code: an interrupt that came to it would be lost.
    """
    results: dict[int, tuple[weakref.ref[_Object], _Kept[_Result]]] = {}

    @wraps(function)
    def kept(given: _Object, /, *rest: _Rest.args, **named: _Rest.kwargs) -> _Result:
        assert not named
        key = id(given)
        if key not in results:
            results[key] = weakref.ref(given, partial(results.pop, key)), {}
        known = results[key][1]
        if rest not in known:
            known[rest] = function(given, *rest, **named)
        return known[rest]

    return kept


def once_within(function: Callable[[_Object], _Result]) -> Callable[[_Object], _Result]:
    """As `once_each`, kept in the object itself: the result may lead to it."""
    name = f"{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def kept(given: _Object) -> _Result:
        results = vars(given)
        if name not in results:
            results[name] = function(given)
        return cast(_Result, results[name])

    return kept


_CHANGED: dict[type, Callable[..., Any]] = {}


def made_soon(given: type[_Object]) -> type[_Object]:
    """A frozen dataclass with slots, of fields with plain defaults if any and nothing to do behind
    them: its objects are made in half the time. Python would look for each slot by its name.
    """
    own: tuple[Field[Any], ...] = fields(cast(Any, given))
    names: dict[str, Any] = {"_given": given, "_same": object()}
    names |= {f"_set_{one.name}": getattr(given, one.name).__set__ for one in own}
    names |= {f"_default_{one.name}": one.default for one in own if one.default is not MISSING}
    taken = ", ".join(
        one.name if one.default is MISSING else f"{one.name}=_default_{one.name}" for one in own
    )
    lines = [f"    _set_{one.name}(self, {one.name})" for one in own]
    every = ", ".join(f"{one.name}=_same" for one in own)
    kept = ", ".join(f"self.{n} if {n} is _same else {n}" for n in (one.name for one in own))
    text = [f"def made(self, {taken}):", *lines, f"def changed(self, {every}):"]
    exec("\n".join([*text, f"    return _given({kept})"]), names)
    given.__init__ = names["made"]  # type: ignore[method-assign]
    _CHANGED[given] = names["changed"]
    return given


def changed(given: _Object, /, **changes: object) -> _Object:
    """As `dataclasses.replace`, of what is `made_soon`, in a third of its time."""
    return cast(_Object, _CHANGED[type(given)](given, **changes))

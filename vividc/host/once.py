"""Computes what follows from an immutable object only once for it."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import partial, wraps
from typing import Concatenate, ParamSpec, TypeVar, cast

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

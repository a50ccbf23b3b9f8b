"""Mappers by name: the built-in ones, those of this process and those of other packages."""

from __future__ import annotations

from functools import wraps
from importlib.metadata import entry_points
from typing import Final, cast

from vividc.errors import InternalError, VividcError, demand_type
from vividc.mapper.problem import MapProblem
from vividc.mapper.published.ims import ims
from vividc.mapper.published.sat_kms import sat_kms
from vividc.mapper.published.spr import spr
from vividc.mapper.request import Mapper, MapRequest
from vividc.mapper.result import MapResult
from vividc.mapper.search.portfolio import auto, cpsat, decoupled

ENTRY_POINT_GROUP: Final = "vividc.mappers"

BUILT_IN: Final[dict[str, Mapper]] = {
    "auto": auto,
    "cpsat": cpsat,
    "decoupled": decoupled,
    "sat-kms": sat_kms,
    "ims": ims,
    "spr": spr,
}


EXTENSIBLE: Final = frozenset({"auto", "cpsat", "decoupled"})


_REGISTERED: Final[dict[str, Mapper]] = {}
_GIVEN: Final[dict[str, Mapper]] = {}
_REPORT: Final = "report it to the package that provides it, or choose another (--mapper auto)"
"""Of this process, by name: registered, and given as functions, which no list has."""


def register(name: str, mapper: Mapper) -> None:
    """Make a function a mapper of this process: `map_dfg(mapper=name)`, `compile(mapper=name)`.

    A name that was registered before is given the new function.

    Parameters
    ----------
    mapper
        A function (MapProblem, MapRequest) -> MapResult, whose mappings are verified.

    Raises
    ------
    VividcError
        The name is that of a built-in mapper or no word, or the mapper is not callable.
    """
    demand_type(name, str, "the mapper's name", 'give a word, as "one-pe"')
    if name in BUILT_IN or not name.strip():
        what = f"the name of a mapper cannot be {name!r}"
        raise VividcError(what, loc="mapper", hint="choose another, as one-pe")
    if not callable(mapper):
        hint = "give a function (MapProblem, MapRequest) -> MapResult"
        raise VividcError(f"mapper {name!r} is not callable", loc="mapper", hint=hint)
    _REGISTERED[name] = mapper


def unregister(name: str) -> None:
    """Take back what `register` did, if it did.

    Raises
    ------
    VividcError
        The name is no text.
    """
    demand_type(name, str, "the mapper's name", 'give a word, as "one-pe"')
    _REGISTERED.pop(name, None)


def named(mapper: str | Mapper) -> str:
    """The name of a mapper; a function that is given in place of one is known by its own.

    Raises
    ------
    VividcError
        It is neither a name nor a function.
    """
    if isinstance(mapper, str):
        return mapper
    if not callable(mapper):
        hint = 'give a name, as "auto", or a function (MapProblem, MapRequest) -> MapResult'
        demand_type(mapper, str, "the mapper", hint)
    name = f"{getattr(mapper, '__module__', '')}:{getattr(mapper, '__qualname__', repr(mapper))}"
    _GIVEN[name] = mapper
    return name


def takes_constraints(name: str) -> bool:
    """Whether a mapper applies a caller's constraints to its model (`MapRequest.extend`). A guest
    declares it by an attribute `takes_constraints = True` of its function.
    """
    return name in EXTENSIBLE or bool(getattr(find_mapper(name), "takes_constraints", False))


def mapper_names() -> tuple[str, ...]:
    """Names of all mappers, the built-in ones first."""
    guests = sorted(point.name for point in entry_points(group=ENTRY_POINT_GROUP))
    return tuple(dict.fromkeys([*BUILT_IN, *_REGISTERED, *guests]))


def find_mapper(name: str) -> Mapper:
    """The mapper called `name`. Built-in names cannot be taken over.

    Raises
    ------
    VividcError
        No mapper has this name, or its package does not load.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]
    own = _REGISTERED.get(name) or _GIVEN.get(name)
    if own is not None:
        return _guarded(name, own)
    for point in entry_points(group=ENTRY_POINT_GROUP, name=name):
        return _load(name, point.load)
    known = ", ".join(mapper_names())
    raise VividcError(f"unknown mapper {name!r}", loc="mapper", hint=f"choose one of: {known}")


def _load(name: str, load: object) -> Mapper:
    if not callable(load):
        raise VividcError(f"mapper {name!r} cannot be loaded", loc="mapper")
    try:
        mapper = load()
    except (ImportError, AttributeError) as error:
        hint = "reinstall the package that provides it"
        raise VividcError(
            f"mapper {name!r} cannot be loaded: {error}", loc="mapper", hint=hint
        ) from error
    if not callable(mapper):
        hint = "its entry point must name a function (MapProblem, MapRequest) -> MapResult"
        raise VividcError(f"mapper {name!r} is not callable", loc="mapper", hint=hint)
    return _guarded(name, cast(Mapper, mapper))


def _guarded(name: str, guest: Mapper) -> Mapper:
    """The guest, with its faults reported as its own and not as bugs of vividc."""

    @wraps(guest)
    def run(problem: MapProblem, request: MapRequest) -> MapResult:
        try:
            result = guest(problem, request)
        except (VividcError, InternalError):
            raise
        except Exception as error:
            what = f"{type(error).__name__}: {error}"
            raise guest_fault(name, f"failed with {what}") from error
        if not isinstance(result, MapResult):
            raise guest_fault(
                name,
                f"returned a {type(result).__name__} instead of a MapResult",
                "return one, with the status `timeout` if there is no mapping (docs/mappers.md)",
            )
        return result

    return run


def guest_fault(name: str, what: str, hint: str = _REPORT) -> VividcError:
    """What a mapper of another package, or of the user, did wrong."""
    return VividcError(f"mapper {name!r} {what}", loc="mapper", hint=hint)

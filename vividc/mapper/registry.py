"""Mappers by name: the built-in ones and those that other packages register."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Final, cast

from vividc.errors import VividcError
from vividc.mapper.ims import ims
from vividc.mapper.portfolio import auto, cpsat, decoupled
from vividc.mapper.request import Mapper
from vividc.mapper.sat_kms import sat_kms
from vividc.mapper.spr import spr

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


def takes_constraints(name: str) -> bool:
    """Whether a mapper applies what a caller adds to the model (`MapRequest.extend`). A guest says
    so by an attribute `takes_constraints = True` of its function.
    """
    return name in EXTENSIBLE or bool(getattr(find_mapper(name), "takes_constraints", False))


def mapper_names() -> tuple[str, ...]:
    """Names of all mappers, the built-in ones first."""
    guests = sorted(point.name for point in entry_points(group=ENTRY_POINT_GROUP))
    return tuple(dict.fromkeys([*BUILT_IN, *guests]))


def find_mapper(name: str) -> Mapper:
    """The mapper called `name`. Built-in names cannot be taken over.

    Raises
    ------
    VividcError
        No mapper has this name, or its package does not load.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]
    for point in entry_points(group=ENTRY_POINT_GROUP, name=name):
        return _load(name, point.load)
    known = ", ".join(mapper_names())
    raise VividcError(f"unknown mapper {name!r}", loc="mapper", hint=f"choose one of: {known}")


def _load(name: str, load: object) -> Mapper:
    if not callable(load):
        raise VividcError(f"mapper {name!r} cannot be loaded", loc="mapper")
    try:
        found = load()
    except (ImportError, AttributeError) as error:
        hint = "reinstall the package that provides it"
        raise VividcError(
            f"mapper {name!r} cannot be loaded: {error}", loc="mapper", hint=hint
        ) from error
    if not callable(found):
        hint = "its entry point must name a function (MapProblem, MapRequest) -> MapResult"
        raise VividcError(f"mapper {name!r} is not callable", loc="mapper", hint=hint)
    return cast(Mapper, found)

"""Sizes that stand in for those of a user's launches: what loops of unknown length are assumed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from vividc.machine.params import DType
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function, Input, Instr, Phi, Ref, Value, definition_of

_OF_NESTS, _OF_LOOPS = 24, 240
"""Near what is assumed of loops whose length is not known. 4 and 8 divide them, as they do most
users'; they are no powers of two, by which a division would be a shift.
"""

_NO_SIZES = (DType.F32, DType.F16, DType.BOOL)


def stand_in_sizes(function: Function) -> dict[str, int | tuple[int, ...]]:
    """Sizes of the parameters that are not known yet: shapes, and integers that bound loops."""
    loops = find_loops(function)
    nested = [a for a in loops if any(_is_inside(a, b) or _is_inside(b, a) for b in loops)]
    alone = _bounds(function, [loop for loop in loops if loop not in nested])
    in_nests = _bounds(function, nested)
    like: dict[str, int | tuple[int, ...]] = {}
    for param in function.params:
        is_alone = param.name in alone - in_nests or not nested
        size = _OF_LOOPS if is_alone else _OF_NESTS
        if param.known:
            like[param.name] = param.known if param.ndim else param.known[0]
        elif param.ndim and not param.flat:
            like[param.name] = (size,) * param.ndim
        elif not param.ndim and param.dtype not in _NO_SIZES and param.name in alone | in_nests:
            like[param.name] = size
    return {} if all(param.known for param in function.params if param.name in like) else like


def _is_inside(inner: Loop, outer: Loop) -> bool:
    return inner is not outer and inner.header in outer.blocks


def sizes_option(like: Mapping[str, int | tuple[int, ...]]) -> str:
    """The option of `vividc compile` that says them."""
    sizes = (
        f"{name}={'x'.join(map(str, size if isinstance(size, tuple) else (size,)))}"
        for name, size in like.items()
    )
    return f"--sizes {','.join(sizes)}"


def _bounds(function: Function, loops: Iterable[Loop]) -> set[str]:
    """Parameters that tests of these loops depend on."""
    names: set[str] = set()
    waiting: list[Value] = [
        cond
        for loop in loops
        for source, _ in loop.exits
        if (cond := function.by_name[source].branch.cond) is not None
    ]
    seen: set[int] = set()
    while waiting:
        value = waiting.pop()
        if isinstance(value, Input):
            names.add(value.key.split(".")[0])
        elif isinstance(value, Ref) and value.id not in seen:
            seen.add(value.id)
            waiting += _operands(definition_of(function, value))
    return names


def _operands(item: Phi | Instr | None) -> list[Value]:
    if isinstance(item, Phi):
        return [value for _, value in item.incoming]
    return [] if item is None else list(item.operands)

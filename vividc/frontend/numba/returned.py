"""What a kernel returns besides one word, taken apart: arrays, tuples, None.

Numba writes a returned value through a pointer. The entry function reads its scalars and arrays
from there, each a leaf, and hands them to calls of `RETURNED`, which pass through LLVM;
`frontend.memory.arrays.results` finds out afterwards where the arrays lie.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from numba.core import callconv, types
from numba.core.registry import cpu_target

from vividc.formats import F16
from vividc.frontend.llvm.calls import RETURNED, RETURNED_ARRAY
from vividc.lang.numba_types import TYPES
from vividc.ssa.results import LIST, NONE, OPTIONAL, TUPLE

_LLVM: Final = {
    types.float32: "float",
    types.float64: "double",
    types.boolean: "i8",
    **{
        getattr(types, f"{sign}int{bits}"): f"i{bits}"
        for sign in ("", "u")
        for bits in (8, 16, 32, 64)
    },
}
_PARTS: Final = {types.complex64: types.float32, types.complex128: types.float64}
"""Types of the parts of complex numbers, which numba's structure has in order."""
_POINTER: Final = re.compile(r"\w+\*+")
_DATA, _SHAPE, _STRIDES = 4, 5, 6
"""Members of numba's structure of an array."""
_IS_NONE: Final = -2
"""Numba's status of a call that returned None where there might be a value."""


@dataclass(frozen=True, slots=True)
class _Leaf:
    """A scalar (`ndim` None) or an array, and the members that lead to it; () and `is_status`: the
    flag that there is a value. `llvm`: the type of the scalar, or of its real and imaginary part.
    `item_bytes`: of the elements of a list, whose length and place a structure holds (`lists`).
    """

    dtype: str
    llvm: str
    path: tuple[int, ...]
    ndim: int | None = None
    is_status: bool = False
    item_bytes: int = 0

    @property
    def is_complex(self) -> bool:
        """Whether it has two parts."""
        return self.dtype.startswith("complex")

    def callee(self, number: int) -> str:
        kind = "" if self.ndim is None else RETURNED_ARRAY
        return f'@"{RETURNED}{number} {self.dtype}{kind}"'

    @property
    def types(self) -> str:
        if self.ndim is None:
            kind = "i8" if self.llvm == "i1" else self.llvm
            return ", ".join([kind] * (1 + self.is_complex))
        return ", ".join(["ptr", *["i64"] * (2 * self.ndim)])


@dataclass(frozen=True, slots=True)
class ReturnedParts:
    """A returned type taken apart.

    Attributes
    ----------
    type_text
        LLVM's of what numba writes.
    form
        As of `ssa.results.Results`.
    """

    type_text: str
    leaves: tuple[_Leaf, ...]
    form: tuple[int | str, ...]

    @property
    def declarations(self) -> Iterator[str]:
        """The callees that the leaves are handed to."""
        for number, leaf in enumerate(self.leaves):
            yield f"declare void {leaf.callee(number)}({leaf.types}) nounwind willreturn"

    def lines(self, pointer: str, status: str, debug: str) -> Iterator[str]:
        """Instructions that read what lies behind `pointer` and hand it over."""
        for number, leaf in enumerate(self.leaves):
            name = f"%..part{number}"
            if leaf.is_status:
                yield f"{name}.is = icmp ne i32 {status}, {_IS_NONE}"
                yield f"{name} = zext i1 {name}.is to i8"
                values = [f"i8 {name}"]
            elif leaf.ndim is None and leaf.is_complex:
                values = [f"{leaf.llvm} {name}.0", f"{leaf.llvm} {name}.1"]
                for part in (0, 1):
                    path = (*leaf.path, part)
                    yield from self._load(f"{name}.{part}", leaf.llvm, pointer, path)
            elif leaf.llvm == "i1":
                yield from self._load(f"{name}.bit", "i1", pointer, leaf.path)
                yield f"{name} = zext i1 {name}.bit to i8"
                values = [f"i8 {name}"]
            elif leaf.ndim is None:
                yield from self._load(name, leaf.llvm, pointer, leaf.path)
                values = [f"{leaf.llvm} {name}"]
            elif leaf.item_bytes:
                header = f"{name}.list"
                yield from self._load(header, "ptr", pointer, (*leaf.path, 0))
                yield f"{name}.size = load i64, ptr {header}"
                yield f"{name}.at = getelementptr inbounds {{i64, ptr}}, ptr {header}, i32 0, i32 1"
                yield f"{name} = load ptr, ptr {name}.at"
                values = [f"ptr {name}", f"i64 {name}.size", f"i64 {leaf.item_bytes}"]
            else:
                members: list[tuple[str, tuple[int, ...]]] = [("ptr", (_DATA,))]
                members += [("i64", (_SHAPE, axis)) for axis in range(leaf.ndim)]
                members += [("i64", (_STRIDES, axis)) for axis in range(leaf.ndim)]
                values = []
                for at, (kind, member) in enumerate(members):
                    yield from self._load(f"{name}.{at}", kind, pointer, (*leaf.path, *member))
                    values.append(f"{kind} {name}.{at}")
            yield f"call void {leaf.callee(number)}({', '.join(values)}), {debug}"

    def _load(self, name: str, kind: str, pointer: str, path: Sequence[int]) -> Iterator[str]:
        if path:
            at = ", ".join(f"i32 {index}" for index in (0, *path))
            yield f"{name}.at = getelementptr inbounds {self.type_text}, ptr {pointer}, {at}"
            pointer = f"{name}.at"
        yield f"{name} = load {kind}, ptr {pointer}"


def parts_of(returned: Any) -> ReturnedParts | None:
    """The parts of a value of numba's type; None: the array has nothing like it."""
    leaves: list[_Leaf] = []
    form: list[int | str] = []
    kind = types.unliteral(returned)
    inner = kind.type if isinstance(kind, types.Optional) else kind
    flag = "i1" if isinstance(inner, types.UniTuple | types.NamedUniTuple) else "i8"
    if not _take_apart(kind, (), leaves, form, is_whole=True, flag=flag):
        return None
    pointer = callconv.MinimalCallConv(cpu_target.target_context).get_return_type(returned)
    text = _POINTER.sub("ptr", str(pointer.pointee))
    return ReturnedParts(text, tuple(leaves), tuple(form))


def _take_apart(
    kind: Any,
    path: tuple[int, ...],
    leaves: list[_Leaf],
    form: list[int | str],
    *,
    is_whole: bool = False,
    flag: str = "i8",
) -> bool:
    """Append the leaves of a type; whether it has only such as there are. `flag`: LLVM's type of a
    bool, a bit if the whole is a tuple of one type.
    """
    if isinstance(kind, types.NoneType):
        form.append(NONE)
        return True
    if isinstance(kind, types.Optional):
        form.append(len(leaves))
        leaves.append(_Leaf("bool", flag, () if is_whole else (*path, 1), is_status=is_whole))
        good = _take_apart(kind.type, path if is_whole else (*path, 0), leaves, form, flag=flag)
        form.append(OPTIONAL)
        return good
    if isinstance(kind, types.BaseTuple):
        for number, item in enumerate(kind.types):
            if not _take_apart(types.unliteral(item), (*path, number), leaves, form, flag=flag):
                return False
        form.append(" ".join((TUPLE, str(len(kind.types)), *_names(kind))))
        return True
    leaf = _leaf(kind, path, flag)
    if leaf is None:
        return False
    form.append(len(leaves))
    form += [LIST] * isinstance(kind, types.List)
    leaves.append(leaf)
    return True


def _leaf(kind: Any, path: tuple[int, ...], flag: str) -> _Leaf | None:
    """An array, a list or a scalar; None: it is none that there is."""
    if isinstance(kind, types.Array):
        return _array(kind, path)
    if isinstance(kind, types.List):
        part = kind.dtype
        if part not in _LLVM:
            return None
        return _Leaf(str(part), _LLVM[part], path, 1, item_bytes=_bytes_of(part))
    leaf = _scalar(kind, path)
    return replace(leaf, llvm=flag) if leaf is not None and kind == types.boolean else leaf


def _bytes_of(kind: Any) -> int:
    return 1 if isinstance(kind, types.Boolean) else int(kind.bitwidth) // 8


def _names(kind: Any) -> tuple[str, ...]:
    """Of a named tuple its name, and those of its parts."""
    named = isinstance(kind, types.NamedTuple | types.NamedUniTuple)
    return (kind.instance_class.__name__, *kind.fields) if named else ()


def _scalar(kind: Any, path: tuple[int, ...]) -> _Leaf | None:
    part = _PARTS.get(kind, kind)
    return _Leaf(str(kind), _LLVM[part], path) if part in _LLVM else None


def _array(kind: Any, path: tuple[int, ...]) -> _Leaf | None:
    if kind.dtype == TYPES[F16]:
        return _Leaf("float16", "i16", path, kind.ndim)
    part = _PARTS.get(kind.dtype, kind.dtype)
    if part not in _LLVM:
        return None
    return _Leaf(str(kind.dtype), _LLVM[part], path, kind.ndim)

"""Where lies what a kernel returns: calls of `RETURNED` become a description, and what of it only
the run decides becomes stores to an array of words.

An array of the kernel's own that it returns becomes a parameter that the launch makes: nothing
behind may take it for a temporary.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from vividc.errors import KernelError
from vividc.frontend.llvm.calls import RETURNED, RETURNED_ARRAY
from vividc.frontend.memory.arrays.local_arrays import OwnArray
from vividc.frontend.memory.arrays.places import is_returned, is_returned_array
from vividc.frontend.ranges.exact import exact_formula
from vividc.machine.params import DType, Formula, Param
from vividc.machine.words import WORD_BYTES
from vividc.ssa.edit import FreshIds, first_free
from vividc.ssa.ir import Function, Instr, Int, Ref, Value
from vividc.ssa.results import Leaf, Results
from vividc.ssa.rewrite.dead import remove_unused

_RETURN: Final = "return"
_NOWHERE: Final = -1
_FLOATS: Final = frozenset({"float", "double"})
_ELEMENTS: Final = {
    "float32": "float",
    "float64": "double",
    "complex64": "float",
    "complex128": "double",
    "bool": "i8",
    **{f"{sign}int{bits}": f"i{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}
_COPY = "return a copy: x.copy()"


@dataclass(frozen=True, slots=True)
class Held:
    """A function whose results are described, and the arrays that are still its own."""

    function: Function
    arrays: dict[str, OwnArray]


def hold_results(function: Function, arrays: dict[str, OwnArray]) -> Held:
    """Describe what the kernel returns; its form is the caller's to say.

    Parameters
    ----------
    arrays
        The kernel's own arrays, by name.

    Raises
    ------
    KernelError
        It returns a constant table, or elements as another type than they have.
    """
    if not any(is_returned(op) for block in function.blocks for op in block.instrs):
        return Held(function, arrays)
    return _Holder(function, arrays).run()


class _Holder:
    """One function's results."""

    def __init__(self, function: Function, arrays: dict[str, OwnArray]) -> None:
        self._function = function
        self._arrays = arrays
        self._ids = FreshIds(function)
        self._sites: dict[int, list[Instr]] = {}
        for block in function.blocks:
            for op in filter(is_returned, block.instrs):
                self._sites.setdefault(_leaf_of(op)[0], []).append(op)
        self._taken = {name.removeprefix("&") for name, _ in function.inputs} | set(arrays)
        self._made: dict[str, Param] = {}
        self._names: dict[str, str] = {}
        self._stores: dict[int, list[Instr]] = {}
        self._slots = 0
        self._words = ""

    def run(self) -> Held:
        self._words = first_free(self._taken, f"{_RETURN}.words")
        leaves = tuple(self._leaf(number) for number in sorted(self._sites))
        words = self._words if self._slots else ""
        if words:
            self._made[words] = Param(words, DType.I32, 1, flat=True, made=(self._slots,))
        blocks = tuple(
            replace(block, instrs=tuple(self._instrs(block.instrs)))
            for block in self._function.blocks
        )
        inputs = tuple(
            (f"&{self._names.get(key.removeprefix('&'), key.removeprefix('&'))}", kind)
            if key.startswith("&")
            else (key, kind)
            for key, kind in self._function.inputs
        )
        made = replace(
            self._function,
            blocks=blocks,
            inputs=inputs,
            params=tuple(self._made.values()),
            results=Results(leaves, words=words, made=tuple(self._made)),
        )
        own = {name: held for name, held in self._arrays.items() if name not in self._names}
        return Held(remove_unused(made), own)

    def _instrs(self, instrs: Sequence[Instr]) -> Iterator[Instr]:
        for op in instrs:
            if is_returned(op):
                yield from self._stores.get(op.id, ())
            elif op.array in self._names:
                yield replace(op, array=self._names[op.array])
            else:
                yield op

    def _leaf(self, number: int) -> Leaf:
        sites = self._sites[number]
        _, dtype = _leaf_of(sites[0])
        if not is_returned_array(sites[0]):
            return self._scalar(number, dtype, sites)
        arrays = tuple(dict.fromkeys(op.array for op in sites if op.array))
        for name in arrays:
            self._promote(name, number, dtype, sites[0])
        some = [op for op in sites if op.array]
        which: list[Value] = [Int(arrays.index(op.array) if op.array else _NOWHERE) for op in sites]
        numbers = [self._number(some, [op.operands[n] for op in some]) for n in _numbers(some)]
        ndim = len(numbers) // 2
        return Leaf(
            dtype,
            tuple(self._names.get(name, name) for name in arrays),
            self._number(sites, which),
            numbers[0] if numbers else (0,),
            tuple(numbers[1 : 1 + ndim]),
            tuple(numbers[1 + ndim :]),
        )

    def _promote(self, name: str, number: int, dtype: str, site: Instr) -> None:
        """Make an array of the kernel's own a parameter that the launch makes."""
        held = self._arrays.get(name)
        if held is None:
            return
        if held.array.contents is not None:
            raise KernelError("a constant array is returned", loc=site.loc, hint=_COPY)
        if held.element != _ELEMENTS.get(dtype):
            what = f"an array of {held.element} is returned as {dtype}"
            raise KernelError(what, loc=site.loc, hint=_COPY)
        if name in self._names:
            return
        self._names[name] = self._named(number)
        kind = DType.F32 if held.element in _FLOATS else DType.I32
        size = held.array.size or (held.array.words,)
        made = self._names[name]
        self._made[made] = Param(made, kind, 1, flat=True, made=size)

    def _named(self, number: int) -> str:
        stem = _RETURN if len(self._sites) == 1 else f"{_RETURN}{number}"
        name = first_free(self._taken, stem)
        self._taken.add(name)
        return name

    def _number(self, sites: Sequence[Instr], values: Sequence[Value]) -> Formula:
        """A number that the launch decides alike at all places, or else a word that each stores."""
        formulas = {exact_formula(self._function, value) for value in values}
        known = formulas.pop() if len(formulas) == 1 else None
        if known is not None:
            return known
        slot = self._slots
        self._slots += 1
        for op, value in zip(sites, values, strict=True):
            stores = self._stores.setdefault(op.id, [])
            stores += self._low(op, value, self._words, slot)
        return (f"s:{self._words}.{slot}",)

    def _scalar(self, number: int, dtype: str, sites: Sequence[Instr]) -> Leaf:
        """A scalar as an array of one element."""
        name = self._named(number)
        is_float = _ELEMENTS[dtype] in _FLOATS
        parts = 2 if dtype.startswith("complex") else 1
        words = parts * (2 if _ELEMENTS[dtype] in ("i64", "double") else 1)
        kind = DType.F32 if is_float else DType.I32
        self._made[name] = Param(name, kind, 1, flat=True, made=(words,))
        for op in sites:
            stores = self._stores.setdefault(op.id, [])
            if is_float:
                for part, value in enumerate(op.operands):
                    stores += self._real(op, value, name, _ELEMENTS[dtype], part * words // parts)
                continue
            stores += self._low(op, op.operands[0], name, 0, _ELEMENTS[dtype])
            if words > 1:
                stores += self._high(op, op.operands[0], name)
        return Leaf(dtype, (name,), is_scalar=True)

    def _real(self, op: Instr, value: Value, name: str, kind: str, slot: int) -> Iterator[Instr]:
        if kind == "double" and isinstance(value, Ref):
            word = Instr(self._ids(), "fptrunc", "float", (value,), source="double", loc=op.loc)
            yield word
            value = Ref(word.id)
        yield self._store("float", value, name, slot, op)

    def _low(
        self, op: Instr, value: Value, name: str, slot: int, kind: str = ""
    ) -> Iterator[Instr]:
        """A store of an integer's low word."""
        if not isinstance(value, Int):
            kind = kind or self._kind(value)
            if kind != "i32":
                how = "trunc" if kind == "i64" else "zext"
                word = Instr(self._ids(), how, "i32", (value,), source=kind, loc=op.loc)
                yield word
                value = Ref(word.id)
        else:
            value = Int(_signed(value.value))
        yield self._store("i32", value, name, slot, op)

    def _high(self, op: Instr, value: Value, name: str) -> Iterator[Instr]:
        if isinstance(value, Int):
            yield self._store("i32", Int(_signed(value.value >> 32)), name, 1, op)
            return
        shifted = Instr(self._ids(), "lshr", "i64", (value, Int(32)), loc=op.loc)
        word = Instr(self._ids(), "trunc", "i32", (Ref(shifted.id),), source="i64", loc=op.loc)
        yield from (shifted, word)
        yield self._store("i32", Ref(word.id), name, 1, op)

    def _kind(self, value: Value) -> str:
        if isinstance(value, Ref):
            return str(self._function.definitions[value.id].type)
        return dict(self._function.inputs)[value.key]  # type: ignore[union-attr]

    def _store(self, kind: str, value: Value, name: str, slot: int, op: Instr) -> Instr:
        return Instr(
            self._ids(),
            "store",
            kind,
            (value, Int(0)),
            array=name,
            shift=2,
            offset=WORD_BYTES * slot,
            loc=op.loc,
        )


def _leaf_of(op: Instr) -> tuple[int, str]:
    number, dtype = op.pred.removeprefix(RETURNED).removesuffix(RETURNED_ARRAY).split(" ")
    return int(number), dtype


def _numbers(sites: Sequence[Instr]) -> range:
    return range(len(sites[0].operands) if sites else 0)


def _signed(word: int) -> int:
    word &= 0xFFFFFFFF
    return word - (1 << 32) if word >> 31 else word

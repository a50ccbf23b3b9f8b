"""Arrays of a kernel's own: those it allocates, and the constant tables it reads.

They lie in the scratchpad beside the arguments, one word an element (C's as C lays them out). Here
what `numba.arrays` left in LLVM's IR becomes pointer parameters like those of arguments, so that
the stages behind know no difference; `as_words` and `in_words` turn accesses of smaller and larger
elements into words.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.advice import Advice
from vividc.frontend.llvm.calls import ALLOCATE, COPY
from vividc.frontend.memory.arrays.by_array import is_allocation
from vividc.frontend.memory.arrays.capacities import with_capacities
from vividc.frontend.memory.arrays.places import placed
from vividc.frontend.memory.pick import expand_picks
from vividc.frontend.memory.tables import PACKED_BYTES, Table, packed_words_of, tables_of, words_of
from vividc.frontend.ranges.launch_sizes import LaunchSizes
from vividc.lang.numba_words import plain
from vividc.machine.params import Formula, LocalArray, base_of
from vividc.ssa.edit import FreshIds, map_values, read_values
from vividc.ssa.flow import flow_of
from vividc.ssa.ir import Float, Function, Global, Input, Instr, Int, Key, Named, Ref, Value
from vividc.ssa.rewrite.dead import remove_unused

_ELEMENTS = {"float32": "float", "int32": "i32", "uint32": "i32", "bool": "i8"}
_ELEMENTS |= {"int64": "i64", "uint64": "i64", "float64": "double"}
_ELEMENTS |= {"complex64": "float", "complex128": "double"}
_ELEMENTS |= {"int8": "i8", "uint8": "i8", "int16": "i16", "uint16": "i16"}
_BYTES = {"i1": 1, "i8": 1, "i16": 2, "i32": 4, "float": 4, "i64": 8, "double": 8}
_COMPLEX = {"{float,float}": "float", "{double,double}": "double"}
_SPACED = frozenset({"i64", "double"})
_WORD_BYTES = 4
_SIGN = 0x80000000
RAW = "bytes of C's"
"""What an allocation of C's holds: its size is in bytes."""
_SIZE_HINT = (
    "a size may be computed from shapes and scalar parameters: allocate as much as can be needed, "
    "np.zeros(len(x), np.float32), and use a part of it, or write the loop over the elements"
)
_DTYPE_HINT = Advice(
    "give a type of integers or floats: np.zeros(16, np.float32), np.empty(16, np.int32)",
    c="access it as what it was declared: float or integers",
)


@dataclass(frozen=True, slots=True)
class OwnArray:
    """An array of the kernel's own and the LLVM type of its elements.

    `signed`: the words of a table of i64 are to be sign-extended. `packed`: the words hold what C's
    memory holds, byte for byte, and may be accessed by bytes and halves.
    """

    array: LocalArray
    element: str
    signed: bool = True
    packed: bool = False

    @property
    def is_spaced(self) -> bool:
        """Whether an element takes two words: one of 64 bits that the kernel writes."""
        return self.element in _SPACED and self.array.contents is None and not self.packed

    @property
    def is_wide(self) -> bool:
        """Whether both words of an element count; a float64 is one float32 and a gap."""
        return self.is_spaced and self.element == "i64"

    @property
    def element_bytes(self) -> int:
        """Bytes from one element to the next in LLVM's addresses."""
        return _BYTES[self.element]


@dataclass(frozen=True, slots=True)
class WithArrays:
    """A function whose own arrays are pointer parameters called "&" + name."""

    function: Function
    arrays: dict[str, OwnArray]


def own_arrays(function: Function, text: str, *, packed: bool = False) -> WithArrays:
    """Find the arrays of the kernel's own.

    Parameters
    ----------
    text
        The module that the function was read from: it has the tables' contents.
    packed
        Arrays are C's: allocations count bytes, and bytes and halves lie as in C's memory.

    Raises
    ------
    KernelError
        An allocation of variable size, of elements that are no words, or of arrays that too much
        code would choose from; a constant that does not fit a word.
    """
    function, tables = expand_picks(function, tables_of(text))
    function, needed = with_capacities(function)
    function, allocated = _hold_allocations(function, needed)
    function, constant = _hold_tables(function, tables, packed=packed)
    arrays = {held.array.name: held for held in (*allocated, *constant)}
    params = tuple((f"&{name}", "ptr") for name in arrays)
    return WithArrays(replace(function, inputs=(*function.inputs, *params)), arrays)


def _hold_allocations(
    function: Function, needed: dict[Key, Formula]
) -> tuple[Function, list[OwnArray]]:
    made = _allocations(function, needed)
    found = placed(function, {id_: held.array for id_, held in made.items()})
    return found.function, [replace(made[id_], array=array) for array, id_ in found.places]


def _allocations(function: Function, needed: dict[Key, Formula]) -> dict[int, OwnArray]:
    """What each allocation of the kernel makes; `needed`: elements of those made as needed."""
    made: dict[int, OwnArray] = {}
    sizes: LaunchSizes | None = None
    for block in function.blocks:
        for op in filter(is_allocation, block.instrs):
            formula = needed.get(op.id)
            if formula is None and not isinstance(op.operands[0], Int):
                sizes = sizes or LaunchSizes(function)
                formula = sizes.bound(op.operands[0], block.name)
            held = _allocated(function, op, formula, len(made))
            loops = flow_of(function).loops.items()
            heads = (function.by_name[head] for head, body in loops if block.name in body)
            around = tuple(head.branch.loc for head in heads if head.branch.loc is not None)
            made[op.id] = replace(held, array=replace(held.array, loops=around))
    return made


def _allocated(function: Function, op: Instr, formula: Formula | None, number: int) -> OwnArray:
    """The array of an allocation; `formula`: its size where that is not a constant."""
    dtype = op.pred.removeprefix(ALLOCATE)
    count = op.operands[0]
    if dtype == RAW and isinstance(count, Int):
        return OwnArray(LocalArray(f"local{number}", -(-count.value // 4)), "i8", packed=True)
    element = _copied_element(function, op) if dtype == COPY else _ELEMENTS.get(dtype)
    if element is None:
        raise KernelError(f"a local array of {plain(dtype)}", loc=op.loc, hint=_DTYPE_HINT)
    words = (2 if element in _SPACED else 1) * (2 if dtype.startswith("complex") else 1)
    line = "" if op.loc is None else f".line{op.loc.line}"
    name = f"local{number}{line}"
    if isinstance(count, Int) and formula is None:
        size = max(count.value, 0) // (_BYTES[element] if dtype == COPY else 1)
        return OwnArray(LocalArray(name, size * words), element)
    if formula is None:
        raise KernelError(
            "an array is made whose size is not known at launch", loc=op.loc, hint=_SIZE_HINT
        )
    if dtype == COPY:
        formula = (*formula, _BYTES[element], "//")
    return OwnArray(LocalArray(name, 0, size=(*formula, words, "*")), element)


def _copied_element(function: Function, copy: Instr) -> str | None:
    """Type of the elements of a temporary copy, or of the parts of complex ones."""
    for block in function.blocks:
        for op in block.instrs:
            element = _COMPLEX.get(op.source, op.source)
            if op.op == "getelementptr" and op.operands[0] == Ref(copy.id) and element in _BYTES:
                return element
    return None


def _hold_tables(
    function: Function, tables: dict[str, Table], *, packed: bool
) -> tuple[Function, list[OwnArray]]:
    """Constant tables that the function reads."""
    function = remove_unused(function)
    held: dict[str, OwnArray] = {}
    starts: dict[Global, Instr] = {}
    ids = FreshIds(function)

    def change(operand: Value) -> Value:
        if not isinstance(operand, Global) or operand.name not in held:
            return operand
        base = Input(f"&{held[operand.name].array.name}")
        if not operand.offset:
            return base
        at = (base, Int(operand.offset))
        place = Instr(ids(operand), "getelementptr", "ptr", at, source="i8", strides=(1,))
        return Ref(starts.setdefault(operand, place).id)

    for name, loc in _tables_read(function):
        if name in tables and name not in held:
            held[name] = _table(tables[name], f"table{len(held)}", loc, packed=packed)
    blocks = [map_values(block, change) for block in function.blocks]
    blocks[0] = replace(blocks[0], instrs=(*starts.values(), *blocks[0].instrs))
    return replace(function, blocks=tuple(blocks)), list(held.values())


def _table(table: Table, name: str, loc: SourceLoc | None, *, packed: bool) -> OwnArray:
    if packed and _BYTES[table.element] <= _WORD_BYTES:
        small = table.element in PACKED_BYTES
        words = packed_words_of(table) if small else words_of(table, loc)
        return OwnArray(LocalArray(name, len(words), words), table.element, packed=True)
    words = words_of(table, loc)
    signed = all(value < _SIGN for value in table.values)
    return OwnArray(LocalArray(name, len(words), words), table.element, signed)


def _tables_read(function: Function) -> Iterator[tuple[str, SourceLoc | None]]:
    for block in function.blocks:
        for op in block.instrs:
            yield from ((arg.name, op.loc) for arg in op.operands if isinstance(arg, Global))
        yield from ((use.name, None) for use in read_values(block) if isinstance(use, Global))


Terms = tuple[tuple[Value, int], ...]


def in_words(
    function: Function, terms: Terms, offset: int, held: OwnArray, loc: SourceLoc | None
) -> tuple[Terms, int]:
    """A byte address within LLVM's array as one within ours, whose elements are words.

    Raises
    ------
    KernelError
        The address may lie inside an element.
    """
    size = held.element_bytes
    if size == _WORD_BYTES or held.is_spaced:
        return terms, offset
    if size < _WORD_BYTES:  # numba's accesses are aligned, whatever the form of their terms
        spread = _WORD_BYTES // size
        return tuple((value, stride * spread) for value, stride in terms), offset * spread
    terms = tuple(_unscaled(function, value, stride) for value, stride in terms)
    if any(number % size for number in (offset, *(stride for _, stride in terms))):
        raise KernelError(f"the bytes of an array of {held.element}", loc=loc, hint=_DTYPE_HINT)
    scaled = tuple((value, stride // size * _WORD_BYTES) for value, stride in terms)
    return scaled, offset // size * _WORD_BYTES


def _unscaled(function: Function, value: Value, stride: int) -> tuple[Value, int]:
    """A term whose constant factors are all in its stride: LLVM prefers (i << 3) * 1 to i * 8."""
    definition = function.definitions.get(value.key) if isinstance(value, Named) else None
    if isinstance(definition, Instr) and definition.op in ("shl", "mul"):
        factor = definition.operands[1]
        if isinstance(factor, Int):
            by = 1 << factor.value if definition.op == "shl" else factor.value
            return _unscaled(function, definition.operands[0], stride * by)
    return value, stride


def as_words(
    op: Instr, held: OwnArray, ids: FreshIds
) -> tuple[tuple[Instr, ...], Instr, tuple[Instr, ...]]:
    """What comes before a load or store, the access of a word, and what comes after.

    Raises
    ------
    KernelError
        The access is of another size than the array's elements.
    """
    if _BYTES.get(str(op.type)) != held.element_bytes:
        raise KernelError(
            f"an access of type {op.type} to an array of {held.element}",
            loc=op.loc,
            hint="access whole elements",
        )
    if held.element_bytes == _WORD_BYTES:
        return (), op, ()
    wide = "float" if held.element == "double" else "i32"
    if op.op == "load":
        word = replace(op, id=ids(), type=wide)
        back = Instr(op.id, _from_word(held), op.type, (Ref(word.id),), source=wide, loc=op.loc)
        return (), word, (back,)
    if isinstance(op.operands[0], Float):
        _check_literal(op.operands[0], op.loc)
    if not isinstance(op.operands[0], Named):
        return (), replace(op, type=wide), ()
    convert = "fptrunc" if held.element == "double" else "zext"
    value = Instr(ids(), convert, wide, op.operands[:1], source=str(op.type), loc=op.loc)
    return (value,), replace(op, type=wide, operands=(Ref(value.id), op.operands[1])), ()


def _check_literal(literal: Float, loc: SourceLoc | None) -> None:
    """Elements of float64 are float32 words: what these cannot hold is refused."""
    with np.errstate(over="ignore", under="ignore"):
        word = float(np.float32(literal.value))
    if math.isfinite(literal.value) and (math.isinf(word) or (not word and literal.value)):
        raise KernelError(
            f"{literal.value!r} does not fit float32, and the array has no float64",
            loc=loc,
            hint="scale the values so that all stay between 1.2e-38 and 3.4e38",
        )


def wide_access(
    op: Instr, held: OwnArray, ids: FreshIds
) -> tuple[tuple[Instr, ...], tuple[Instr, ...]]:
    """A load or store of an element of two words: the accesses, low word first, behind what they
    store; for a load they come first, and then what joins them.

    Raises
    ------
    KernelError
        The access is of another size than the array's elements.
    """
    if op.type != "i64":
        raise KernelError(
            f"an access of type {op.type} to an array of {held.element}",
            loc=op.loc,
            hint="access whole elements",
        )
    half = replace(op, type="i32")
    if op.op == "load":
        low, high = replace(half, id=ids()), replace(half, id=ids())
        return (low, high), tuple(_joined(op, Ref(low.id), Ref(high.id), ids))
    value, pointer = op.operands
    words: tuple[Value, Value]
    if isinstance(value, Int):
        words = (Int(_signed_word(value.value)), Int(_signed_word(value.value >> 32)))
        split: tuple[Instr, ...] = ()
    else:
        cut = Instr(ids(), "trunc", "i32", (value,), source="i64", loc=op.loc)
        down = Instr(ids(), "lshr", "i64", (value, Int(32)), loc=op.loc)
        above = replace(cut, id=ids(), operands=(Ref(down.id),))
        split, words = (cut, down, above), (Ref(cut.id), Ref(above.id))
    return split, tuple(replace(half, id=ids(), operands=(word, pointer)) for word in words)


def _joined(op: Instr, low: Ref, high: Ref, ids: FreshIds) -> Iterator[Instr]:
    """The result of `op` from its two words."""
    below = Instr(ids(), "zext", "i64", (low,), source="i32", loc=op.loc)
    above = replace(below, id=ids(), operands=(high,))
    up = Instr(ids(), "shl", "i64", (Ref(above.id), Int(32)), loc=op.loc)
    yield from (below, above, up)
    yield Instr(op.id, "or", "i64", (Ref(up.id), Ref(below.id)), loc=op.loc)


def _signed_word(value: int) -> int:
    value &= 0xFFFFFFFF
    return value - ((value & _SIGN) << 1)


def _from_word(held: OwnArray) -> str:
    """The conversion of a table's or local array's word to its element."""
    if held.element == "double":
        return "fpext"
    if held.element != "i64":
        return "trunc"
    return "sext" if held.signed else "zext"


def keep_accessed(function: Function) -> Function:
    """The function with those of its own arrays that it accesses, or whose addresses those have."""
    accessed = {instr.array for block in function.blocks for instr in block.instrs if instr.array}
    bases = set(map(base_of, accessed))
    own = (one for one in function.locals if one.name in accessed or f"&{one.name}" in bases)
    return replace(function, locals=tuple(own))

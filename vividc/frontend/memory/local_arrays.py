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
from vividc.frontend.llvm.calls import ALLOCATE, COPY
from vividc.frontend.llvm.ir import (
    Float,
    Global,
    Int,
    Local,
    Op,
    Operand,
    WideFunction,
    WidePhi,
    flow_of,
    map_operands,
    remove_dead,
    substitute,
    uses,
)
from vividc.frontend.memory.pick import expand_picks
from vividc.frontend.memory.tables import PACKED_BYTES, Table, packed_words_of, tables_of, words_of
from vividc.frontend.ranges.interval import Interval
from vividc.frontend.ranges.launch_sizes import LaunchSizes
from vividc.lang.numba_words import plain
from vividc.machine.params import Formula, LocalArray
from vividc.ssa.ir import Function

_ELEMENTS = {"float32": "float", "int32": "i32", "uint32": "i32", "bool": "i8"}
_ELEMENTS |= {"int64": "i64", "uint64": "i64", "float64": "double"}
_ELEMENTS |= {"int8": "i8", "uint8": "i8", "int16": "i16", "uint16": "i16"}
_BYTES = {"i1": 1, "i8": 1, "i16": 2, "i32": 4, "float": 4, "i64": 8, "double": 8}
_SPACED = frozenset({"i64", "double"})
_WORD_BYTES = 4
_SIGN = 0x80000000
RAW = "bytes of C's"
"""What an allocation of C's holds: its size is in bytes."""
_SIZE_HINT = (
    "a size may be computed from shapes and scalar parameters: allocate as much as can be needed, "
    "np.zeros(len(x), np.float32), and use a part of it, or write the loop over the elements"
)
_DTYPE_HINT = "give a type of integers or floats: np.zeros(16, np.float32), np.empty(16, np.int32)"


@dataclass(frozen=True, slots=True)
class Held:
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
class Holding:
    """A function whose own arrays are pointer parameters called "&" + name."""

    function: WideFunction
    arrays: dict[str, Held]


def hold_arrays(function: WideFunction, text: str, *, packed: bool = False) -> Holding:
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
        An allocation of variable size, of elements that are no words, or of an array that outlives
        the iteration that made it; a constant that does not fit a word.
    """
    function, tables = expand_picks(function, tables_of(text))
    function, allocated = _hold_allocations(function)
    function, constant = _hold_tables(function, tables, packed=packed)
    arrays = {held.array.name: held for held in (*allocated, *constant)}
    params = tuple((f"&{name}", "ptr") for name in arrays)
    return Holding(replace(function, params=(*function.params, *params)), arrays)


def _hold_allocations(function: WideFunction) -> tuple[WideFunction, list[Held]]:
    held: list[Held] = []
    known: dict[str, Operand] = {}
    sizes: LaunchSizes | None = None
    loops = flow_of(function).loops if _allocates(function) else {}
    for block in function.blocks:
        for op in block.ops:
            if _is_allocation(op):
                _refuse_kept(function, block.name, op)
                formula: Formula | None = None
                if not isinstance(op.args[0], Int):
                    sizes = sizes or LaunchSizes(function)
                    formula = sizes.bound(op.args[0], block.name)
                made = _allocated(function, op, formula, len(held))
                heads = (function.by_name[h] for h, body in loops.items() if block.name in body)
                around = tuple(h.exit.loc for h in heads if h.exit.loc is not None)
                held.append(replace(made, array=replace(made.array, loops=around)))
                known[op.name] = Local(f"&{held[-1].array.name}")
    if not held:
        return function, held
    blocks = tuple(
        replace(block, ops=tuple(op for op in block.ops if not _is_allocation(op)))
        for block in function.blocks
    )
    return substitute(replace(function, blocks=blocks), known), held


def _allocates(function: WideFunction) -> bool:
    return any(_is_allocation(op) for block in function.blocks for op in block.ops)


def _is_allocation(op: Op) -> bool:
    return op.op == "call" and op.pred.startswith(ALLOCATE)


def _allocated(function: WideFunction, op: Op, formula: Formula | None, number: int) -> Held:
    """The array of an allocation; `formula`: its size where that is not a constant."""
    dtype = op.pred.removeprefix(ALLOCATE)
    count = op.args[0]
    if dtype == RAW and isinstance(count, Int):
        return Held(LocalArray(f"local{number}", -(-count.value // 4)), "i8", packed=True)
    element = _copied_element(function, op) if dtype == COPY else _ELEMENTS.get(dtype)
    if element is None:
        raise KernelError(f"a local array of {plain(dtype)}", loc=op.loc, hint=_DTYPE_HINT)
    words = 2 if element in _SPACED else 1
    line = "" if op.loc is None else f".line{op.loc.line}"
    name = f"local{number}{line}"
    if isinstance(count, Int):
        size = max(count.value, 0) // (_BYTES[element] if dtype == COPY else 1)
        return Held(LocalArray(name, size * words), element)
    if formula is None:
        raise KernelError(
            "an array is made whose size is not known at launch", loc=op.loc, hint=_SIZE_HINT
        )
    if dtype == COPY:
        formula = (*formula, _BYTES[element], "//")
    return Held(LocalArray(name, 0, size=(*formula, words, "*")), element)


def _copied_element(function: WideFunction, copy: Op) -> str | None:
    """Type of the elements of a temporary copy."""
    for block in function.blocks:
        for op in block.ops:
            if op.op == "getelementptr" and op.args[0] == Local(copy.name) and op.source in _BYTES:
                return op.source
    return None


def _refuse_kept(function: WideFunction, home: str, op: Op) -> None:
    """Each iteration's array has the same place, so none may be read in the next iteration."""
    aliases = {op.name}
    pointers = [d for d in function.definitions.values() if d.type == "ptr"]
    grown = True
    while grown:
        grown = False
        for definition in pointers:
            if definition.name not in aliases and aliases & _pointers_of(definition):
                aliases.add(definition.name)
                grown = True
    for header, body in flow_of(function).loops.items():
        if home in body and any(phi.name in aliases for phi in function.by_name[header].phis):
            raise KernelError(
                "an array made in a loop is kept for the next iteration",
                loc=op.loc,
                hint="make both arrays before the loop, and copy elements",
            )


def _pointers_of(definition: Op | WidePhi) -> set[str]:
    operands: tuple[Operand, ...] = (
        tuple(value for _, value in definition.incoming)
        if isinstance(definition, WidePhi)
        else definition.args
    )
    return {operand.name for operand in operands if isinstance(operand, Local)}


def _hold_tables(
    function: WideFunction, tables: dict[str, Table], *, packed: bool
) -> tuple[WideFunction, list[Held]]:
    """Constant tables that the function reads."""
    function = remove_dead(function)
    held: dict[str, Held] = {}
    starts: dict[str, Op] = {}

    def change(operand: Operand) -> Operand:
        if not isinstance(operand, Global) or operand.name not in held:
            return operand
        base = f"&{held[operand.name].array.name}"
        if not operand.offset:
            return Local(base)
        name = f"{base}+{operand.offset}"
        starts[name] = Op(
            name, "getelementptr", "ptr", (Local(base), Int(operand.offset)), "", "i8", strides=(1,)
        )
        return Local(name)

    for name, loc in _tables_read(function):
        if name in tables and name not in held:
            held[name] = _table(tables[name], f"table{len(held)}", loc, packed=packed)
    blocks = [map_operands(block, change) for block in function.blocks]
    blocks[0] = replace(blocks[0], ops=(*starts.values(), *blocks[0].ops))
    return replace(function, blocks=tuple(blocks)), list(held.values())


def _table(table: Table, name: str, loc: SourceLoc | None, *, packed: bool) -> Held:
    if packed and _BYTES[table.element] <= _WORD_BYTES:
        small = table.element in PACKED_BYTES
        words = packed_words_of(table) if small else words_of(table, loc)
        return Held(LocalArray(name, len(words), words), table.element, packed=True)
    words = words_of(table, loc)
    signed = all(value < _SIGN for value in table.values)
    return Held(LocalArray(name, len(words), words), table.element, signed)


def _tables_read(function: WideFunction) -> Iterator[tuple[str, SourceLoc | None]]:
    for block in function.blocks:
        for op in block.ops:
            yield from ((arg.name, op.loc) for arg in op.args if isinstance(arg, Global))
        yield from ((use.name, None) for use in uses(block) if isinstance(use, Global))


Terms = tuple[tuple[Operand, int], ...]


def in_words(
    function: WideFunction, terms: Terms, offset: int, held: Held, loc: SourceLoc | None
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


def _unscaled(function: WideFunction, value: Operand, stride: int) -> tuple[Operand, int]:
    """A term whose constant factors are all in its stride: LLVM prefers (i << 3) * 1 to i * 8."""
    definition = function.definitions.get(value.name) if isinstance(value, Local) else None
    if isinstance(definition, Op) and definition.op in ("shl", "mul"):
        factor = definition.args[1]
        if isinstance(factor, Int):
            by = 1 << factor.value if definition.op == "shl" else factor.value
            return _unscaled(function, definition.args[0], stride * by)
    return value, stride


def as_words(op: Op, held: Held, number: int) -> tuple[tuple[Op, ...], Op, tuple[Op, ...]]:
    """What comes before a load or store, the access of a word, and what comes after.

    `number` is the access's own.

    Raises
    ------
    KernelError
        The access is of another size than the array's elements.
    """
    if _BYTES.get(op.type) != held.element_bytes:
        raise KernelError(
            f"an access of type {op.type} to an array of {held.element}",
            loc=op.loc,
            hint="access whole elements",
        )
    if held.element_bytes == _WORD_BYTES:
        return (), op, ()
    wide = "float" if held.element == "double" else "i32"
    if op.op == "load":
        word = Local(f"{op.name}.word")
        back = Op(op.name, _from_word(held), op.type, (word,), source=wide, loc=op.loc)
        return (), replace(op, name=word.name, type=wide), (back,)
    if isinstance(op.args[0], Float):
        _check_literal(op.args[0], op.loc)
    if not isinstance(op.args[0], Local):
        return (), replace(op, type=wide), ()
    value = Local(f"{op.args[0].name}.stored{number}")
    convert = "fptrunc" if held.element == "double" else "zext"
    before = Op(value.name, convert, wide, (op.args[0],), source=op.type, loc=op.loc)
    return (before,), replace(op, type=wide, args=(value, op.args[1])), ()


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


def wide_access(op: Op, held: Held, number: int) -> tuple[tuple[Op, ...], tuple[Op, ...]]:
    """A load or store of an element of two words: the accesses, low word first, behind what they
    store; for a load they come first, and then what joins them. `number` is the access's own.

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
        low, high = f"{op.name}.low", f"{op.name}.high"
        joined = (
            Op(f"{low}64", "zext", "i64", (Local(low),), source="i32", loc=op.loc),
            Op(f"{high}64", "zext", "i64", (Local(high),), source="i32", loc=op.loc),
            Op(f"{high}.up", "shl", "i64", (Local(f"{high}64"), Int(32)), loc=op.loc),
            Op(op.name, "or", "i64", (Local(f"{high}.up"), Local(f"{low}64")), loc=op.loc),
        )
        return (replace(half, name=low), replace(half, name=high)), joined
    value, pointer = op.args
    if isinstance(value, Int):
        words = (Int(_signed_word(value.value)), Int(_signed_word(value.value >> 32)))
        return (), tuple(replace(half, args=(word, pointer)) for word in words)
    assert isinstance(value, Local)
    low, high = (f"{value.name}.{part}{number}" for part in ("low", "high"))
    split = (
        Op(low, "trunc", "i32", (value,), source="i64", loc=op.loc),
        Op(f"{high}.down", "lshr", "i64", (value, Int(32)), loc=op.loc),
        Op(high, "trunc", "i32", (Local(f"{high}.down"),), source="i64", loc=op.loc),
    )
    return split, tuple(replace(half, args=(Local(word), pointer)) for word in (low, high))


def _signed_word(value: int) -> int:
    value &= 0xFFFFFFFF
    return value - ((value & _SIGN) << 1)


def _from_word(held: Held) -> str:
    """The conversion of a table's or local array's word to its element."""
    if held.element == "double":
        return "fpext"
    if held.element != "i64":
        return "trunc"
    return "sext" if held.signed else "zext"


def bounds_of_loads(function: WideFunction, arrays: dict[str, Held]) -> dict[str, Interval]:
    """Values that the integers read from constant tables can have, by name of the load."""
    found: dict[str, Interval] = {}
    for block in function.blocks:
        for op in block.ops:
            held = arrays.get(op.array) if op.op == "load" and op.type == "i32" else None
            if held is not None and held.array.contents and op.width == _WORD_BYTES:
                values = [w - ((w & _SIGN) << 1) for w in held.array.contents]
                found[op.name] = (min(values), max(values))
    return found


def with_locals(function: Function, arrays: dict[str, Held]) -> Function:
    """The function with a table of its own arrays, as far as it accesses them."""
    accessed = {instr.array for block in function.blocks for instr in block.instrs}
    own = tuple(held.array for name, held in arrays.items() if name in accessed)
    return replace(function, locals=own)

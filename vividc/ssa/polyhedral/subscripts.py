"""Accesses, the places that they touch, and their subscripts, recovered from flat indices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from vividc.host.once import once_within
from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.words import WORD_BYTES
from vividc.ssa.analysis.order import Order
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials, constant
from vividc.ssa.ir import Function, Input, Instr, Phi, Ref, Value, is_pitch, pitch_of
from vividc.ssa.polyhedral.forms import Form


@dataclass(frozen=True)
class Access:
    """A load or store: the element of `array` with these subscripts."""

    instr: Instr
    array: str
    subscripts: tuple[Form, ...]

    @property
    def is_store(self) -> bool:
        """Whether it writes."""
        return self.instr.op is Opcode.STORE


@dataclass(frozen=True)
class Place:
    """A scalar (by the id of its value) or an element of an array (by name)."""

    owner: str | int
    subscripts: tuple[Form, ...]

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.owner, self.subscripts))

    @cached_property
    def is_scalar(self) -> bool:
        """Whether it has no place in memory."""
        return isinstance(self.owner, int)

    @cached_property
    def names(self) -> frozenset[str]:
        """What its subscripts are made of."""
        return frozenset(name for form in self.subscripts for name in form.names)

    def at(self, forms: Mapping[str, Form]) -> Place:
        """The place with forms in place of names."""
        return Place(self.owner, tuple(one.substituted(forms) for one in self.subscripts))


def element_bytes(instr: Instr) -> int:
    """Bytes from one element to the next, as subscripts of an access count them: its index may
    count bytes, where LLVM has folded the constant rows of an array of known sizes.
    """
    return max(1 << instr.shift, instr.width)


@dataclass
class Subscripts:
    """Subscripts of the accesses of `function`, as polynomials of its values."""

    function: Function
    _known: Polynomials = field(init=False)
    _mixed: set[Value] = field(init=False)

    def __post_init__(self) -> None:
        """Finds what is computed from pitches."""
        self._known = Polynomials(self.function, pitches=True)
        self._mixed = _from_pitches(self.function)

    def polynomial(self, value: Value) -> Polynomial:
        """Of any value; pitches are values of their own."""
        return self._known.of(value)

    def of(self, access: Instr) -> tuple[Polynomial, ...] | None:
        """One for each dimension if it is an element of a parameter by as many subscripts, which
        are in their bounds then; one, the index, of any other access. None: neither is known.
        """
        index = self._known.of(access.operands[1])
        found = [value for monomial in index.terms for value in monomial]
        if any(value in self._mixed for value in found):
            return None
        pitched = any(is_pitch(value) for value in found)
        axes = self._axes(access.array)
        if axes == 1 or not (pitched or access.subscript):
            return None if pitched else (index,)
        steps = [
            frozenset[Value](pitch_of(access.array, m) for m in range(n + 1, axes))
            for n in range(axes)
        ]
        parts: list[dict[tuple[Value, ...], int]] = [{} for _ in steps]
        for monomial, factor in index.terms.items():
            pitches = [value for value in monomial if is_pitch(value)]
            if len(set(pitches)) < len(pitches) or frozenset(pitches) not in steps:
                return None
            rest = tuple(value for value in monomial if value not in pitches)
            parts[steps.index(frozenset(pitches))][rest] = factor
        return tuple(Polynomial(part) for part in parts)

    def _axes(self, array: str) -> int:
        param = next((p for p in self.function.params if p.name == array), None)
        return 1 if param is None else param.ndim


class FlatRows:
    """Elements of matrices, and of arrays that a kernel makes, whose flat indices prove to be of
    rows, as numpy's own loops and products address them.

    Attributes
    ----------
    lengths
        Of the rows of each array that the kernel makes, as far as they were found.
    """

    def __init__(self, function: Function, order: Order) -> None:
        self.lengths: dict[str, Input] = {}
        self._seen: dict[str, tuple[Input, ...]] = {}
        self._function, self._order = function, order
        self._known: dict[str, Input | None] = {
            param.name: Input(f"{param.name}.shape1")
            for param in function.params
            if param.ndim == 2 and not param.flat  # noqa: PLR2004 - rows, columns
        }
        self._deep = {
            param.name: tuple(Input(f"{param.name}.shape{axis}") for axis in range(param.ndim))
            for param in function.params
            if param.ndim > 2 and not param.flat  # noqa: PLR2004 - rows, columns
        }
        self._known |= {one.name: None for one in function.locals if one.contents is None}
        self._known |= {param.name: None for param in function.params if param.made}

    def taken_apart(
        self,
        access: Instr,
        index: Polynomial,
        is_in_row: Callable[[Polynomial, Input, Instr], bool],
    ) -> tuple[Polynomial, ...] | None:
        """Row and column, or as many subscripts as an array of more dimensions has, to the last of
        which the access adds its offset; None: they are not known, or are by rows of another length
        elsewhere.
        """
        name, unit = access.array, constant(element_bytes(access) >> access.shift)
        behind = constant(access.offset // element_bytes(access))
        parts = self.deep(access, index)
        if parts:
            *inner, (column, length) = parts[1:]
            ends = (*inner, (column.plus(behind), length))
            is_known = all(is_in_row(part, length, access) for part, length in ends)
            return tuple(part.times(unit) for part, _ in parts) if is_known else None
        for row, column, length in self.candidates(access, index):
            if is_in_row(column.plus(behind), length, access):
                if self._known[name] is None and self.lengths.setdefault(name, length) != length:
                    return None
                return row.times(unit), column.times(unit)
        return None

    def deep(self, access: Instr, index: Polynomial) -> tuple[tuple[Polynomial, Input], ...]:
        """What the index of an access may be made of if the array has more dimensions than two: a
        subscript by each, and the dimension.
        """
        unit, lengths = element_bytes(access) >> access.shift, self._deep.get(access.array, ())
        if not lengths or any(factor % unit for factor in index.terms.values()):
            return ()
        found, rest = [], index.divided(unit)
        for length in reversed(lengths[1:]):
            rest, part = _split(rest, length)
            found.append((part, length))
        return ((rest, lengths[0]), *reversed(found))

    def candidates(
        self, access: Instr, index: Polynomial
    ) -> Iterator[tuple[Polynomial, Polynomial, Input]]:
        """Yield what the index of an access may be made of: row, column, and the rows' length."""
        unit = element_bytes(access) >> access.shift
        if access.array not in self._known:
            return
        known = self._known[access.array]
        likely = self._lengths_of(access.array) if known is None else (known,)
        found = [*_rows_of(index, unit)]
        if known is None:
            found.sort(key=lambda parts: [*likely, parts[2]].index(parts[2]))
        for row, column, length in found:
            if known in (length, None) or self._is_same(known, length, access):
                yield row, column, length
        if any(factor % unit for factor in index.terms.values()):
            return
        for length in likely:
            if not any(length in monomial for monomial in index.terms):
                yield constant(0), index.divided(unit), length

    def _lengths_of(self, array: str) -> tuple[Input, ...]:
        """What rows of an array may be long by its accesses, by most of them first: those to its
        first row say nothing.
        """
        if array not in self._seen:
            polynomials = subscripts_of(self._function)
            counts: dict[Input, int] = {}
            for one in (one for block in self._function.blocks for one in block.instrs):
                if one.op in MEMORY and one.array == array:
                    index = polynomials.polynomial(one.operands[1])
                    for _, _, length in _rows_of(index, element_bytes(one) >> one.shift):
                        counts[length] = counts.get(length, 0) + 1
            self._seen[array] = tuple(sorted(counts, key=lambda length: -counts[length]))
        return self._seen[array]

    def _is_same(self, known: Input | None, length: Input, access: Instr) -> bool:
        """Whether rows prove to be as long as they are known to be."""
        facts = self._order.facts(self._function.block_of[access.id])
        sums = [self._order.sum_of(one) for one in (known, length) if one is not None]
        return self._order.equal(sums[0], sums[-1], facts) == ()


def _rows_of(index: Polynomial, unit: int) -> Iterator[tuple[Polynomial, Polynomial, Input]]:
    """Yield what an index may be made of: row, column, and the length of rows, an input.

    `unit`: how much the index counts from one element to the next.
    """
    if any(factor % unit for factor in index.terms.values()):
        return
    lengths = {v: None for monomial in index.terms if len(monomial) > 1 for v in monomial}
    for length in lengths:
        if isinstance(length, Input):
            row, column = _split(index.divided(unit), length)
            yield row, column, length


def _split(index: Polynomial, length: Input) -> tuple[Polynomial, Polynomial]:
    """What an index has of a length, and the rest."""
    row: dict[tuple[Value, ...], int] = {}
    column: dict[tuple[Value, ...], int] = {}
    for monomial, factor in index.terms.items():
        rest = list(monomial)
        if length in rest:
            rest.remove(length)
            row[tuple(rest)] = factor
        else:
            column[monomial] = factor
    return Polynomial(row), Polynomial(column)


class Elements:
    """What arrays are made of, of one size and one type in all accesses; those of less than a word
    are integers that all loads extend in one way.

    Attributes
    ----------
    types
        Of the elements of each array.
    narrow
        A load of each array whose elements are less than a word, if there is one.
    """

    def __init__(self, function: Function) -> None:
        self.types: dict[str, Type] = {}
        self.narrow: dict[str, Instr] = {}
        self._widths: dict[str, int] = {}
        self._dtypes = {param.name: param.dtype for param in function.params}
        self._kinds = {item.id: item.type for block in function.blocks for item in block.items}
        every = [one for block in function.blocks for one in block.instrs]
        self._loaded = {one.array: one.type for one in every if one.op is Opcode.LOAD}

    def fault(self, access: Instr) -> str | None:
        """Why an access does not fit those before it; None: it does."""
        array, is_narrow = access.array, access.width != WORD_BYTES
        if self._widths.setdefault(array, access.width) != access.width:
            return f"elements of {array} are not of one size"
        if is_narrow and access.op is Opcode.LOAD:
            other = self.narrow.setdefault(array, access)
            if other.signed != access.signed:
                return f"elements of {array} have a sign in some loads only"
        kind = access.type
        if access.op is Opcode.STORE:
            value = access.operands[2]
            kind = self._kinds.get(value.id, Type.ANY) if isinstance(value, Ref) else Type.ANY
            dtype = self._dtypes.get(array)
            if kind is Type.ANY and dtype is not None:
                kind = Type.F32 if dtype.is_float else Type.I32
            elif kind is Type.ANY:
                kind = self._loaded.get(array, kind)
        if is_narrow and kind is not Type.I32:
            return f"elements of {array} are less than a word, and no integers"
        if kind not in (Type.F32, Type.I32) or self.types.setdefault(array, kind) != kind:
            return f"elements of {array} are not of one type"
        return None


@once_within
def subscripts_of(function: Function) -> Subscripts:
    """Those of a function, found once for it."""
    return Subscripts(function)


def may_be_spaced(function: Function) -> tuple[str, ...]:
    """Matrices whose elements are all accessed by two subscripts, so that their rows may lie
    further apart than they are long; no address is compared with what it is without that. None has
    elements of more than a word.
    """
    found = {
        param.name: None
        for param in function.params
        if param.ndim == 2 and not param.flat and not param.known  # noqa: PLR2004 - rows, columns
        if param.dtype.size_bytes <= WORD_BYTES
    }
    for item in (item for block in function.blocks for item in block.items):
        if isinstance(item, Phi):
            reads = tuple(value for _, value in item.incoming)
        else:
            reads = item.operands[_is_spaceable(function, item) :]
        touched = {value.key for value in reads if isinstance(value, Input)}
        for name in [name for name in found if f"&{name}" in touched]:
            del found[name]
    return tuple(name for name in found if not _is_compared(function, pitch_of(name, 1)))


def _is_compared(function: Function, pitch: Value) -> bool:
    """Whether a number computed from a pitch decides something."""
    derived = _from(function, lambda value: value == pitch)
    return any(
        item.type is Type.PRED and (pitch in item.operands or not derived.isdisjoint(item.operands))
        for block in function.blocks
        for item in block.items
        if isinstance(item, Instr) and item.op not in MEMORY
    )


def _is_spaceable(function: Function, access: Instr) -> bool:
    """Whether it is an access by two subscripts of a matrix: by its pitch, or in its first row."""
    parts = subscripts_of(function).of(access) if access.op in MEMORY else None
    if parts is None or access.operands[0] != Input(f"&{access.array}"):
        return False
    in_first_row = not parts[0].terms and access.subscript[:1] == (0,)
    length = Input(f"{access.array}.shape1")
    values = {value for part in parts for monomial in part.terms for value in monomial}
    return len(parts) > 1 and (bool(parts[0].terms) or in_first_row) and length not in values


def _from_pitches(function: Function) -> set[Value]:
    """Values computed from pitches; not what is loaded where they lead."""
    return _from(function, is_pitch)


def _from(function: Function, is_first: Callable[[Value], bool]) -> set[Value]:
    """Values computed from the first ones; not what is loaded where they lead."""
    reads: dict[Value, list[Value]] = {}
    for block in function.blocks:
        for item in block.items:
            operands = (
                tuple(value for _, value in item.incoming)
                if isinstance(item, Phi)
                else ()
                if item.op in MEMORY
                else item.operands
            )
            for value in operands:
                reads.setdefault(value, []).append(Ref(item.id))
    found: set[Value] = set()
    work = [value for value in reads if is_first(value)]
    while work:
        for reader in reads.get(work.pop(), ()):
            if reader not in found:
                found.add(reader)
                work.append(reader)
    return found

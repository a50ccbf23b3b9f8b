"""Turn pointers into array accesses: an array, an index, a shift and an offset for every load and
store.

After this stage no pointer is left. Pointer phis and selects within one array become phis and
selects of byte offsets.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.advice import Advice
from vividc.frontend.memory.arrays.by_array import apart, choices_of, merges, mixed_choices, related
from vividc.frontend.memory.arrays.local_arrays import OwnArray, as_words, in_words, wide_access
from vividc.frontend.memory.arrays.places import is_returned_array
from vividc.frontend.memory.pointer_math import compare_pointers, differences, without_freezes
from vividc.frontend.memory.unmerge import split_merged_loads
from vividc.host import time_limit
from vividc.ssa.edit import FreshIds
from vividc.ssa.ir import Block, Function, Global, Instr, Int, Key, Named, Phi, Ref, Value
from vividc.ssa.rewrite.dead import remove_unused

_BYTES = {"float": 4, "i32": 4, "i16": 2, "i8": 1}
_LOCAL_HINT = Advice(
    "use scalar variables, or an array of constant size: np.zeros(16, np.float32)",
    c="use scalar variables, or an array of constant size: float t[16]",
)
_GLOBAL_HINT = Advice(
    "pass it as a parameter: constants are numbers, tuples of them, and arrays",
    c="pass it as a parameter, or make it const with its values",
)


@dataclass(frozen=True, slots=True)
class _Address:
    """Byte address: base of `array` + sum of value * stride + offset."""

    array: str
    terms: tuple[tuple[Value, int], ...] = ()
    offset: int = 0


def resolve_memory(function: Function, own: dict[str, OwnArray] | None = None) -> Function:
    """Give every load and store its array, and drop all pointers; `own`: the kernel's own arrays.

    Raises
    ------
    KernelError
        A pointer does not come from an array parameter.
    """
    function = remove_unused(split_merged_loads(without_freezes(function)))
    mixed = mixed_choices(function)
    told = apart(function, related(function, mixed)) if mixed else function
    if told is None:
        raise KernelError(
            "one access to different arrays, chosen by a condition",
            loc=mixed[0].loc,
            hint="write an `if` with an access in each branch",
        )
    return _Resolver(remove_unused(told), own or {}).run()


class _Resolver:
    """One function's pointers, resolved on demand."""

    def __init__(self, function: Function, own: dict[str, OwnArray]) -> None:
        self._function = function
        self._own = own
        self._definitions = function.definitions
        self._arrays: dict[Key, str] = {}
        self._ids = FreshIds(function)
        for name, type_ in function.inputs:
            if type_ == "ptr":
                self._arrays[name] = name.removeprefix("&")
        self._find_arrays_of_merges()
        self._differences = differences(function, self._root)

    def run(self) -> Function:
        blocks = tuple(self._block(block) for block in self._function.blocks)
        return replace(self._function, blocks=blocks)

    def _find_arrays_of_merges(self) -> None:
        """Arrays of pointer phis and selects: a fixpoint, since phis may depend on each other."""
        found = list(merges(self._function))
        changed = True
        while changed:
            changed = False
            for merge in found:
                roots = [self._root(pointer) for pointer in choices_of(merge)]
                known = next((root for root in roots if root), "")
                if known and merge.id not in self._arrays:
                    self._arrays[merge.id] = known
                    changed = True

    def _root(self, pointer: Value) -> str:
        while isinstance(pointer, Named) and pointer.key not in self._arrays:
            definition = self._definitions.get(pointer.key)
            if not isinstance(definition, Instr) or definition.op != "getelementptr":
                return ""
            pointer = definition.operands[0]
        return self._arrays[pointer.key] if isinstance(pointer, Named) else ""

    def _block(self, block: Block) -> Block:
        time_limit.step("it was lowered")
        ops = tuple(new for op in block.instrs for new in self._rewrite(op))
        return replace(block, phis=tuple(self._phi(phi) for phi in block.phis), instrs=ops)

    def _phi(self, phi: Phi) -> Phi:
        if phi.type != "ptr":
            return phi
        incoming = tuple((pred, self._bytes(value, phi.loc)) for pred, value in phi.incoming)
        return Phi(self._bytes_of(phi.id).id, "i32", incoming, phi.loc)

    def _rewrite(self, op: Instr) -> Iterator[Instr]:
        if op.op == "load":
            yield from self._access(op, op.operands[0])
        elif op.op == "store":
            yield from self._access(op, op.operands[1])
        elif op.op == "getelementptr":
            yield from self._gep_bytes(op)
        elif op.op == "select" and op.type == "ptr":
            chosen = tuple(self._bytes(pointer, op.loc) for pointer in op.operands[1:])
            yield replace(
                op, id=self._bytes_of(op.id).id, type="i32", operands=(op.operands[0], *chosen)
            )
        elif op.op == "alloca":
            raise KernelError("a local array or tuple", loc=op.loc, hint=_LOCAL_HINT)
        elif is_returned_array(op):
            yield self._returned(op)
        elif op.op == "icmp" and op.type == "ptr":
            yield compare_pointers(op, self._root, lambda p: self._bytes(p, op.loc))
        elif op.id in self._differences:
            yield self._as_offset(op)
        elif op.op in ("ptrtoint", "ptrtoaddr", "inttoptr"):
            raise KernelError("arithmetic on addresses", loc=op.loc, hint="use indices")
        else:
            yield op

    def _returned(self, op: Instr) -> Instr:
        """A returned array: which it is, and at which byte it begins."""
        root = self._root(op.operands[0])
        at = self._bytes(op.operands[0], op.loc) if root else Int(0)
        return replace(op, array=root, operands=(at, *op.operands[1:]))

    def _access(self, op: Instr, pointer: Value) -> Iterator[Instr]:
        address = self._address(pointer, op.loc)
        held = self._own.get(address.array)
        if held is None or held.packed:
            yield from self._word_access(op, address)
            return
        terms, offset = in_words(self._function, address.terms, address.offset, held, op.loc)
        if held.is_wide:
            yield from self._wide_access(op, _Address(address.array, terms, offset), held)
            return
        before, access, after = as_words(op, held, self._ids)
        yield from before
        yield from self._word_access(access, _Address(address.array, terms, offset))
        yield from after

    def _wide_access(self, op: Instr, address: _Address, held: OwnArray) -> Iterator[Instr]:
        first, second = wide_access(op, held, self._ids)
        for new in (*first, *second):
            if new.op not in ("load", "store"):
                yield new
                continue
            is_high = new is (first if op.op == "load" else second)[1]
            place = replace(address, offset=address.offset + _BYTES["i32"] * is_high)
            yield from self._word_access(new, place)

    def _word_access(self, op: Instr, address: _Address) -> Iterator[Instr]:
        if op.type not in _BYTES:
            raise KernelError(
                f"an array access of type {op.type}",
                loc=op.loc,
                hint=Advice(
                    "arrays hold float32, bool, or integers of 8, 16 or 32 bits",
                    c="arrays hold float, bool, or integers of 8, 16 or 32 bits",
                ),
            )
        index: Value = Int(0)
        shift = _BYTES[str(op.type)].bit_length() - 1
        if address.terms:
            unit = min(stride & -stride for _, stride in address.terms)
            shift = unit.bit_length() - 1
            computed, index = _sum(self._ids, address.terms, unit, op.loc)
            yield from computed
        yield replace(
            op,
            operands=(*op.operands[:-1], index),
            array=address.array,
            shift=shift,
            offset=address.offset,
            width=_BYTES[str(op.type)],
        )

    def _gep_bytes(self, op: Instr) -> Iterator[Instr]:
        """The byte offset as a value, for phis and selects of pointers; dead otherwise."""
        if not op.strides or not self._root(Ref(op.id)):
            return
        address = self._address(Ref(op.id), op.loc)
        terms = (*address.terms, (Int(address.offset), 1))
        computed, total = _sum(self._ids, terms, 1, op.loc)
        result = self._bytes_of(op.id).id
        if computed:
            yield from computed[:-1]
            yield replace(computed[-1], id=result)
        else:
            yield Instr(result, "add", "i32", (total, Int(0)), loc=op.loc)

    def _as_offset(self, op: Instr) -> Instr:
        """An address as an integer: the byte offset will do, where only differences are taken."""
        offset = self._bytes(self._differences[op.id], op.loc)
        if op.type == "i64":
            return Instr(op.id, "sext", "i64", (offset,), source="i32", loc=op.loc)
        return Instr(op.id, "add", "i32", (offset, Int(0)), loc=op.loc)

    def _bytes(self, pointer: Value, loc: SourceLoc | None) -> Value:
        if isinstance(pointer, Named) and pointer.key in self._definitions:
            return self._bytes_of(pointer.key)
        self._address(pointer, loc)
        return Int(0)

    def _bytes_of(self, pointer: Key) -> Ref:
        """The byte offset of a pointer that is computed."""
        return Ref(self._ids(pointer))

    def _address(self, pointer: Value, loc: SourceLoc | None) -> _Address:
        if isinstance(pointer, Global):
            raise KernelError(
                "an access to a global that is no constant", loc=loc, hint=_GLOBAL_HINT
            )
        if not isinstance(pointer, Named):
            raise KernelError("an access through a null pointer", loc=loc, hint=_LOCAL_HINT)
        definition = self._definitions.get(pointer.key)
        if definition is None:
            return _Address(self._arrays[pointer.key])
        if choices_of(definition):
            return _Address(self._arrays[pointer.key], ((self._bytes_of(pointer.key), 1),))
        if (
            not isinstance(definition, Instr)
            or definition.op != "getelementptr"
            or not definition.strides
        ):
            raise KernelError("a pointer that is not an array parameter", loc=loc, hint=_LOCAL_HINT)
        return _extend(self._address(definition.operands[0], loc), definition)


def _extend(base: _Address, gep: Instr) -> _Address:
    terms = list(base.terms)
    offset = base.offset
    for index, stride in zip(gep.operands[1:], gep.strides, strict=True):
        if isinstance(index, Int):
            offset += index.value * stride
        else:
            terms.append((index, stride))
    return _Address(base.array, tuple(terms), offset)


def _sum(
    ids: FreshIds, terms: tuple[tuple[Value, int], ...], unit: int, loc: SourceLoc | None
) -> tuple[list[Instr], Value]:
    """Instructions that add up value * (stride / unit), and the operand that holds the sum."""
    out: list[Instr] = []
    total: Value | None = None
    for value, stride in terms:
        term = value
        if stride != unit:
            out.append(Instr(ids(), "mul", "i32", (value, Int(stride // unit)), loc=loc))
            term = Ref(out[-1].id)
        if total is not None:
            out.append(Instr(ids(), "add", "i32", (total, term), loc=loc))
            term = Ref(out[-1].id)
        total = term
    assert total is not None
    return out, total

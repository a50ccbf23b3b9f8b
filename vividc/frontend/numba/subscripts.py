"""Which element of a parameter an access names.

LLVM sees flat addresses only: `a[i, 1]` and `a[i, 2]` might meet if rows had one column. As the
program writes them they never do: either subscript lies in its array, or the access is undefined
as in numba. So what numba lowers from a subscript of a parameter in two or three dimensions keeps
its subscripts through LLVM, in two ways:

- Its index is computed with *pitches* (`PITCH`), which are the array's dimensions under names that
  nothing else has. No pass can know that a pitch equals a shape, so of an index as a polynomial
  the part with the pitch as a factor is the first subscript and the rest the second, whatever the
  subscripts were computed from.
- Its constant subscripts are metadata that no pass of LLVM knows. A pass that merges two accesses
  drops it, one that moves an access keeps it, and both are sound: the fact is about the access
  itself.

Views, helpers' parameters and flat indices say nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from llvmlite import ir as llvm
from numba.core import cgutils, ir, types
from numba.core.ir_utils import build_definitions
from numba.core.lowering import Lower
from numba.np import arrayobj

from vividc.frontend.llvm.calls import PITCH
from vividc.frontend.llvm.subscripts import KIND, VARIABLE, Subscript
from vividc.machine.params import MAX_DIMENSION


@dataclass(frozen=True, slots=True)
class _Element:
    """An element of a parameter: its constant subscripts, () if there are none, and the array's
    name where the parameter is the kernel's.
    """

    subscript: Subscript = ()
    array: str = ""


@contextmanager
def marked_subscripts(py_func: Callable[..., Any], args: tuple[Any, ...]) -> Iterator[None]:
    """Marks the accesses of `py_func` (its own, not its callees') while numba lowers it; `args` are
    the types of the kernel's parameters.
    """
    lower_inst, load, store = Lower.lower_inst, arrayobj.load_item, arrayobj.store_item
    item_pointer = cgutils.get_item_pointer2
    current = [_Element()]
    markers: dict[Any, _Marker] = {}

    def lower_marked(lower: Any, inst: Any) -> None:
        outer = current[0]
        current[0] = _Element()
        if lower.func_ir.func_id.func is py_func:
            if lower not in markers:
                markers[lower] = _Marker(lower, tuple(lower.fndesc.argtypes) == args)
            current[0] = markers[lower].element(inst)
        try:
            lower_inst(lower, inst)
        finally:
            current[0] = outer

    def load_marked(context: Any, builder: Any, type_: Any, pointer: Any) -> Any:
        value = load(context, builder, type_, pointer)
        _attach(builder, pointer, current[0].subscript)
        return value

    def store_marked(context: Any, builder: Any, type_: Any, value: Any, pointer: Any) -> None:
        store(context, builder, type_, value, pointer)
        _attach(builder, pointer, current[0].subscript)

    def pointer_by_pitches(
        context: Any, builder: Any, data: Any, shape: Any, *rest: Any, **named: Any
    ) -> Any:
        if current[0].array:
            shape = pitches_of(builder, current[0].array, shape)
        return item_pointer(context, builder, data, shape, *rest, **named)

    Lower.lower_inst = lower_marked
    arrayobj.load_item, arrayobj.store_item = load_marked, store_marked
    cgutils.get_item_pointer2 = pointer_by_pitches
    try:
        yield
    finally:
        Lower.lower_inst = lower_inst
        arrayobj.load_item, arrayobj.store_item = load, store
        cgutils.get_item_pointer2 = item_pointer


@dataclass
class _Marker:
    """Finds elements of parameters in one function of numba's; `is_kernel`: whether its parameters
    are the kernel's.
    """

    lower: Any
    is_kernel: bool

    def __post_init__(self) -> None:
        self.definitions = build_definitions(self.lower.func_ir.blocks)

    def element(self, inst: Any) -> _Element:
        """What a statement reads or writes, if it is one element of a parameter."""
        access = _array_and_index(inst)
        if access is None:
            return _Element()
        array, index = access
        type_ = self.lower.typeof(array.name)
        if not isinstance(type_, types.Array) or type_.layout != "C" or type_.ndim == 1:
            return _Element()
        made = self._definition(array)
        if not isinstance(made, ir.Arg):
            return _Element()
        selects = self._subscripts_of(index) == type_.ndim
        name = made.name if selects and self.is_kernel else ""
        parts = tuple(_constant(part) for part in self._parts(index))
        constant = len(parts) == type_.ndim and any(part is not None for part in parts)
        return _Element(parts if constant else (), name)

    def _subscripts_of(self, index: Any) -> int:
        """How many integers an index is; 0 if it is something else."""
        if isinstance(index, tuple):
            return len(index) if all(type(part) is int for part in index) else 0
        type_ = self.lower.typeof(index.name) if isinstance(index, ir.Var) else None
        if not isinstance(type_, types.BaseTuple):
            return 0
        integers = all(isinstance(part, types.Integer) for part in type_.types)
        return len(type_.types) if integers else 0

    def _parts(self, index: Any) -> Iterator[Any]:
        """What the subscripts that select one element are: numba's definitions, or integers."""
        if isinstance(index, ir.Var):
            type_ = self.lower.typeof(index.name)
            if not isinstance(type_, types.BaseTuple):
                return
            if not all(isinstance(part, types.Integer) for part in type_.types):
                return  # a slice, an array, None or an ellipsis
            made = self._definition(index)
            if isinstance(made, ir.Expr) and made.op == "build_tuple":
                yield from (self._definition(item) for item in made.items)
                return
            index = getattr(made, "value", None)
        if isinstance(index, tuple) and all(type(part) is int for part in index):
            yield from index

    def _definition(self, variable: Any) -> Any:
        """The only definition of a variable, through copies; None if there are several."""
        seen = set()
        while isinstance(variable, ir.Var) and variable.name not in seen:
            seen.add(variable.name)
            made = self.definitions.get(variable.name, [])
            variable = made[0] if len(made) == 1 else None
        return variable


def _array_and_index(inst: Any) -> tuple[Any, Any] | None:
    if isinstance(inst, ir.SetItem | ir.StaticSetItem):
        return inst.target, inst.index
    value = inst.value if isinstance(inst, ir.Assign) else None
    if isinstance(value, ir.Expr) and value.op in ("getitem", "static_getitem"):
        return value.value, value.index
    return None


def _constant(part: Any) -> int | None:
    value = part.value if isinstance(part, ir.Const | ir.Global | ir.FreeVar) else part
    if type(value) is not int or not 0 <= value < MAX_DIMENSION:
        return None  # a negative one counts from the end
    return value


def pitches_of(builder: Any, array: str, shape: Any) -> list[Any]:
    """The dimensions of an array, by pitches but for the first; computed where the function
    begins.
    """
    with builder.goto_entry_block():
        return [shape[0], *(_pitch(builder, array, axis) for axis in range(1, len(shape)))]


def _pitch(builder: Any, array: str, axis: int) -> Any:
    word = llvm.IntType(32)
    callee = cgutils.get_or_insert_function(
        builder.module, llvm.FunctionType(word, ()), f"{PITCH}{array}.{axis}"
    )
    return builder.zext(builder.call(callee, ()), llvm.IntType(64))


def _attach(builder: Any, pointer: Any, subscript: Subscript) -> None:
    """Gives the access to `pointer` that was emitted last its subscripts."""
    if not subscript:
        return
    text = ",".join(VARIABLE if part is None else str(part) for part in subscript)
    for made in reversed(builder.block.instructions):
        if isinstance(made, llvm.LoadInstr) and made.operands[0] is pointer:
            break
        if isinstance(made, llvm.StoreInstr) and made.operands[1] is pointer:
            break
    else:
        return
    module = builder.module
    made.set_metadata(KIND, module.add_metadata([llvm.MetaDataString(module, text)]))

"""Which element of a parameter an access names, where its subscripts are constants.

LLVM sees flat addresses only: `a[i, 1]` and `a[i, 2]` might meet if rows had one column. As the
program writes them they never do: either subscript lies in its array, or the access is undefined
as in numba. So an access that numba lowers from a subscript of a parameter in two or three
dimensions carries its constant subscripts through LLVM, as metadata that no pass of LLVM knows. A
pass that merges two accesses drops it, one that moves an access keeps it, and both are sound: the
fact is about the access itself. Views, helpers' parameters and flat indices say nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from llvmlite import ir as llvm
from numba.core import ir, types
from numba.core.ir_utils import build_definitions
from numba.core.lowering import Lower
from numba.np import arrayobj

from vividc.frontend.llvm.subscripts import KIND, VARIABLE, Subscript
from vividc.machine.params import MAX_DIMENSION


@contextmanager
def marked_subscripts(py_func: Callable[..., Any]) -> Iterator[None]:
    """Marks the accesses of `py_func` (its own, not its callees') while numba lowers it."""
    lower_inst, load, store = Lower.lower_inst, arrayobj.load_item, arrayobj.store_item
    current: list[Subscript] = [()]
    markers: dict[Any, _Marker] = {}

    def lower_marked(lower: Any, inst: Any) -> None:
        outer = current[0]
        current[0] = ()
        if lower.func_ir.func_id.func is py_func:
            if lower not in markers:
                markers[lower] = _Marker(lower)
            current[0] = markers[lower].subscript(inst)
        try:
            lower_inst(lower, inst)
        finally:
            current[0] = outer

    def load_marked(context: Any, builder: Any, type_: Any, pointer: Any) -> Any:
        value = load(context, builder, type_, pointer)
        _attach(builder, pointer, current[0])
        return value

    def store_marked(context: Any, builder: Any, type_: Any, value: Any, pointer: Any) -> None:
        store(context, builder, type_, value, pointer)
        _attach(builder, pointer, current[0])

    Lower.lower_inst = lower_marked
    arrayobj.load_item, arrayobj.store_item = load_marked, store_marked
    try:
        yield
    finally:
        Lower.lower_inst = lower_inst
        arrayobj.load_item, arrayobj.store_item = load, store


@dataclass
class _Marker:
    """Finds the constant subscripts in one function of numba's."""

    lower: Any

    def __post_init__(self) -> None:
        self.definitions = build_definitions(self.lower.func_ir.blocks)

    def subscript(self, inst: Any) -> Subscript:
        """Of a statement that reads or writes one element of a parameter; () if it is another, or
        none is constant.
        """
        access = _array_and_index(inst)
        if access is None:
            return ()
        array, index = access
        type_ = self.lower.typeof(array.name)
        if not isinstance(type_, types.Array) or type_.layout != "C":
            return ()
        if type_.ndim == 1 or not isinstance(self._definition(array), ir.Arg):
            return ()
        parts = tuple(_constant(part) for part in self._parts(index))
        return parts if len(parts) == type_.ndim and any(p is not None for p in parts) else ()

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

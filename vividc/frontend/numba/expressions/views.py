"""Where elements of a view lie in its array: of `A[1:-1, 2:]` element (i, j) is `A[1 + i, 2 + j]`.

Numba's views are a pointer, a shape and strides, of which no pass can tell any more which element
of a parameter an access names. So what each view selects is kept beside it, by variable: the
subscript of its first element along each dimension of its array, and its steps. It changes when
the variable does and only then. Loops over a view address its array by subscripts as loops do that
are written by hand (`subscripts`).

Lengths of slices are simpler than numba's where bounds are constants, and equal: `1:-1` has
max(size - 2, 0) elements. The first element of a slice is what it is unless the slice is empty,
when nothing reads it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Any, Final

from llvmlite import ir as llvm
from numba.core import cgutils, ir, types
from numba.core.ir_utils import build_definitions, find_callname, guard
from numba.core.lowering import Lower
from numba.np import arrayobj

from vividc.frontend.numba.expressions.numbers import Number, Numbers, value
from vividc.frontend.numba.expressions.origins import copied
from vividc.frontend.numba.subscripts import pitches_of

_UNKNOWN: Final = object()
_ITEMS: Final = ("getitem", "static_getitem")


@dataclass(frozen=True, slots=True)
class View:
    """What a view selects.

    Attributes
    ----------
    array
        The kernel's parameter; "" for any other array.
    data
        Pointer to the first element of the array.
    sizes
        The array's dimensions.
    first
        Subscripts of the view's first element in the array.
    axes
        For each dimension of the view the array's dimension and the step; None for a new one.
    shape
        The view's.
    """

    array: str
    data: Any
    sizes: tuple[Number, ...]
    first: tuple[Number, ...]
    axes: tuple[tuple[int, Number] | None, ...]
    shape: tuple[Number, ...]

    def pointer(self, context: Any, builder: llvm.IRBuilder, indices: list[Any]) -> Any:
        """The address of an element of the view."""
        at, numbers = list(self.first), Numbers(builder)
        for axis, index in zip(self.axes, indices, strict=True):
            if axis is not None:
                at[axis[0]] = numbers.add(at[axis[0]], numbers.mul(index, axis[1]))
        sizes = [value(size) for size in self.sizes]
        if self.array:
            sizes = pitches_of(builder, self.array, sizes)
        places = [value(one) for one in at]
        return cgutils.get_item_pointer2(context, builder, self.data, sizes, None, "C", places)


operands: ContextVar[list[View | None] | None] = ContextVar("operands", default=None)
"""What the operands of the array expression select that is lowered."""


class Views:
    """What the array variables of a function select.

    `lowerer` is numba's; `args` are the types of the kernel's parameters.
    """

    def __init__(self, lowerer: Any, args: tuple[Any, ...]) -> None:
        self._lowerer = lowerer
        self._is_kernel = tuple(lowerer.fndesc.argtypes) == args
        self._definitions = build_definitions(lowerer.func_ir.blocks)
        self._begin = _begin_of(lowerer)
        self._numbers = Numbers(lowerer.builder, self._begin)
        self._kept: dict[str, View] = {}

    def only(self, name: str) -> Any:
        """The only definition of a variable; None if there are several."""
        made = self._definitions.get(name, ())
        return made[0] if len(made) == 1 else None

    def record(self, inst: Any) -> None:
        """Keep what the variable selects that a statement assigned to, which was lowered."""
        if not isinstance(inst, ir.Assign) or self.only(inst.target.name) is not inst.value:
            return
        kind = self._lowerer.typeof(inst.target.name)
        made = self._made(inst, kind) if isinstance(kind, types.Array) else None
        if made is not None:
            self._kept[inst.target.name] = self._slots(made)

    def of(self, name: str) -> View | None:
        """What a variable selects; None if that is not known."""
        kept = self._kept.get(name)
        return None if kept is None else _each(kept, self._loaded)

    def part(self, array: str, index: Any) -> View | None:
        """What an index selects of an array that is assigned to there; None if it is not known."""
        base = self.of(array)
        return None if base is None else self._part(base, index)

    def _made(self, inst: Any, kind: Any) -> View | None:
        made = inst.value
        other = copied(made, kind, self._lowerer.typeof)
        if other is not None:
            return self.of(other.name)
        if isinstance(made, ir.Expr) and made.op in _ITEMS:
            base = self.of(made.value.name)
            index = made.index if made.op == "getitem" else made.index_var
            return None if base is None or index is None else self._part(base, index)
        if isinstance(made, ir.Expr) and made.op == "getattr" and made.attr == "T":
            base = self.of(made.value.name)
            turned = base and replace(base, axes=base.axes[::-1], shape=base.shape[::-1])
            return turned
        return self._whole(inst, kind) if kind.layout == "C" else None

    def _whole(self, inst: Any, kind: Any) -> View:
        """An array, all of it."""
        lowerer, made = self._lowerer, inst.value
        name = ""
        builder = lowerer.builder
        if isinstance(made, ir.Arg):
            name = made.name if self._is_kernel else ""
            with builder.goto_block(self._begin):
                data, sizes = self._read(lowerer.fnargs[made.index], kind)
            self._numbers.fix(data, *sizes)
        else:
            data, sizes = self._read(lowerer.loadvar(inst.target.name), kind)
        axes = tuple((axis, 1) for axis in range(kind.ndim))
        return View(name, data, sizes, (0,) * kind.ndim, axes, sizes)

    def _read(self, struct: Any, kind: Any) -> tuple[Any, tuple[Any, ...]]:
        """Pointer and shape of an array."""
        builder = self._lowerer.builder
        array = arrayobj.make_array(kind)(self._lowerer.context, builder, struct)
        return array.data, tuple(cgutils.unpack_tuple(builder, array.shape, kind.ndim))

    def _slots(self, view: View) -> View:
        return _each(view, self._stored)

    def _stored(self, one: Any) -> Any:
        if self._numbers.is_fixed(one):
            return one
        slot = cgutils.alloca_once(self._lowerer.builder, one.type)
        self._lowerer.builder.store(one, slot)
        return slot

    def _loaded(self, slot: Any) -> Any:
        return slot if self._numbers.is_fixed(slot) else self._lowerer.builder.load(slot)

    def _part(self, base: View, index: Any) -> View | None:
        """What an index selects of a view; None for other indices than numbers and slices."""
        parts = self._parts(index)
        if parts is None:
            return None
        given = sum(one.kind not in (_ELLIPSIS, _NEW) for one in parts)
        whole = _Index(_SLICE, (None, None, None), None)
        open_ = [one for one in parts if one.kind == _ELLIPSIS]
        if len(open_) > 1 or given > len(base.axes):
            return None
        missing = [whole] * (len(base.axes) - given)
        place = parts.index(open_[0]) if open_ else len(parts)
        parts = [*parts[:place], *missing, *parts[place + len(open_) :]]
        return self._selected(base, parts)

    def _selected(self, base: View, parts: list[_Index]) -> View | None:
        numbers = self._numbers
        first = list(base.first)
        axes: list[tuple[int, Number] | None] = []
        shape: list[Number] = []
        dims = iter(zip(base.axes, base.shape, strict=True))
        for one in parts:
            if one.kind == _NEW:
                axes.append(None)
                shape.append(1)
                continue
            axis, size = next(dims)
            found = self._along(one, size)
            if found is None:
                return None
            begin, step, length = found
            if axis is not None:
                first[axis[0]] = numbers.add(first[axis[0]], numbers.mul(begin, axis[1]))
                axis = axis[0], numbers.mul(axis[1], step)
            if one.kind == _SLICE:
                axes.append(axis)
                shape.append(length)
        return replace(base, first=tuple(first), axes=tuple(axes), shape=tuple(shape))

    def _along(self, one: _Index, size: Number) -> tuple[Number, int, Number] | None:
        """The first index along a dimension, the step, and how many there are."""
        if one.kind == _NUMBER:
            return self._number(one, size), 1, 1
        step = 1 if one.bounds[2] is None else one.bounds[2]
        if not isinstance(step, int) or step == 0:
            return None
        start, stop = (
            one.read(number) if bound is _UNKNOWN else bound
            for number, bound in enumerate(one.bounds[:2])
        )
        along = self._numbers.up if step > 0 else self._numbers.down
        begin, length = along(start, stop, size)
        if abs(step) > 1:
            length = self._numbers.divide(self._numbers.add(length, abs(step) - 1), abs(step))
        return begin, step, length

    def _number(self, one: _Index, size: Number) -> Number:
        [number] = one.bounds
        if number is _UNKNOWN:
            return one.read(0, value(size))
        return number if number >= 0 else self._numbers.add(size, number)

    def _parts(self, index: Any) -> list[_Index] | None:
        """What an index is made of, by dimension."""
        lowerer, kind = self._lowerer, self._lowerer.typeof(index.name)
        made = self._through(index)
        if not isinstance(kind, types.BaseTuple):
            one = self._index(kind, made, lambda: lowerer.loadvar(index.name))
            return None if one is None else [one]
        items: list[Any] = [_UNKNOWN] * len(kind)
        if isinstance(made, ir.Expr) and made.op == "build_tuple":
            items = [self._through(item) for item in made.items]
        elif isinstance(made, ir.Const | ir.Global | ir.FreeVar):
            items = [ir.Const(item, made.loc) for item in made.value]
        parts: list[_Index] = []
        for number, (item, type_) in enumerate(zip(items, kind, strict=True)):

            def read(number: int = number) -> Any:
                return lowerer.builder.extract_value(lowerer.loadvar(index.name), number)

            part = self._index(type_, item, read)
            if part is None:
                return None
            parts.append(part)
        return parts

    def _index(self, kind: Any, made: Any, read: Callable[[], Any]) -> _Index | None:
        """One part of an index: its type, definition, and how to read it."""
        context, builder = self._lowerer.context, self._lowerer.builder
        constant = isinstance(made, ir.Const | ir.Global | ir.FreeVar)
        if kind is types.ellipsis:
            return _Index(_ELLIPSIS, (), None)
        if isinstance(kind, types.NoneType):
            return _Index(_NEW, (), None)
        if isinstance(kind, types.Integer):

            def number(_: int, size: Any) -> Any:
                return arrayobj.fix_integer_index(context, builder, kind, read(), size)

            known = constant and type(made.value) is int
            return _Index(_NUMBER, (made.value if known else _UNKNOWN,), number)
        if not isinstance(kind, types.SliceType):
            return None

        def bound(number: int) -> Any:
            slice_ = context.make_helper(builder, kind, value=read())
            return getattr(slice_, ("start", "stop", "step")[number])

        return _Index(_SLICE, self._bounds(kind, made), bound)

    def _bounds(self, kind: Any, made: Any) -> tuple[Any, Any, Any]:
        """The constant bounds of a slice."""
        step = _UNKNOWN if kind.has_step else None
        if isinstance(made, ir.Const | ir.Global | ir.FreeVar) and isinstance(made.value, slice):
            found = [made.value.start, made.value.stop, made.value.step]
            whole = all(one is None or type(one) is int for one in found)
            return (found[0], found[1], found[2]) if whole else (_UNKNOWN, _UNKNOWN, step)
        called = isinstance(made, ir.Expr) and made.op == "call" and not made.kws
        if not called or guard(find_callname, self._lowerer.func_ir, made) != ("slice", "builtins"):
            return _UNKNOWN, _UNKNOWN, step
        args = [self._constant(arg) for arg in made.args]
        args = [None, *args] if len(args) == 1 else args
        return (*args, None)[0], args[1], args[2] if len(args) > 2 else step  # noqa: PLR2004

    def _constant(self, var: Any) -> Any:
        if isinstance(self._lowerer.typeof(var.name), types.NoneType):
            return None
        made = self._through(var)
        constant = isinstance(made, ir.Const | ir.Global | ir.FreeVar) and type(made.value) is int
        return made.value if constant else _UNKNOWN

    def _through(self, var: Any) -> Any:
        """The only definition of a variable, through copies, and a negated number as one."""
        seen = set()
        while isinstance(var, ir.Var) and var.name not in seen:
            seen.add(var.name)
            var = self.only(var.name)
        if isinstance(var, ir.Expr) and var.op == "unary" and var.fn.__name__ == "neg":
            inner = self._through(var.value)
            if isinstance(inner, ir.Const) and type(inner.value) is int:
                return ir.Const(-inner.value, inner.loc)
        return var


_NUMBER, _SLICE, _ELLIPSIS, _NEW = "number", "slice", "ellipsis", "new axis"


@dataclass(frozen=True, slots=True)
class _Index:
    """One part of an index; `bounds`: constants, None or `_UNKNOWN`, which `read` reads."""

    kind: str
    bounds: tuple[Any, ...]
    read: Any


def _each(view: View, change: Callable[[Any], Any]) -> View:
    """A view with all its numbers changed."""
    return View(
        view.array,
        change(view.data),
        tuple(map(change, view.sizes)),
        tuple(map(change, view.first)),
        tuple(None if one is None else (one[0], change(one[1])) for one in view.axes),
        tuple(map(change, view.shape)),
    )


def _begin_of(lowerer: Any) -> Any:
    """The block in which the function has all its arguments, before its statements are lowered: the
    only one without an end that is not theirs. A flag takes a branch, and this is not the first.
    """
    own = set(lowerer.blkmap.values())
    [begin] = [one for one in lowerer.function.blocks if one not in own and one.terminator is None]
    return begin


_views: ContextVar[dict[Any, Views] | None] = ContextVar("views", default=None)


def views_of(lowerer: Any) -> Views | None:
    """Those of a function of the kernel's own that is lowered; None for any other."""
    kept = _views.get()
    return None if kept is None else kept.get(lowerer)


@contextmanager
def followed_views(py_func: Callable[..., Any], args: tuple[Any, ...]) -> Iterator[None]:
    """Keep what the views of `py_func` select while numba lowers it; `args` are the types of the
    kernel's parameters.
    """
    lower_inst = Lower.lower_inst
    kept: dict[Any, Views] = {}

    def lower(lowerer: Any, inst: Any) -> None:
        is_own = lowerer.func_ir.func_id.func is py_func
        if is_own and lowerer not in kept:
            kept[lowerer] = Views(lowerer, args)
        given = _operands(inst) if is_own else None
        selected = None if given is None else [kept[lowerer].of(name) for name in given]
        before = _views.set(kept if is_own else None), operands.set(selected)
        try:
            lower_inst(lowerer, inst)
        finally:
            _views.reset(before[0])
            operands.reset(before[1])
        if is_own:
            kept[lowerer].record(inst)

    Lower.lower_inst = lower
    try:
        yield
    finally:
        Lower.lower_inst = lower_inst


def _operands(inst: Any) -> list[str] | None:
    """The operands of an array expression, in the order in which its loops have them."""
    made = inst.value if isinstance(inst, ir.Assign) else None
    if not isinstance(made, ir.Expr) or made.op not in ("arrayexpr", "inplace_binop"):
        return None
    if made.op == "inplace_binop":
        return [made.lhs.name, made.rhs.name, made.lhs.name]
    return sorted({var.name for var in made.list_vars()})

"""Lists that grow and shrink: `out.append(x)`, `stack.pop()`, `[x for x in a if x > 0]`.

A list is a length and an array for each number of its elements (a tuple has several, a complex
number two). Numba's lowering of lists is kept, on this other memory. How many elements an array
must hold is found behind LLVM, from calls of `FITS`, of which there is one wherever a list becomes
longer: `memory.arrays.capacities` has the bound of the length that is known at launch, or lets
the run test it.

The length and the arrays' places are variables of the function that makes the list, at one place in
the kernel that it becomes part of: what a line makes in each iteration lies there (`kept`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir
from numba.core import cgutils, errors, types
from numba.cpython import listobj

from vividc.frontend.llvm.calls import AS_NEEDED, FITS, OVERFLOW
from vividc.frontend.numba.arrays import allocated
from vividc.lang.formats import MISUSE

_I64 = ir.IntType(64)
_NUMBERS = types.Integer | types.Float | types.Boolean


@contextmanager
def lists_are_ours() -> Iterator[None]:
    """Numba looks these up in its module whenever it lowers what is done to a list."""
    patches = {
        "ListInstance": _List,
        "ListIterInstance": _ListIterator,
        "get_list_payload": _Length,
    }
    originals = {name: getattr(listobj, name) for name in patches}
    vars(listobj).update(patches)
    try:
        yield
    finally:
        vars(listobj).update(originals)


def list_of(context: Any, builder: ir.IRBuilder, sig: Any, args: Any) -> Any:
    """`list(iterable)`, made where it is called."""
    made = _List.allocate(context, builder, sig.return_type, 0)
    extend = sig.return_type, sig.args[0]
    context.compile_internal(builder, _extend, types.none(*extend), (made.value, args[0]))
    return made.value


def _extend(made: Any, iterable: Any) -> None:
    for item in iterable:
        made.append(item)


class _Length:
    """What a list's header holds: its length and where its arrays are.

    Stands for numba's payload, of which only the length is used.
    """

    def __init__(self, context: Any, builder: ir.IRBuilder, list_type: Any, value: Any) -> None:
        self._builder = builder
        self._header = builder.bitcast(value.meminfo, _header_of(context, list_type).as_pointer())

    @property
    def size(self) -> Any:
        """The number of elements."""
        return self._builder.load(self._field(0))

    @size.setter
    def size(self, value: Any) -> None:
        self._builder.store(value, self._field(0))

    def array(self, number: int) -> Any:
        """The first element of an array."""
        return self._builder.load(self._field(number + 1))

    def place(self, number: int, array: Any) -> None:
        """Say where an array is."""
        self._builder.store(array, self._field(number + 1))

    def _field(self, number: int) -> Any:
        return cgutils.gep_inbounds(self._builder, self._header, 0, number)


def _header_of(context: Any, list_type: Any) -> Any:
    arrays = (context.get_data_type(leaf).as_pointer() for leaf in _leaves(list_type.dtype))
    return ir.LiteralStructType([_I64, *arrays])


def _leaves(dtype: Any) -> tuple[Any, ...]:
    """Numba's types of the numbers that an element is made of."""
    if isinstance(dtype, _NUMBERS):
        return (dtype,)
    if isinstance(dtype, types.Complex):
        return (dtype.underlying_float,) * 2
    if isinstance(dtype, types.BaseTuple):
        return tuple(leaf for one in dtype for leaf in _leaves(one))
    hint = "a list holds numbers or tuples of numbers; in place of arrays, one array of more axes"
    what = {types.List: "lists", types.Array: "arrays"}.get(type(dtype), str(dtype))
    raise errors.NumbaValueError(f"{MISUSE}a list of {what}: {hint}")


class _Stored(listobj._ListPayloadMixin):  # type: ignore[misc]
    """Elements in arrays, one of each number that they are made of."""

    @property
    def _element(self) -> Any:
        """Numba's type of an element."""
        raise NotImplementedError

    def getitem(self, idx: Any) -> Any:
        """As numba's."""
        numbers = [self._number(leaf, n, idx) for n, leaf in enumerate(_leaves(self._element))]
        return _joined(self._context.get_value_type(self._element), iter(numbers), self._builder)

    def _number(self, leaf: Any, number: int, idx: Any) -> Any:
        item = self._builder.load(self._place(number, idx))
        return self._context.data_model_manager[leaf].from_data(self._builder, item)

    def _place(self, number: int, idx: Any) -> Any:
        return cgutils.gep(self._builder, self._payload.array(number), idx)


def _joined(type_: Any, numbers: Iterator[Any], builder: ir.IRBuilder) -> Any:
    """The element of an LLVM type that is made of these numbers, the next ones."""
    if not isinstance(type_, ir.Aggregate):
        return next(numbers)
    whole: Any = ir.Constant(type_, ir.Undefined)
    for position, part in enumerate(type_.elements):
        item = _joined(part, numbers, builder)
        whole = builder.insert_value(whole, item, position)
    return whole


def _split(value: Any, builder: ir.IRBuilder) -> Iterator[Any]:
    """The numbers that an element is made of."""
    if not isinstance(value.type, ir.Aggregate):
        yield value
        return
    for position in range(len(value.type.elements)):
        yield from _split(builder.extract_value(value, position), builder)


class _List(_Stored, listobj.ListInstance):  # type: ignore[misc]
    """Numba's access to a list, in a kernel's memory."""

    @property
    def _element(self) -> Any:
        return self._ty.dtype

    def setitem(self, idx: Any, val: Any, incref: bool, decref_old_value: bool = True) -> None:
        """As numba's."""
        self.inititem(idx, val)

    def inititem(self, idx: Any, val: Any, incref: bool = True) -> None:
        """As numba's."""
        leaves = _leaves(self._element)
        for number, one in enumerate(_split(val, self._builder)):
            model = self._context.data_model_manager[leaves[number]]
            self._builder.store(model.as_data(self._builder, one), self._place(number, idx))

    def clear_value(self, idx: Any) -> None:
        """What was taken out need not be forgotten."""

    def zfill(self, start: Any, stop: Any) -> None:
        """Nothing reads an element before it is stored."""

    def set_dirty(self, val: Any) -> None:
        """No list is handed back to Python."""

    @classmethod
    def allocate_ex(cls, context: Any, builder: ir.IRBuilder, list_type: Any, nitems: Any) -> Any:
        """As numba's; memory is never short here, but by `FITS`."""
        made = cls(context, builder, list_type, None)
        header = cgutils.alloca_once(builder, _header_of(context, list_type))
        made._list.meminfo = builder.bitcast(header, made._list.meminfo.type)
        _begin_life(builder, header)
        made._list.parent = context.get_constant_null(types.pyobject)
        length = made._payload
        for number, leaf in enumerate(_leaves(list_type.dtype)):
            array = allocated(context, builder, leaf, _I64(AS_NEEDED))
            length.place(number, array)
        length.size = _I64(0)
        made._demand(_I64(nitems) if isinstance(nitems, int) else nitems)
        return cgutils.true_bit, made

    def resize(self, new_size: Any) -> None:
        """As numba's."""
        self._demand(new_size)
        self._payload.size = new_size

    def _demand(self, size: Any) -> None:
        """Raise MemoryError unless the arrays hold so many elements."""
        fit: Any = cgutils.true_bit
        for number in range(len(_leaves(self._element))):
            array = self._payload.array(number)
            signature = ir.FunctionType(ir.IntType(1), [array.type, _I64])
            symbol = f"{FITS}{array.type.pointee}"
            callee = cgutils.get_or_insert_function(self._builder.module, signature, symbol)
            callee.attributes.add("nounwind")
            callee.attributes.add("readnone")
            fit = self._builder.and_(fit, self._builder.call(callee, (array, size)))
        with cgutils.if_unlikely(self._builder, self._builder.not_(fit)):
            self._context.call_conv.return_user_exc(self._builder, MemoryError, (OVERFLOW,))

    def move(self, dest_idx: Any, src_idx: Any, count: Any) -> None:
        """As numba's, element by element: from the last where they move up."""
        builder = self._builder
        is_up = builder.icmp_signed(">", dest_idx, src_idx)
        last = builder.sub(count, _I64(1))
        with cgutils.for_range(builder, count) as loop:
            at = builder.select(is_up, builder.sub(last, loop.index), loop.index)
            item = self.getitem(builder.add(src_idx, at))
            self.inititem(builder.add(dest_idx, at), item)


def _begin_life(builder: ir.IRBuilder, variable: Any) -> None:
    """A variable is there from here to the kernel's end: otherwise LLVM ends its life with that of
    the function which makes the list, and which may return it.
    """
    pointer = ir.IntType(8).as_pointer()
    signature = ir.FunctionType(ir.VoidType(), [_I64, pointer])
    start = cgutils.get_or_insert_function(builder.module, signature, "llvm.lifetime.start.p0")
    builder.call(start, (_I64(-1), builder.bitcast(variable, pointer)))


class _ListIterator(_Stored, listobj.ListIterInstance):  # type: ignore[misc]
    """Numba's iterator of a list, in a kernel's memory."""

    @property
    def _element(self) -> Any:
        return self._ty.container.dtype

"""How our numba target lowers the arrays that a kernel makes itself, constant arrays, and tuples
indexed by a variable.

Each becomes something that survives LLVM and that `local_arrays` recognises afterwards: a call of
`ALLOCATE` + element type with the number of elements, a constant global `TABLE` + digest, a call of
`PICK` with the index and the elements.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Literal

import numpy as np
from llvmlite import ir
from numba.core import cgutils, errors, lowering, types
from numba.core.runtime.context import NRTContext
from numba.cpython import slicing, tupleobj
from numba.extending import overload
from numba.np import arraymath, arrayobj, npyimpl

from vividc.frontend.llvm.calls import ALLOCATE, COPY, OVERLAP, PICK, TABLE
from vividc.frontend.numba.expressions.loops import ufunc_loops
from vividc.frontend.numba.lines import first_line
from vividc.frontend.numba.raises.convention import trap
from vividc.lang.formats import MISUSE

_I64 = ir.IntType(64)
_I32 = ir.IntType(32)
_DIGEST = 16


class NoRuntime(NRTContext):  # type: ignore[misc]
    """Numba's interface to its heap, which an array has not: what needs it is numba's error."""

    def incref(self, *_: Any) -> None:
        """Nothing is counted."""

    def decref(self, *_: Any) -> None:
        """Nothing is counted."""

    def allocate(self, builder: ir.IRBuilder, size: Any) -> Any:
        """Numba's temporary copy of a slice that may overlap another."""
        pointer = ir.IntType(8).as_pointer()
        callee = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(pointer, (size.type,)), f"{ALLOCATE}{COPY}"
        )
        return builder.call(callee, (size,))

    def free(self, *_: Any) -> None:
        """Nothing is freed."""


@contextmanager
def arrays_are_ours() -> Iterator[None]:
    """Numba looks these functions up in its modules whenever it lowers an allocation or a tuple."""
    patches = (
        (arrayobj, "_empty_nd_impl", _allocate),
        (arraymath, "_empty_nd_impl", _allocate),
        (tupleobj, "getitem_unituple", pick),
        (cgutils, "memset", _memset),
        (cgutils, "raw_memcpy", _copy),
        (arrayobj, "extents_may_overlap", ask_later),
        (arrayobj, "array_reshape", reshape),
        (slicing, "fix_slice", _fix_slice),
        (npyimpl, "numpy_ufunc_kernel", ufunc_loops),
        (npyimpl._ArrayIndexingHelper, "update_indices", _update_indices),
        (lowering, "get_func_body_first_lineno", first_line),
    )
    originals = [getattr(module, name) for module, name, _ in patches]
    for module, name, ours in patches:
        setattr(module, name, ours)
    try:
        yield
    finally:
        for (module, name, _), original in zip(patches, originals, strict=True):
            setattr(module, name, original)


def _allocate(context: Any, builder: ir.IRBuilder, arrtype: Any, shapes: Any) -> Any:
    """Numba's `_empty_nd_impl` without its runtime: the array lies in the scratchpad."""
    array = arrayobj.make_array(arrtype)(context, builder)
    itemsize = context.get_constant(types.intp, arrayobj.get_itemsize(context, arrtype))
    shapes = list(shapes)
    count: Any = _I64(1)
    for size in shapes:
        count = builder.mul(count, size, flags=["nsw"])
    strides = [itemsize]
    for size in reversed(shapes[1:]) if arrtype.layout == "C" else shapes[:-1]:
        strides.append(builder.mul(strides[-1], size, flags=["nsw"]))
    strides = strides[: arrtype.ndim]
    if arrtype.layout == "C":
        strides.reverse()
    arrayobj.populate_array(
        array,
        data=allocated(context, builder, arrtype.dtype, count),
        shape=cgutils.pack_array(builder, shapes, ty=_I64),
        strides=cgutils.pack_array(builder, strides, ty=_I64),
        itemsize=itemsize,
        meminfo=None,
    )
    return array


def allocated(context: Any, builder: ir.IRBuilder, dtype: Any, count: Any) -> Any:
    """The first of so many elements of numba's type that the kernel makes: a call of `ALLOCATE`."""
    pointer = context.get_data_type(dtype).as_pointer()
    signature = ir.FunctionType(pointer, (_I64,))
    callee = cgutils.get_or_insert_function(builder.module, signature, f"{ALLOCATE}{dtype}")
    callee.attributes.add("nounwind")
    callee.attributes.add("inaccessiblememonly")
    callee.return_value.add_attribute("noalias")
    return builder.call(callee, (count,))


def _memset(builder: ir.IRBuilder, pointer: Any, size: Any, value: int) -> None:
    """Stores of whole elements in a loop: an array's elements are words, not bytes."""
    pointer = _of_numbers(builder, pointer)
    element = pointer.type.pointee
    if not isinstance(element, (ir.IntType, ir.FloatType, ir.DoubleType)) or value != 0:
        _cgutils_memset(builder, pointer, size, value)
        return
    bytes_ = {ir.FloatType(): 4, ir.DoubleType(): 8}.get(element) or -(-element.width // 8)
    count = builder.udiv(size, size.type(bytes_))
    zero = element(0) if isinstance(element, ir.IntType) else element(0.0)
    with cgutils.for_range(builder, count) as loop:
        builder.store(zero, builder.gep(pointer, (loop.index,), inbounds=True))


_cgutils_memset = cgutils.memset


def _fix_slice(builder: ir.IRBuilder, slice_: Any, size: Any) -> None:
    """Numba's `fix_slice` without branches: bounds count from the end if negative, then are cut."""
    is_down = cgutils.is_neg_int(builder, slice_.step)
    last = builder.add(size, size.type(-1), flags=["nsw"])
    lowest = builder.select(is_down, size.type(-1), size.type(0))
    highest = builder.select(is_down, last, size)
    for name in ("start", "stop"):
        bound = getattr(slice_, name)
        from_end = builder.add(bound, size)
        bound = builder.select(builder.icmp_signed("<", bound, size.type(0)), from_end, bound)
        bound = builder.select(builder.icmp_signed("<", bound, lowest), lowest, bound)
        bound = builder.select(builder.icmp_signed(">", bound, highest), highest, bound)
        setattr(slice_, name, bound)


def _update_indices(helper: Any, loop_indices: Any, _: str) -> None:
    """Numba's method without branches: along a dimension of one element the index stays 0."""
    array = helper.array
    builder = array.builder
    first = len(loop_indices) - len(helper.indices)
    for index, source, size in zip(loop_indices[first:], helper.indices, array.shape, strict=True):
        is_many = builder.icmp_unsigned(">", size, size.type(1))
        builder.store(builder.select(is_many, index, index.type(0)), source)


def _copy(
    builder: ir.IRBuilder, to: Any, source: Any, count: Any, itemsize: Any, align: int = 1
) -> None:
    """Numba's `raw_memcpy`, element by element."""
    if _is_complex(to.type.pointee):
        to, source = (_of_numbers(builder, pointer) for pointer in (to, source))
        count = builder.mul(count, count.type(2))
    if not isinstance(to.type.pointee, (ir.IntType, ir.FloatType, ir.DoubleType)):
        _cgutils_copy(builder, to, source, count, itemsize, align)
        return
    with cgutils.for_range(builder, count) as loop:
        item = builder.load(builder.gep(source, (loop.index,), inbounds=True))
        builder.store(item, builder.gep(to, (loop.index,), inbounds=True))


_cgutils_copy = cgutils.raw_memcpy


def _is_complex(element: Any) -> bool:
    """Whether elements are numba's complex numbers: a structure of two floats of one type."""
    parts: tuple[Any, ...] = getattr(element, "elements", ())
    return len(parts) == 2 and parts[0] == parts[1] and parts[0] in _REALS  # noqa: PLR2004


_REALS = (ir.FloatType(), ir.DoubleType())


def _of_numbers(builder: ir.IRBuilder, pointer: Any) -> Any:
    """A pointer to complex numbers as one to their parts; any other as it is."""
    element = pointer.type.pointee
    if not _is_complex(element):
        return pointer
    return builder.bitcast(pointer, element.elements[0].as_pointer())


def reshape(context: Any, builder: ir.IRBuilder, sig: Any, args: Any) -> Any:
    """`x.reshape(shape)` of a contiguous array, without numba's loops over the shape."""
    if sig.args[0].layout != "C" or sig.return_type.layout != "C":
        return _array_reshape(context, builder, sig, args)
    source = arrayobj.make_array(sig.args[0])(context, builder, args[0])
    given = [
        context.cast(builder, size, type_, types.intp)
        for size, type_ in zip(cgutils.unpack_tuple(builder, args[1]), sig.args[1], strict=True)
    ]
    open_ = [builder.icmp_signed("<", size, _I64(0)) for size in given]
    known = _product(
        builder, [builder.select(o, _I64(1), s) for o, s in zip(open_, given, strict=True)]
    )
    rest = builder.udiv(source.nitems, builder.select(_is_zero(builder, known), _I64(1), known))
    shape = [builder.select(o, rest, s) for o, s in zip(open_, given, strict=True)]
    wrong = builder.icmp_signed("!=", _product(builder, shape), source.nitems)
    with cgutils.if_unlikely(builder, wrong):
        context.call_conv.return_user_exc(
            builder, ValueError, ("total size of new array must be unchanged",)
        )
    strides = [source.itemsize]
    for size in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], size, flags=["nsw"]))
    result = arrayobj.make_array(sig.return_type)(context, builder)
    arrayobj.populate_array(
        result,
        data=source.data,
        shape=shape,
        strides=strides[: len(shape)],
        itemsize=source.itemsize,
        meminfo=source.meminfo,
        parent=source.parent,
    )
    return result._getvalue()


_array_reshape: Callable[..., Any] = arrayobj.array_reshape


def transpose(context: Any, builder: ir.IRBuilder, sig: Any, args: Any) -> Any:
    """`x.transpose(axes)` without numba's arrays of shape and strides; LLVM knows most axes."""
    source = arrayobj.make_array(sig.args[0])(context, builder, args[0])
    given, kinds = list(args[1:]), list(sig.args[1:])
    if isinstance(kinds[0], types.BaseTuple):
        given, kinds = cgutils.unpack_tuple(builder, args[1]), list(kinds[0])
    sizes = cgutils.unpack_tuple(builder, source.shape)
    axes = [context.cast(builder, *one, types.intp) for one in zip(given, kinds, strict=True)]
    _demand_axes(context, builder, axes, len(sizes))
    strides = cgutils.unpack_tuple(builder, source.strides)
    result = arrayobj.make_array(sig.return_type)(context, builder)
    arrayobj.populate_array(
        result,
        data=source.data,
        shape=[_at(builder, sizes, axis) for axis in axes],
        strides=[_at(builder, strides, axis) for axis in axes],
        itemsize=source.itemsize,
        meminfo=source.meminfo,
        parent=source.parent,
    )
    return result._getvalue()


def _demand_axes(context: Any, builder: ir.IRBuilder, axes: list[Any], ndim: int) -> None:
    """Raise what numba does unless each axis is there, once; as numba it compares them as given."""
    for number, axis in enumerate(axes):
        outside = builder.or_(
            builder.icmp_signed("<", axis, _I64(-ndim)), builder.icmp_signed(">=", axis, _I64(ndim))
        )
        again = [builder.icmp_signed("==", axis, other) for other in axes[:number]]
        for wrong, text in (
            *((one, "repeated axis in transpose") for one in again),
            (outside, "axis is out of bounds for array of given dimension"),
        ):
            with cgutils.if_unlikely(builder, wrong):
                context.call_conv.return_user_exc(builder, ValueError, (text,))


def _at(builder: ir.IRBuilder, items: list[Any], index: Any) -> Any:
    """The item at an index that may count from the end."""
    found = items[0]
    for place, item in enumerate(items[1:], 1):
        from_end = builder.icmp_signed("==", index, _I64(place - len(items)))
        is_here = builder.or_(from_end, builder.icmp_signed("==", index, _I64(place)))
        found = builder.select(is_here, item, found)
    return found


_overload: Callable[..., Callable[..., Any]] = functools.partial(overload, target="vividc")


@_overload(arrayobj.raise_with_shape_context)
def _overload_raise_with_shape_context(src_shapes: Any, index_shape: Any) -> Any:
    """Without the sizes: to write them, numba compiles strings, in vain, for every such slice."""
    return _raise_other_size


def _raise_other_size(src_shapes: Any, index_shape: Any) -> Any:
    raise ValueError("cannot assign slice from input of different size")


def broadcast_onto(builder: ir.IRBuilder, args: Any) -> Any:
    """Numba's `_broadcast_onto` without its loop: the shape of one operand joins the result's.

    The numbers of dimensions are constants. The result is less than 1 if the shapes do not fit.
    """
    count, shape, result_count, result = args
    ones = ir.Constant(_I64, 1)
    wrong: Any = ir.Constant(ir.IntType(1), 0)
    first = result_count.constant - count.constant
    for axis in range(count.constant):
        place = cgutils.gep_inbounds(builder, result, first + axis)
        size = builder.load(cgutils.gep_inbounds(builder, shape, axis))
        before = builder.load(place)
        is_open = builder.icmp_signed("==", before, ones)
        differs = builder.icmp_signed("!=", size, before)
        differs = builder.and_(differs, builder.icmp_signed("!=", size, ones))
        wrong = builder.or_(wrong, builder.and_(builder.not_(is_open), differs))
        builder.store(builder.select(is_open, size, before), place)
    return builder.select(wrong, _I64(-1), result_count)


def _product(builder: ir.IRBuilder, values: list[Any]) -> Any:
    result: Any = _I64(1)
    for value in values:
        result = builder.mul(result, value)
    return result


def _is_zero(builder: ir.IRBuilder, value: Any) -> Any:
    return builder.icmp_signed("==", value, _I64(0))


def constant_array(context: Any, builder: ir.IRBuilder, typ: Any, array: Any) -> Any:
    """A constant array: one global of whole elements, the same in every module that reads it.

    Elements of an array in Fortran order lie in that order, as numba's code for its type expects;
    those of any other lie row by row.
    """
    order: Literal["C", "F"] = "F" if typ.layout == "F" else "C"
    flat = np.asarray(array).flatten(order)
    itemsize = flat.itemsize
    element = context.get_data_type(typ.dtype)
    if isinstance(typ.dtype, types.Complex):
        flat, element = flat.view(flat.real.dtype), element.elements[0]
    if not isinstance(element, ir.IntType | ir.FloatType | ir.DoubleType):
        kinds = {types.Record: "structures", types.UnicodeCharSeq: "strings"}
        kind = kinds.get(type(typ.dtype), typ.dtype)
        hint = "constant arrays hold bool, integers or floats; of a structure, one for each field"
        raise errors.NumbaValueError(f"{MISUSE}a constant array of {kind}: {hint}")
    digest = hashlib.sha256(f"{flat.dtype} {flat.size} ".encode() + flat.tobytes()).hexdigest()
    symbol = f"{TABLE}{flat.dtype.str[1:]} {digest[:_DIGEST]}"
    data = builder.module.globals.get(symbol)
    if data is None:
        type_ = ir.ArrayType(element, flat.size)
        data = ir.GlobalVariable(builder.module, type_, symbol)
        data.linkage = "linkonce_odr"
        data.global_constant = True
        data.initializer = ir.Constant(type_, [element(_plain(item)) for item in flat.tolist()])
    result = arrayobj.make_array(typ)(context, builder)
    packed = np.empty(array.shape, array.dtype, order)
    arrayobj.populate_array(
        result,
        data=builder.bitcast(data, context.get_data_type(typ.dtype).as_pointer()),
        shape=[context.get_constant(types.intp, size) for size in array.shape],
        strides=[context.get_constant(types.intp, stride) for stride in packed.strides],
        itemsize=context.get_constant(types.intp, itemsize),
        meminfo=None,
    )
    return result._getvalue()


def _plain(item: Any) -> Any:
    """llvmlite writes a bool as an i1, whatever its type."""
    return int(item) if isinstance(item, bool) else item


def pick(context: Any, builder: ir.IRBuilder, sig: Any, args: Any) -> Any:
    """An element of a homogeneous tuple, by a variable index."""
    tuple_, index = args
    count = sig.args[0].count
    element = context.get_value_type(sig.args[0].dtype)
    if count == 0 or not _is_plain(element):
        return _getitem_unituple(context, builder, sig, args)
    if index.type != _I32:  # as an array's index: any other is outside
        index = builder.trunc(index, _I32)
    from_end = builder.add(index, _I32(count))
    negative = builder.icmp_signed("<", index, _I32(0))
    index = builder.select(negative, from_end, index)
    with cgutils.if_unlikely(builder, builder.icmp_unsigned(">=", index, _I32(count))):
        trap(builder, IndexError, "tuple index out of range")
    items = [builder.extract_value(tuple_, position) for position in range(count)]
    return _pick_leaves(builder, index, items)


_getitem_unituple: Callable[..., Any] = tupleobj.getitem_unituple


def _is_plain(element: Any) -> bool:
    if isinstance(element, ir.ArrayType):
        return _is_plain(element.element)
    return isinstance(element, (ir.IntType, ir.FloatType, ir.DoubleType))


def _pick_leaves(builder: ir.IRBuilder, index: Any, items: list[Any]) -> Any:
    """A call of `PICK` for every scalar of the element."""
    type_ = items[0].type
    if isinstance(type_, ir.ArrayType):
        result: Any = ir.Constant(type_, ir.Undefined)
        for position in range(type_.count):
            parts = [builder.extract_value(item, position) for item in items]
            leaf = _pick_leaves(builder, index, parts)
            result = builder.insert_value(result, leaf, position)
        return result
    signature = ir.FunctionType(type_, [_I32, *(item.type for item in items)])
    symbol = f"{PICK}{type_} {len(items)}"
    callee = cgutils.get_or_insert_function(builder.module, signature, symbol)
    callee.attributes.add("nounwind")
    callee.attributes.add("readnone")
    return builder.call(callee, (index, *items))


def ask_later(
    context: Any, builder: ir.IRBuilder, a_start: Any, a_end: Any, b_start: Any, b_end: Any
) -> Any:
    """Numba's `extents_may_overlap`, as a call that `fold_overlaps` answers."""
    signature = ir.FunctionType(ir.IntType(1), (a_start.type, b_start.type))
    callee = cgutils.get_or_insert_function(builder.module, signature, OVERLAP)
    callee.attributes.add("nounwind")
    callee.attributes.add("readnone")
    return builder.call(callee, (a_start, b_start))

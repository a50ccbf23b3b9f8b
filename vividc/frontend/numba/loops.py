"""The loops of ufuncs and of array expressions: numba's, but for arrays of one shape without
broadcasting.

Along a dimension of one element an operand's index stays 0: a choice in every iteration, for which
no loop is affine. Where all operands have the result's shape, which the launch knows at the latest,
a nest without such choices runs instead. LLVM drops the other one where shapes are the same values.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.np import npyimpl

from vividc.frontend.numba.assign import deferral


def ufunc_loops(
    context: Any, builder: ir.IRBuilder, sig: Any, args: Any, ufunc: Any, kernel_class: Any
) -> Any:
    """Numba's `numpy_ufunc_kernel`; of an expression that is assigned later, nothing yet."""
    later = deferral.get()
    if later is not None and not later.taken and isinstance(sig.return_type, types.Array):

        def run(view: Any, kind: Any) -> None:
            into = kind(*sig.args, kind)
            _run(context, builder, into, [*args, view], ufunc, kernel_class)

        later.taken.append(run)
        return ir.Constant(context.get_value_type(sig.return_type), ir.Undefined)
    return _run(context, builder, sig, args, ufunc, kernel_class)


def _run(
    context: Any, builder: ir.IRBuilder, sig: Any, args: Any, ufunc: Any, kernel_class: Any
) -> Any:
    operands = [
        npyimpl._prepare_argument(context, builder, arg, kind)
        for arg, kind in zip(args, sig.args, strict=True)
    ]
    inputs, results = operands[: ufunc.nin], operands[ufunc.nin :]
    is_given = bool(results)
    for kind in npyimpl._unpack_output_types(ufunc, sig)[len(results) :]:
        results.append(_result(context, builder, kind, sig, operands))
    outer = npyimpl._ufunc_loop_sig([r.base_type for r in results], [i.base_type for i in inputs])
    kernel = kernel_class(context, builder, outer)

    def nest(is_plain: bool) -> None:
        _nest(builder, inputs, results, kernel, ufunc, is_plain)

    plain = _have_shape(builder, inputs, results[0].shape)
    arrays = sum(isinstance(one, npyimpl._ArrayHelper) for one in inputs)
    if plain is None:
        nest(True)
    elif arrays > 1 and not is_given:  # two nests beside one for each use take many contexts
        nest(False)
    else:
        with builder.if_else(plain) as (then, otherwise):
            with then:
                nest(True)
            with otherwise:
                if is_given:
                    _demand_shape(context, builder, inputs, results[0].shape)
                nest(False)
    values = [result.return_val for result in results]
    return npyimpl._pack_output_values(ufunc, context, builder, sig.return_type, values)


def _result(context: Any, builder: ir.IRBuilder, kind: Any, sig: Any, operands: Any) -> Any:
    if isinstance(kind, types.ArrayCompatible):
        return npyimpl._build_array(context, builder, kind, sig.args, operands)
    nothing = ir.Constant(context.get_value_type(kind), None)
    return npyimpl._prepare_argument(context, builder, nothing, kind)


def _have_shape(builder: ir.IRBuilder, inputs: Sequence[Any], shape: Sequence[Any]) -> Any:
    """Whether all arrays have the last sizes of this shape; None: there is nothing to ask."""
    pairs = [
        (size, other)
        for one in inputs
        if isinstance(one, npyimpl._ArrayHelper)
        for size, other in zip(one.shape, shape[len(shape) - one.ndim :], strict=True)
        if size is not other
    ]
    found: Any = None
    for size, other in pairs:
        same = builder.icmp_signed("==", size, other)
        found = same if found is None else builder.and_(found, same)
    return found


def _demand_shape(
    context: Any, builder: ir.IRBuilder, inputs: Sequence[Any], shape: Sequence[Any]
) -> None:
    """Raise what numba does unless all arrays are this large or have one element, by dimension."""
    for one in inputs:
        own = getattr(one, "ndim", 0)
        for size, other in zip(one.shape[:own], shape[len(shape) - own :], strict=True):
            differs = builder.icmp_signed("!=", size, other)
            wrong = builder.and_(differs, builder.icmp_signed("!=", size, size.type(1)))
            with cgutils.if_unlikely(builder, wrong):
                text = "cannot assign slice from input of different size"
                context.call_conv.return_user_exc(builder, ValueError, (text,))


def _nest(
    builder: ir.IRBuilder,
    inputs: Sequence[Any],
    results: Sequence[Any],
    kernel: Any,
    ufunc: Any,
    is_plain: bool,
) -> None:
    """The loops over the result's elements, in the order of most operands' rows."""
    layouts = [one.layout for one in inputs if isinstance(one, npyimpl._ArrayHelper)]
    order = "F" if layouts.count("F") > layouts.count("C") else "C"
    shape = results[0].shape
    places = [] if is_plain else [one.create_iter_indices() for one in inputs]
    with cgutils.loop_nest(builder, shape, intp=ir.IntType(64), order=order) as counters:
        values = []
        for number, one in enumerate(inputs):
            if is_plain:
                own = getattr(one, "ndim", 0)
                values.append(one.load_data(list(counters[len(counters) - own :])))
                continue
            places[number].update_indices(counters, number)
            values.append(one.load_data(places[number].as_values()))
        made = npyimpl._unpack_output_values(ufunc, builder, kernel.generate(*values))
        for value, result in zip(made, results, strict=True):
            result.store_data(counters, value)

"""The loops of ufuncs and of array expressions: numba's, but for arrays of one shape without
broadcasting.

Along a dimension of one element an operand's index stays 0: a choice in every iteration, for which
no loop is affine. Where all operands have the result's shape, which the launch knows at the latest,
a nest without such choices runs instead. LLVM drops the other one where shapes are the same values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.np import npyimpl

from vividc.frontend.numba.expressions.assign import deferral
from vividc.frontend.numba.expressions.numbers import value
from vividc.frontend.numba.expressions.views import View, operands


def ufunc_loops(
    context: Any, builder: ir.IRBuilder, sig: Any, args: Any, ufunc: Any, kernel_class: Any
) -> Any:
    """Numba's `numpy_ufunc_kernel`; of an expression that is assigned later, nothing yet."""
    later, views = deferral.get(), list(operands.get() or ())
    if not isinstance(sig.return_type, types.Array) or len(views) > len(args):
        views = []
    views += [None] * (len(args) - len(views))
    if later is not None and not later.taken and isinstance(sig.return_type, types.Array):

        def run(part: Any, kind: Any, selected: View | None) -> None:
            into, given = kind(*sig.args, kind), [*args, part]
            _run(context, builder, into, given, ufunc, kernel_class, [*views, selected])

        later.taken.append(run)
        return ir.Constant(context.get_value_type(sig.return_type), ir.Undefined)
    return _run(context, builder, sig, args, ufunc, kernel_class, views)


def copied(
    context: Any, builder: ir.IRBuilder, given: Any, kind: Any, view: View | None
) -> Callable[[Any, Any, View | None], None]:
    """The loops that store an array or a number to a part of an array."""

    def run(part: Any, into: Any, selected: View | None) -> None:
        _run(context, builder, into(kind, into), [given, part], _COPY, _Cast, [view, selected])

    return run


class _Cast(npyimpl._Kernel):  # type: ignore[misc]
    """Stores what it loads."""

    def generate(self, *args: Any) -> Any:
        """An element of the type that the part has."""
        return self.cast(args[0], self.outer_sig.args[0], self.outer_sig.return_type)


_COPY = SimpleNamespace(nin=1, nout=1)


class _Viewed(npyimpl._ArrayHelper):  # type: ignore[misc]
    """An operand of which it is known where its elements lie in its array (`of`)."""

    of: View

    def _load_effective_address(self, indices: list[Any]) -> Any:
        return self.of.pointer(self.context, self.builder, indices)


def _operand(context: Any, builder: ir.IRBuilder, arg: Any, kind: Any, view: View | None) -> Any:
    plain = npyimpl._prepare_argument(context, builder, arg, kind)
    if view is None or not isinstance(plain, npyimpl._ArrayHelper):
        return plain
    viewed = _Viewed(*plain._replace(shape=[value(size) for size in view.shape]))
    viewed.of = view
    return viewed


def _run(
    context: Any,
    builder: ir.IRBuilder,
    sig: Any,
    args: Any,
    ufunc: Any,
    kernel_class: Any,
    views: list[View | None],
) -> Any:
    given = [_operand(context, builder, *one) for one in zip(args, sig.args, views, strict=True)]
    inputs, results = given[: ufunc.nin], given[ufunc.nin :]
    is_given = bool(results)
    for kind in npyimpl._unpack_output_types(ufunc, sig)[len(results) :]:
        results.append(_result(context, builder, kind, sig, given))
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


def _result(context: Any, builder: ir.IRBuilder, kind: Any, sig: Any, given: Any) -> Any:
    if isinstance(kind, types.ArrayCompatible):
        return npyimpl._build_array(context, builder, kind, sig.args, given)
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

"""Contradictions in a program that was read from a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from vividc.machine.parallel import is_well_formed
from vividc.machine.params import HIGH_SUFFIX, WIDE_DTYPES, DType, Param, is_formula
from vividc.machine.product import Product
from vividc.program.program import Program
from vividc.program.reloads import most_contexts
from vividc.program.tables import RegionRow
from vividc.ssa.ir import pitch_of

_MOST_WORDS: Final = 10_000
"""Numbers of what a program returns."""


def faults(program: Program) -> Iterator[str]:
    """What would let a run leave the tables, and other contradictions; decoding `entries` checks
    the words themselves.
    """
    contexts, rows = program.words.shape[0], len(program.table)
    if contexts > most_contexts(program.fabric) or not rows:
        yield f"{contexts} contexts and {rows} regions do not fit the fabric"
    if len(program.regions) != rows:
        yield "its reports and its region table differ in length"
    for index, row in enumerate(program.table):
        yield from _row_faults(index, row, contexts, rows)
        if row.ii > program.fabric.controller.contexts:
            yield f"region {index} is longer than the configuration memory"
    yield from _store_faults(program)
    unknown = {item.key for item in program.launch} - _input_keys(program)
    unknown -= {f"&{local.name}" for local in program.locals}
    unknown -= frozenset() if program.parallel is None else program.parallel.input_keys
    if not all(map(_may_be_known, program.params)):
        yield "the sizes that it serves do not fit its parameters"
    if unknown:
        yield f"it is launched with {min(unknown)!r}, which is no input of its parameters"
    if (program.returns is None) is not (program.return_home is None):
        yield "its return type and its return value disagree"
    if program.return_high is not None and program.returns not in WIDE_DTYPES:
        yield "its return value has more words than its return type"
    yield from _result_faults(program)
    yield from _parallel_faults(program)
    yield from _product_faults(program)
    yield from _nest_faults(program)
    if len(program.entries) != contexts:
        yield "its configuration memory is incomplete"


def _result_faults(program: Program) -> Iterator[str]:
    """Arrays that the launch makes and what is returned of them, by numbers that there are."""
    keys = _input_keys(program)
    made = [param for param in program.params if param.made]
    if any(not (param.flat and param.ndim == 1) for param in made) or not all(
        is_formula(param.made, keys) for param in made
    ):
        yield "an array that it returns has no size"
    results = program.results
    if results is None:
        if made:
            yield "it makes arrays and does not return them"
        return
    arrays = {param.name: param for param in program.params if param.ndim}
    words = arrays.get(results.words)
    if results.words:
        if words is None or len(words.made) != 1 or words.dtype is not DType.I32:
            yield "what it returns has no numbers"
            return
        count = words.made[0]
        keys |= {f"{results.words}.{number}" for number in range(min(int(count), _MOST_WORDS))}
    if (results.error not in results.made) is bool(results.error):
        yield "it raises by no array"
    leaves = results.leaves
    if set(results.made) != {param.name for param in made}:
        yield "it returns other arrays than it makes"
    if not results.is_sound or not all(
        leaf.is_sound and arrays.keys() >= set(leaf.arrays) for leaf in leaves
    ):
        yield "what it returns is not made of its arrays"
    if not all(is_formula(number, keys) for leaf in leaves for number in leaf.formulas):
        yield "a number of what it returns is none of a launch"


def _parallel_faults(program: Program) -> Iterator[str]:
    """A table whose rows refer to earlier rows, and arrays that there are."""
    parallel = program.parallel
    if parallel is None:
        return
    arrays = {param.name for param in program.params if param.ndim}
    count = len(parallel.terms)
    used = [parallel.first, parallel.last, *(item.start for item in parallel.reductions)]
    used += [access.term for access in parallel.accesses]
    used += [term for access in parallel.accesses for term in access.counters or ()]
    used += [term for one in parallel.beside for term in (one.first, one.last)]
    in_table = all(0 <= number < count for number in used)
    if not in_table or not is_well_formed(parallel.terms):
        yield "its description of the parallel loop is not in order"
    arrays |= {local.name for local in program.locals if local.contents is None}
    if not arrays.issuperset(
        {*parallel.sliced, *parallel.alike, *(one.array for one in parallel.accesses)}
    ):
        yield "its parallel loop uses an array that it has not"
    if parallel.result is not None and not 0 <= parallel.result < len(parallel.reductions):
        yield "it returns a reduction that it has not"


def _product_faults(program: Program) -> Iterator[str]:
    """What the description of matrix products names must be there."""
    products = program.products
    if products is None:
        return
    keys = _input_keys(program)
    ndims = {param.name: param.ndim for param in program.params if param.dtype is DType.F32}
    if any(key not in keys for size in products.sizes for key, _ in size.terms):
        yield "its matrix products have a size that is no input"
    if any(ndims.get(name) != 2 for name, _ in products.strides):  # noqa: PLR2004 - matrices
        yield "rows of its matrix products are not those of matrices that it has"
    for step in products.steps:
        views = (step.result, *step.views)
        if any(ndims.get(view.array) != len(view.axes) for view in views):
            yield "its matrix products are not of arrays that it has"
        if len(step.ranges) != (3 if isinstance(step, Product) else 2):
            yield "a matrix product of its has too many coordinates, or too few"
        if any(axis.coordinate >= len(step.ranges) for view in views for axis in view.axes):
            yield "a matrix product of its has a coordinate that it has not"
        if not keys.issuperset(key for term in step.terms for key in term.keys):
            yield "its matrix products use a scalar that is no input"
        if not all(term.is_sound for term in step.terms):
            yield "an expression of its matrix products is not one that tiles compute"


def _nest_faults(program: Program) -> Iterator[str]:
    """Nests are of the same parameters, and have no nests of their own."""
    order = program.order
    if order is None:
        if program.nests:
            yield "nothing says in which order its nests run"
        return
    if not is_well_formed(order.terms) or not order.is_of(len(program.nests)):
        yield "the order of its nests is not one"
    for nest in program.nests:
        if nest.order is not None or nest.parallel is None or nest.params != program.params:
            yield "one of its nests is none"
        elif not order.keys.issuperset(nest.parallel.around):
            yield "one of its nests counts what nobody counts"


def _store_faults(program: Program) -> Iterator[str]:
    """What is wrong with the entries of constant stores and the layout of arrays."""
    homes = [(item.pe, item.entry) for item in program.launch]
    for home in (program.return_home, program.return_high):
        if home is not None:
            homes.append((home.pe, home.entry))
    for pe, entry in homes:
        if not 0 <= pe < len(program.fabric.pes) or not (
            0 <= entry < program.fabric.pes[pe].constants
        ):
            yield f"constant-store entry {entry} of PE {pe} does not exist"
    arrays = {param.name for param in program.params if param.ndim}
    arrays |= {local.name for local in program.locals}
    if set(program.banks) != arrays or any(
        not 0 <= bank < program.fabric.scratchpad.banks for bank in program.banks.values()
    ):
        yield "its memory layout does not fit its parameters"
    banks = program.fabric.scratchpad.banks
    around = {p.name: p.per_word * banks for p in program.params if p.ndim == 2}  # noqa: PLR2004
    if any(not 0 <= pitch < around.get(name, 0) for name, pitch in program.pitches.items()):
        yield "the pitches of its matrices do not fit its parameters"
    if any(local.words < len(local.contents or ()) for local in program.locals):
        yield "its constant tables are larger than their places"


def _input_keys(program: Program) -> set[str]:
    params = program.params
    keys = {param.name for param in params if not param.ndim}
    keys |= {param.name + HIGH_SUFFIX for param in params if param.words > 1}
    for param in params:
        if param.name in program.pitches:
            keys.add(pitch_of(param.name, 1).key)
        if param.ndim:
            keys |= {f"&{param.name}", *(f"{param.name}.shape{k}" for k in range(param.ndim))}
    return keys


def _may_be_known(param: Param) -> bool:
    if not param.known:
        return True
    if not param.ndim:
        return len(param.known) == 1 and not (param.dtype.is_float or param.dtype is DType.BOOL)
    return len(param.known) == param.ndim and not param.flat and min(param.known) >= 0


def _row_faults(index: int, row: RegionRow, contexts: int, rows: int) -> Iterator[str]:
    targets = [target for target in (row.next, row.branch) if target is not None]
    if row.ii < 1 or row.context < 0 or row.context + row.ii > contexts:
        yield f"region {index} lies outside the configuration memory"
    if row.span < 1 or row.stages < 1 or (row.kind == "straight" and row.span != row.ii):
        yield f"region {index} has an impossible span"
    if any(not 0 <= target < rows for target in targets):
        yield f"region {index} continues at a region that does not exist"
    if not (0 <= row.drain <= row.span and 0 <= row.fill <= row.ii):
        yield f"region {index} overlaps others for longer than it takes"
    if row.kind == "loop" and not (row.counted or row.has_exit):
        yield f"region {index} never ends"

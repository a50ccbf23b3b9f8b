"""A compiled program: configuration words and tables, all that a run on the fabric needs."""

from __future__ import annotations

import os
from collections.abc import Iterator
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.arch import load_text
from vividc.arch.fabric import Fabric
from vividc.errors import BundleError, VividcError, demand_type
from vividc.host.html import table
from vividc.machine.parallel import Order, Parallel, is_well_formed
from vividc.machine.params import HIGH_SUFFIX, WIDE_DTYPES, DType, LocalArray, Param
from vividc.machine.product import Product, Products
from vividc.program.bundle import (
    NESTED,
    SCHEMA,
    SIZED,
    BundleReader,
    Manifest,
    bundle_bytes,
    write_bundle,
)
from vividc.program.tables import (
    DebugRow,
    Home,
    LaunchRow,
    LoopReport,
    Provenance,
    RegionReport,
    RegionRow,
)
from vividc.program.words.decode import decode
from vividc.program.words.entry import Entry
from vividc.program.words.layout import OPCODE_NUMBERS, word_layout
from vividc.ssa.ir import pitch_of

CUT_SHORT: Final = (
    "was cut short by the clock; on an idle machine, or with a longer --time-limit, the program "
    "may be another"
)
"""In a program's warnings, where the time limit has ended something."""


@dataclass(frozen=True, eq=False)
class Program:
    """Everything the hardware and the host need to run a kernel, and where it came from.

    Attributes
    ----------
    params, returns
        The Python function's signature.
    words
        Configuration memory: uint32, [contexts, PEs, words per entry].
    table
        The tile controller's region table; row 0 runs first.
    images, images_set
        Initial words of the constant stores (uint32) and which entries they set (bool), both [PEs,
        entries of the largest store].
    launch
        Constant-store entries the host writes at launch.
    return_home, return_high
        Entries that hold the returned scalar at the end, and the high word of one of two words.
    banks
        Bank in which each array should start, so that the hot loops' accesses meet in no bank.
    pitches
        How far apart the rows of a matrix should lie at least, in words modulo the banks; of those
        whose launch words have a pitch besides their shape.
    debug
        What each configuration entry was made from.
    regions
        What the compiler achieved and proved, one report per row of `table`.
    locals
        Arrays of the kernel's own, which lie in the scratchpad behind the arguments.
    loops
        What became of the loops of the source, innermost first (`vividc compile --explain`).
    parallel
        The loop that a launch spreads over the tiles of an accelerator, if there is one.
    products
        The matrix products that the kernel is made of, if it is: an accelerator may run it in a
        TPU-like mode instead.
    nests, order
        The kernel as programs of a nest of loops each, blocks of which a launch gives to tiles, and
        how the nests follow each other; none if it is no such sequence.
    accelerator
        YAML text of the accelerator that it was compiled for, where it runs unless a launch says
        otherwise; "" if that was one tile.
    """

    name: str
    params: tuple[Param, ...]
    returns: DType | None
    fabric: Fabric
    words: NDArray[np.uint32]
    table: tuple[RegionRow, ...]
    images: NDArray[np.uint32]
    images_set: NDArray[np.bool_]
    launch: tuple[LaunchRow, ...]
    return_home: Home | None
    return_high: Home | None
    banks: ReadOnly[str, int]
    debug: tuple[DebugRow, ...]
    regions: tuple[RegionReport, ...]
    provenance: Provenance
    warnings: tuple[str, ...] = ()
    locals: tuple[LocalArray, ...] = ()
    loops: tuple[LoopReport, ...] = ()
    parallel: Parallel | None = None
    products: Products | None = None
    pitches: ReadOnly[str, int] = field(default_factory=dict)
    nests: tuple[Program, ...] = ()
    order: Order | None = None
    accelerator: str = ""

    def __repr__(self) -> str:
        names = ", ".join(param.name for param in self.params)
        iis = ", ".join(str(row.ii) for row in self.table if row.kind == "loop")
        loops = f"loops at II {iis}" if iis else "no loop"
        size = f"{len(self.table)} regions, {loops}, {self.words.shape[0]} contexts"
        return f"<Program {self.name}({names}) for {self.fabric.name}: {size}>"

    def _repr_html_(self) -> str:
        rows = (
            (
                *(region.name, region.kind, "" if region.loc is None else str(region.loc)),
                *(region.operations, region.ii, region.lower_bound, region.status),
                f"{region.utilization:.0%}",
            )
            for region in self.regions
        )
        header = ("region", "kind", "line", "operations", "II", "bound", "status", "FU use")
        return table(header, rows, repr(self)[1:-1])

    @property
    def fabric_name(self) -> str:
        """Name of the fabric the program is for."""
        return self.fabric.name

    @property
    def sizes(self) -> dict[str, tuple[int, ...] | int]:
        """What launches must be given, by parameter: shapes of arrays, values of integers."""
        known = (param for param in self.params if param.known)
        return {param.name: param.known if param.ndim else param.known[0] for param in known}

    @property
    def hurried(self) -> bool:
        """A time limit cut short a search that could have improved the program: on another machine,
        or under another load, the words may differ.
        """
        return any(CUT_SHORT in text for text in self.warnings)

    @cached_property
    def entries(self) -> list[list[Entry]]:
        """Decoded configuration memory, by context and PE."""
        return decode(self.fabric, self.words)

    @cached_property
    def stored_arrays(self) -> frozenset[str]:
        """Names of the arrays that some store writes."""
        return frozenset(row.name for row in self.debug if row.op == "store")

    @cached_property
    def loaded_arrays(self) -> frozenset[str]:
        """Names of the arrays that some load reads."""
        return frozenset(row.name for row in self.debug if row.op == "load")

    def debug_row(self, region: int, slot: int, pe: int, role: str) -> DebugRow | None:
        """What the operation or live-out at this place was made from."""
        return self._debug_index.get((region, slot, pe, role))

    @cached_property
    def _debug_index(self) -> dict[tuple[int, int, int, str], DebugRow]:
        return {(row.region, row.slot, row.pe, row.role): row for row in self.debug}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Program):
            return NotImplemented
        mine, theirs = _manifest(self), _manifest(other)
        arrays = zip(_arrays(self).values(), _arrays(other).values(), strict=True)
        return (mine, self.nests) == (theirs, other.nests) and all(
            np.array_equal(a, b) for a, b in arrays
        )

    __hash__ = None  # type: ignore[assignment]  # equality by content of mutable arrays

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the `.vivid` file `path`, completely or not at all; equal programs, equal bytes.

        Raises
        ------
        BundleError
            The file cannot be written, or the fabric has no YAML text to store.
        """
        hint = "give a path, as in program.save('saxpy.vivid')"
        demand_type(path, (str, os.PathLike), "the file", hint)
        if not self.fabric.source:
            raise BundleError(
                f"the fabric {self.fabric.name} has no YAML text to store",
                loc=os.fspath(path),
                hint="build the fabric with vividc.arch.load or load_text",
            )
        write_bundle(Path(path), _manifest(self), _arrays(self), _nests(self))

    def to_bytes(self) -> bytes:
        """What `save` writes for a program whose fabric has YAML text."""
        return bundle_bytes(_manifest(self), _arrays(self), _nests(self))


def load(path: str | os.PathLike[str]) -> Program:
    """Read a `.vivid` file. Nothing in the file is executed.

    Raises
    ------
    BundleError
        The file is missing, damaged, of another version, or inconsistent; it names the path.
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    return _read(BundleReader(Path(path)))


def from_bytes(data: bytes) -> Program:
    """Read what `Program.to_bytes` gave.

    Raises
    ------
    BundleError
        It is damaged, of another version, or inconsistent.
    """
    return _read(BundleReader(Path("kept program"), data))


def _read(bundle: BundleReader) -> Program:
    with bundle as reader:
        manifest = reader.manifest()
        program = _assemble(reader, manifest)
        for fault in _faults(program):
            raise BundleError(fault)
        return program


def _read_nests(reader: BundleReader, manifest: Manifest) -> tuple[Program, ...]:
    nests = []
    for number, data in enumerate(reader.nests(manifest.nests)):
        inner = BundleReader(Path(f"{reader.path}, nest {number}"), data)
        with inner as opened:
            if opened.manifest().nests:  # one in another, and so on, would be read without end
                raise BundleError("a nest of it has nests of its own")
        nests.append(_read(inner))
    return tuple(nests)


def _manifest(program: Program) -> Manifest:
    return Manifest(
        schema=_schema(program),
        opcodes=_opcode_names(),
        name=program.name,
        params=program.params,
        returns=program.returns,
        fabric_name=program.fabric.name,
        fabric=program.fabric.source,
        contexts=program.words.shape[0],
        table=program.table,
        launch=program.launch,
        return_home=program.return_home,
        return_high=program.return_high,
        banks=dict(program.banks),
        pitches=dict(program.pitches),
        nests=len(program.nests),
        order=program.order,
        accelerator=program.accelerator,
        debug=program.debug,
        regions=program.regions,
        provenance=program.provenance,
        warnings=program.warnings,
        locals=program.locals,
        loops=program.loops,
        parallel=program.parallel,
        products=program.products,
    )


def _schema(program: Program) -> str:
    """The oldest whose readers understand all of it."""
    if program.nests:
        return NESTED
    return SIZED if any(param.known for param in program.params) else SCHEMA


def _arrays(program: Program) -> dict[str, NDArray[np.generic]]:
    return {
        "words": program.words,
        "images": program.images,
        "images_set": program.images_set,
    }


def _nests(program: Program) -> tuple[bytes, ...]:
    return tuple(nest.to_bytes() for nest in program.nests)


def _opcode_names() -> tuple[str, ...]:
    return tuple("" if op is None else op.value for op in OPCODE_NUMBERS)


def _assemble(reader: BundleReader, manifest: Manifest) -> Program:
    if manifest.opcodes != _opcode_names():
        raise BundleError(
            "the program was made with another opcode table",
            hint="compile the kernel again with this version",
        )
    try:
        fabric = load_text(manifest.fabric, str(reader.path))
    except VividcError as error:
        raise BundleError(f"its fabric cannot be read: {error.reason}") from error
    pes = len(fabric.pes)
    words = (manifest.contexts, pes, word_layout(fabric).words_per_entry)
    images = (pes, max(pe.constants for pe in fabric.pes))
    return Program(
        name=manifest.name,
        params=manifest.params,
        returns=manifest.returns,
        fabric=fabric,
        words=reader.array("words", np.dtype(np.uint32), words),
        table=manifest.table,
        images=reader.array("images", np.dtype(np.uint32), images),
        images_set=reader.array("images_set", np.dtype(np.bool_), images),
        launch=manifest.launch,
        return_home=manifest.return_home,
        return_high=manifest.return_high,
        banks=manifest.banks,
        pitches=manifest.pitches,
        nests=_read_nests(reader, manifest),
        order=manifest.order,
        accelerator=manifest.accelerator,
        debug=manifest.debug,
        regions=tuple(replace(row, fabric_yaml=manifest.fabric) for row in manifest.regions),
        provenance=manifest.provenance,
        warnings=manifest.warnings,
        locals=manifest.locals,
        loops=manifest.loops,
        parallel=manifest.parallel,
        products=manifest.products,
    )


def _faults(program: Program) -> Iterator[str]:
    """What would let a run leave the tables; decoding `entries` checks the words themselves."""
    contexts, rows = program.words.shape[0], len(program.table)
    if contexts > program.fabric.controller.contexts or not rows:
        yield f"{contexts} contexts and {rows} regions do not fit the fabric"
    if len(program.regions) != rows:
        yield "its reports and its region table differ in length"
    for index, row in enumerate(program.table):
        yield from _row_faults(index, row, contexts, rows)
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
    yield from _parallel_faults(program)
    yield from _product_faults(program)
    yield from _nest_faults(program)
    if len(program.entries) != contexts:
        yield "its configuration memory is incomplete"


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
    in_table = all(0 <= number < count for number in used)
    if not in_table or not is_well_formed(parallel.terms):
        yield "its description of the parallel loop is not in order"
    if any(access.array not in arrays for access in parallel.accesses):
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
    matrices = {param.name for param in program.params if param.ndim == 2}  # noqa: PLR2004
    if not matrices.issuperset(program.pitches) or any(
        not 0 <= pitch < program.fabric.scratchpad.banks for pitch in program.pitches.values()
    ):
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
        return len(param.known) == 1 and param.dtype not in (DType.F32, DType.BOOL)
    return len(param.known) == param.ndim and not param.flat and min(param.known) >= 0


def _row_faults(index: int, row: RegionRow, contexts: int, rows: int) -> Iterator[str]:
    targets = [target for target in (row.next, row.branch) if target is not None]
    if row.ii < 1 or row.context < 0 or row.context + row.ii > contexts:
        yield f"region {index} lies outside the configuration memory"
    if row.span < 1 or row.stages < 1 or (row.kind == "straight" and row.span != row.ii):
        yield f"region {index} has an impossible span"
    if any(not 0 <= target < rows for target in targets):
        yield f"region {index} continues at a region that does not exist"
    if row.kind == "loop" and not (row.counted or row.has_exit):
        yield f"region {index} never ends"

"""A compiled program: configuration words and tables, all that a run on the fabric needs."""

from __future__ import annotations

import os
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.arch.fabric import Fabric
from vividc.errors import BundleError, demand_type
from vividc.host.html import table
from vividc.machine.parallel import Order, Parallel
from vividc.machine.params import DType, LocalArray, Param, given
from vividc.machine.product import Products
from vividc.program.bundle import (
    DRAINING,
    FILLING,
    NESTED,
    RELOADING,
    RETURNING,
    SAYING,
    SCHEMA,
    SIZED,
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
from vividc.program.words.layout import OPCODE_NUMBERS
from vividc.ssa.results import LIST, Results

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
        How far apart the rows of a matrix should lie at least, in elements modulo those that all
        banks hold; of those whose launch words have a pitch besides their shape.
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
    results
        The arrays and tuples that it returns, if it does.
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
    results: Results | None = None

    def __repr__(self) -> str:
        names = ", ".join(param.name for param in given(self.params))
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


def _manifest(program: Program) -> Manifest:
    return Manifest(
        schema=_schema(program),
        opcodes=opcode_names(),
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
        results=program.results,
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
    results = program.results
    needed = {
        SAYING: results is not None and bool(results.raises or LIST in results.form),
        RELOADING: len(program.words) > program.fabric.controller.contexts,
        FILLING: any(row.fill for row in program.table),
        DRAINING: any(row.drain for row in program.table),
        RETURNING: results is not None,
        NESTED: bool(program.nests),
        SIZED: any(param.known for param in program.params),
    }
    return next((schema for schema, is_needed in needed.items() if is_needed), SCHEMA)


def _arrays(program: Program) -> dict[str, NDArray[np.generic]]:
    return {
        "words": program.words,
        "images": program.images,
        "images_set": program.images_set,
    }


def _nests(program: Program) -> tuple[bytes, ...]:
    return tuple(nest.to_bytes() for nest in program.nests)


def opcode_names() -> tuple[str, ...]:
    return tuple("" if op is None else op.value for op in OPCODE_NUMBERS)

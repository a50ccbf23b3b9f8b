"""Encodes a kernel and the mappings of its regions as a `Program`."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from itertools import accumulate
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Control
from vividc.dfg.regions import Kernel, Region, loop_behind
from vividc.errors import InternalError, KernelError
from vividc.mapper.mapping import Mapping
from vividc.mapper.resources.banks import words_of
from vividc.mapper.resources.fu_slots import utilization
from vividc.mapper.result import MapResult
from vividc.program.design import design_text
from vividc.program.encoder.banks import choose_layout, traffic_of
from vividc.program.encoder.checks import check_region, control_node, span_of, stages_of
from vividc.program.encoder.constants import ConstantStores, allocate, return_high, return_home
from vividc.program.encoder.lower import Ahead, LoweredRegion, Rest, lower_region
from vividc.program.overlaps.parts import parts
from vividc.program.program import Program
from vividc.program.reloads import most_contexts
from vividc.program.tables import (
    BoundReport,
    Option,
    Provenance,
    RefutationReport,
    RegionReport,
    RegionRow,
)
from vividc.program.words.layout import WordLayout, word_layout
from vividc.program.words.pack import pack

_PACKAGES = ("vividc", "numba", "llvmlite", "ortools", "numpy")


def encode(
    kernel: Kernel,
    fabric: Fabric,
    mappings: ReadOnly[int, Mapping],
    *,
    reports: ReadOnly[int, MapResult] | None = None,
    options: ReadOnly[str, str | int | float | bool | None] | None = None,
    warnings: Sequence[str] = (),
    iterations: Sequence[float] = (),
    order: Sequence[int] = (),
) -> Program:
    """Configuration words and tables of a mapped kernel.

    Parameters
    ----------
    mappings
        Mapping of each region, by index. A region that places nothing needs none.
    reports
        What the mapper found and proved, by region index, for the program's reports.
    options
        The compiler's options, for the provenance.
    warnings
        Messages the compiler gave.
    iterations
        How many of each region a run is expected to have; where they are many, banks count.
    order
        Of the regions in the configuration memory, where it is not their own (`encoder.places`).

    Raises
    ------
    KernelError
        The regions together need more contexts than a program may have (`reloads`), or an address
        immediate is too large.
    InternalError
        A mapping breaks a rule of the machine (docs/machine.md), or mappings contradict each other.
    """
    mappings = {i: _mapping(i, region, mappings) for i, region in enumerate(kernel.regions)}
    for index, region in enumerate(kernel.regions):
        check_region(region, mappings[index], fabric)
    table = _table(kernel, fabric, mappings, order or range(len(kernel.regions)))
    check_contexts(kernel, fabric, sum(row.ii for row in table), most_contexts(fabric))
    _check_locals(kernel, fabric)
    rows = _reports(kernel, fabric, table, mappings, reports or {})
    traffic = traffic_of(kernel, fabric, mappings, iterations)
    pitches, banks = choose_layout(kernel, traffic)
    stalls = (one.stalls(words_of(banks, pitches)) for one in traffic)
    rows = tuple(replace(row, stalls=wait) for row, wait in zip(rows, stalls, strict=True))
    provenance = _provenance(kernel, options or {})
    program = _program(kernel, fabric, mappings, table, banks, rows, provenance)
    for fault in parts(program).faults:
        raise InternalError(f"{kernel.name}: {fault}")
    return replace(program, pitches=pitches, warnings=tuple(warnings))


def with_designs(program: Program, kernel: Kernel, results: ReadOnly[int, MapResult]) -> Program:
    """The program with each region's graph and mapping in its report, to be looked at."""
    fabric = program.fabric
    regions = (
        replace(
            report,
            design=design_text(region.dfg, results.get(index), fabric),
            fabric_yaml=fabric.source,
        )
        for index, (report, region) in enumerate(zip(program.regions, kernel.regions, strict=True))
    )
    return replace(program, regions=tuple(regions))


def _program(
    kernel: Kernel,
    fabric: Fabric,
    mappings: ReadOnly[int, Mapping],
    table: tuple[RegionRow, ...],
    banks: dict[str, int],
    regions: tuple[RegionReport, ...],
    provenance: Provenance,
) -> Program:
    """What the machine reads, words, constant stores and tables, with its reports."""
    stores = allocate(kernel, fabric, mappings)
    layout = word_layout(fabric)
    lower = partial(_lowered, kernel, fabric, mappings, table, stores, layout)
    lowered = [lower(index) for index in range(len(table))]
    images, images_set = stores.images(fabric)
    return Program(
        name=kernel.name,
        params=kernel.params,
        returns=kernel.returns,
        fabric=fabric,
        words=_words(table, lowered, fabric, layout),
        table=table,
        images=images,
        images_set=images_set,
        launch=stores.launch(),
        return_home=return_home(kernel, mappings, stores),
        return_high=return_high(kernel, mappings, stores),
        banks=banks,
        debug=tuple(row for region in lowered for row in region.debug),
        regions=regions,
        provenance=provenance,
        locals=kernel.locals,
        results=kernel.results,
    )


def _lowered(
    kernel: Kernel,
    fabric: Fabric,
    mappings: ReadOnly[int, Mapping],
    table: Sequence[RegionRow],
    stores: ConstantStores,
    layout: WordLayout,
    index: int,
) -> LoweredRegion:
    """A region, with what is left of a loop before it and what one behind it begins with."""

    def lower(number: int, beside: Sequence[Rest | Ahead] = ()) -> LoweredRegion:
        region, mapping = kernel.regions[number], mappings[number]
        return lower_region(number, region, mapping, fabric, stores, layout, beside)

    beside: list[Rest | Ahead] = [
        Rest(lower(number), row.span - row.drain, row.drain)
        for number, row in enumerate(table)
        if row.drain and row.next == index
    ]
    fill, behind = table[index].fill, loop_behind(table, index)
    if fill and behind is not None:
        beside.append(Ahead(lower(behind), fill, table[index].stages - 1))
    return lower(index, beside)


def _mapping(index: int, region: Region, mappings: ReadOnly[int, Mapping]) -> Mapping:
    if index in mappings:
        return mappings[index]
    if region.dfg.placed:
        raise InternalError(f"region {region.name} has no mapping")
    return Mapping(1, {}, {})


def _table(
    kernel: Kernel, fabric: Fabric, mappings: ReadOnly[int, Mapping], order: Sequence[int]
) -> tuple[RegionRow, ...]:
    lengths = [mappings[index].ii for index in order]
    begins = dict(zip(order, accumulate(lengths, initial=0), strict=False))
    rows = []
    for index, region in enumerate(kernel.regions):
        mapping = mappings[index]
        rows.append(
            RegionRow(
                kind=region.kind,
                context=begins[index],
                ii=mapping.ii,
                span=span_of(region, mapping, fabric),
                stages=stages_of(region, mapping),
                counted=region.counted,
                has_exit=control_node(region, Control.EXIT) is not None,
                next=region.next,
                branch=region.branch,
                drain=region.drain,
                fill=region.fill,
            )
        )
    for index, row in enumerate(rows):
        if row.drain and row.next is not None:
            times = [place.time for place in mappings[index].places.values()]
            left = max(times) - (row.span - row.drain)
            stages = left // row.ii + 2 if left >= 0 else 1
            rows[row.next] = replace(rows[row.next], stages=stages)
    for index, row in enumerate(rows):
        behind = loop_behind(rows, index) if row.fill else None
        if behind is not None:
            rows[index] = replace(row, stages=row.stages + rows[behind].begun(row.fill))
    return tuple(rows)


def check_contexts(
    kernel: Kernel, fabric: Fabric, used: int, most: int, at_least: str = ""
) -> None:
    """Refuse a kernel that needs more than `most` contexts, or `at_least` more.

    Raises
    ------
    KernelError
        It does.
    """
    if used > most:
        raise KernelError(
            f"{kernel.name} needs {at_least}{used} contexts and fabric {fabric.name} has "
            f"{fabric.controller.contexts}" + _in_all(most, fabric),
            loc=kernel.file or None,
            hint="split the kernel, unroll less, or raise `controller.contexts` of the fabric",
        )


def _in_all(most: int, fabric: Fabric) -> str:
    if most == fabric.controller.contexts:
        return ""
    return f", of which a program may have {most}"


def _check_locals(kernel: Kernel, fabric: Fabric) -> None:
    used = sum(local.words for local in kernel.locals)
    if used > fabric.scratchpad.words:
        raise KernelError(
            f"the arrays that {kernel.name} makes and its constant tables need {4 * used} bytes, "
            f"and the scratchpad of fabric {fabric.name} has {fabric.scratchpad.size_bytes}",
            loc=kernel.file or None,
            hint="make smaller arrays, or work on pieces",
        )


def _words(
    table: Sequence[RegionRow], lowered: Sequence[LoweredRegion], fabric: Fabric, layout: WordLayout
) -> NDArray[np.uint32]:
    contexts = sum(row.ii for row in table)
    words = np.zeros((contexts, len(fabric.pes), layout.words_per_entry), np.uint32)
    for row, region in zip(table, lowered, strict=True):
        for (slot, pe), entry in region.entries.items():
            words[row.context + slot, pe] = pack(layout, entry)
    return words


def _reports(
    kernel: Kernel,
    fabric: Fabric,
    table: Sequence[RegionRow],
    mappings: ReadOnly[int, Mapping],
    results: ReadOnly[int, MapResult],
) -> tuple[RegionReport, ...]:
    return tuple(
        _report(region, row, utilization(region.dfg, fabric, mappings[index]), results.get(index))
        for index, (region, row) in enumerate(zip(kernel.regions, table, strict=True))
    )


def _report(region: Region, row: RegionRow, used: float, result: MapResult | None) -> RegionReport:
    bounds = () if result is None else result.bounds
    lower_bound = 1 if result is None else result.lower_bound
    return RegionReport(
        name=region.name,
        kind=region.kind,
        ii=row.ii,
        mii=max((bound.ii for bound in bounds), default=lower_bound),
        lower_bound=lower_bound,
        status="optimal" if result is not None and result.status == "optimal" else "feasible",
        utilization=used,
        operations=len(region.dfg.operations),
        span=row.span,
        stages=row.stages,
        mapper="" if result is None else result.mapper,
        bounds=tuple(BoundReport(bound.name, bound.ii, bound.reason) for bound in bounds),
        refuted=()
        if result is None
        else tuple(RefutationReport(item.ii, item.by) for item in result.refuted),
        loc=region.loc,
        wall_s=None if result is None else result.wall_s,
    )


def _provenance(
    kernel: Kernel, options: ReadOnly[str, str | int | float | bool | None]
) -> Provenance:
    return Provenance(
        versions=tuple((package, _version(package)) for package in _PACKAGES),
        kernel_file=kernel.file,
        kernel_sha256=_sha256(kernel.file),
        options=tuple(Option(name, value) for name, value in sorted(options.items())),
    )


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def _sha256(file: str) -> str:
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest() if file else ""
    except OSError:
        return ""

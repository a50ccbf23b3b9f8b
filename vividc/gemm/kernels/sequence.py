"""A kernel's products, and what it does to each element, as one job of the accelerator.

Matrices stay in DRAM as stacks (`blocked`) from one step to the next. A product makes stacks of its
result or of the transpose, whichever the steps after it read: both, if they do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vividc.arch import Accelerator
from vividc.errors import VividcError
from vividc.gemm.blocked import (
    Operands,
    Sizes,
    Stacks,
    Tiling,
    add_product,
    stacked,
    tiled,
    unstacked,
)
from vividc.gemm.elementwise import loop_steps, term_program
from vividc.gemm.modes import Mode, array_of
from vividc.launch import Job
from vividc.machine.product import (
    COL,
    CONST,
    INNER,
    INPUT,
    LOAD,
    ROW,
    SUM,
    ZERO,
    Elementwise,
    Product,
    Products,
    Step,
    Term,
    View,
    positive_part,
)
from vividc.machine.words import float_of
from vividc.program import WORD_BYTES

Index = tuple[int | slice, ...]
_LARGEST = float(np.finfo(np.float32).max) / 4
_CONTEXTS = 4
"""Contexts of a program of one loop over elements, about."""


class Unfit(VividcError):
    """A launch whose steps the arrays cannot run."""


@dataclass(frozen=True)
class Place:
    """Elements of an array: `index` of it, with the coordinate that each of its remaining axes
    has.
    """

    array: str
    index: Index
    coordinates: tuple[int, ...]

    @property
    def key(self) -> tuple[str, str]:
        """The elements, whatever the coordinates are called."""
        return self.array, repr(self.index)

    def along(self, coordinate: int) -> int:
        """Which of its axes is a coordinate's; -1: none."""
        return self.coordinates.index(coordinate) if coordinate in self.coordinates else -1


@dataclass
class Launch:
    """Steps with the arguments of a launch.

    Attributes
    ----------
    arrays
        float32, by parameter.
    words
        Launch words by input key.
    """

    products: Products
    arrays: Mapping[str, NDArray[np.float32]]
    words: Mapping[str, int]

    def check(self) -> None:
        """Demand that the steps can be run in a TPU-like mode.

        Raises
        ------
        Unfit
            They run over what is not in their arrays, over nothing, or read a part of what another
            step has written.
        """
        for array, size in self.products.strides:
            if self.arrays[array].shape[1] != size.at(self.words):
                raise Unfit(f"{array} is not indexed by its own rows")
        written: dict[str, tuple[Place, Step | None]] = {}
        for step in self.products.steps:
            sizes = self.box(step)
            if min(limit - first for first, limit in sizes) < 1:
                raise Unfit(f"nothing to compute: the sizes are {self._told(sizes)}")
            for view in step.views:
                place = self.place(view, step)
                before, made = written.get(view.array, (place, None))
                if before.key != place.key or not _is_all_of(made, view, step):
                    raise Unfit(f"a part of {view.array} is computed, and another one is read")
            place = self.place(step.result, step)
            before, _ = written.get(place.array, (place, None))
            if before.key != place.key:
                raise Unfit(f"parts of {place.array} are computed one after the other")
            written[place.array] = place, step

    @staticmethod
    def _told(sizes: tuple[tuple[int, int], ...]) -> str:
        return ", ".join(str(limit - first) for first, limit in sizes)

    def box(self, step: Step) -> tuple[tuple[int, int], ...]:
        """First value and end of each coordinate of a step."""
        return tuple((r.first.at(self.words), r.limit.at(self.words)) for r in step.ranges)

    def sizes(self, step: Product) -> Sizes:
        """Sizes of a product."""
        return Sizes(*(limit - first for first, limit in self.box(step)))

    def place(self, view: View, step: Step) -> Place:
        """Where the elements of a view are."""
        box = self.box(step)
        shape = self.arrays[view.array].shape
        index: list[int | slice] = []
        for axis, size in zip(view.axes, shape, strict=True):
            offset = axis.offset.at(self.words)
            if axis.coordinate < 0:
                ends = [offset]
                index.append(offset)
            else:
                first, limit = box[axis.coordinate]
                ends = [axis.factor * n + offset for n in (first, limit - 1)]
                stop = ends[1] + (1 if axis.factor > 0 else -1)
                index.append(slice(ends[0], stop if stop >= 0 else None, axis.factor))
            if min(ends) < 0 or max(ends) >= size:
                text = "x".join(map(str, shape))
                raise Unfit(f"the loops run over more than {view.array}, {text}")
        coordinates = tuple(axis.coordinate for axis in view.axes if axis.coordinate >= 0)
        return Place(view.array, tuple(index), coordinates)

    def matrix(self, place: Place, first: int, second: int, step: Step) -> NDArray[np.float32]:
        """Elements as a matrix over two coordinates, with copies along those that they have not."""
        box = self.box(step)
        values = self.arrays[place.array][place.index]
        axes = [place.along(c) for c in (first, second)]
        values = values.transpose([axis for axis in axes if axis >= 0])
        for number, axis in enumerate(axes):
            if axis < 0:
                values = np.expand_dims(values, number)
        shape = [box[c][1] - box[c][0] for c in (first, second)]
        return np.broadcast_to(values, shape)

    def mask(self, step: Step) -> NDArray[np.bool_]:
        """Which elements of a step's box are computed, bool [rows, columns]."""
        rows, cols = (np.arange(*ends) for ends in self.box(step)[:INNER])
        mask = np.ones((rows.size, cols.size), np.bool_)
        for edge in step.edges:
            at = edge.row * rows[:, None] + edge.col * cols + edge.constant.at(self.words)
            mask &= at >= 0
        return mask

    def scalars(self, term: Term) -> dict[str, object]:
        """Arguments of an expression's program."""
        return {key: float_of(self.words[key]) for key in term.keys}


def _is_all_of(made: Step | None, view: View, step: Step) -> bool:
    """Whether a step that made a part of an array made all that another one reads of it."""
    if made is None or not made.edges:
        return True
    read = step.edges if view.axes == made.result.axes else step.swapped().edges
    return read == made.edges and made.result in (view, view.swapped())


@dataclass(frozen=True)
class Version:
    """A step's result as stacks of blocks along one of its coordinates."""

    step: int
    along: int


@dataclass
class Sequence:
    """The steps of a launch in a mode.

    Attributes
    ----------
    versions
        What is made, in order.
    tilings
        Of each product.
    """

    launch: Launch
    mode: Mode
    machine: Accelerator
    versions: list[Version] = field(init=False)
    tilings: dict[Version, Tiling] = field(init=False, default_factory=dict)
    _made: dict[tuple[tuple[str, str], int], tuple[Stacks, tuple[int, ...]]] = field(
        init=False, default_factory=dict
    )

    _on_arrays: tuple[int, ...] = field(init=False, default=())
    _on_tiles: tuple[int, ...] = field(init=False, default=())

    def __post_init__(self) -> None:
        """Find which stacks each step must make: from the last one backwards, what is read."""
        self.versions = []
        wanted: dict[tuple[str, str], set[int]] = {}
        steps = self.launch.products.steps
        for number in range(len(steps) - 1, -1, -1):
            step = steps[number]
            place = self.launch.place(step.result, step)
            axes = wanted.pop(place.key, None) or {place.along(ROW)}
            for axis in sorted(axes):
                along = ROW if place.along(ROW) == axis else COL
                version = Version(number, along)
                self.versions.append(version)
                for view, coordinate in self._reads(version):
                    read = self.launch.place(view, step)
                    wanted.setdefault(read.key, set()).add(read.along(coordinate))
        self.versions.reverse()

    @property
    def side(self) -> int:
        """Rows of a block."""
        return array_of(self.mode, self._tile_bytes).rows

    @property
    def _tile_bytes(self) -> int:
        return self.machine.fabric.scratchpad.size_bytes

    def cycles(self) -> int:
        """About how many the job takes."""
        total = 0
        for version in self.versions:
            step = self.launch.products.steps[version.step]
            if version in self.tilings:
                total += self.tilings[version].cycles(self.machine)
            total += sum(
                self._pass_cycles(step, term, coordinates)
                for term, coordinates in self._passes(version)
            )
        return total

    def _pass_cycles(self, step: Step, term: Term, coordinates: tuple[int, int]) -> int:
        box = self.launch.box(step)
        elements = int(np.prod([box[c][1] - box[c][0] for c in coordinates]))
        arrays = len(set(term.views)) + (SUM in _leaves(term)) + 1
        moved = elements * arrays * WORD_BYTES // self.machine.dram.bytes_per_cycle
        pes = sum(len(tile.pes) for tile in self.machine.tiles)
        return moved + pes * _CONTEXTS // self.machine.configuration.entries_per_cycle

    def _passes(self, version: Version) -> list[tuple[Term, tuple[int, int]]]:
        """Expressions that the tiles compute for a version, with their coordinates."""
        step = self.launch.products.steps[version.step]
        if isinstance(step, Elementwise):
            return [(step.value, (ROW, COL))]
        found = [(step.left, (ROW, INNER)), (step.right, (INNER, COL))]
        tiling = self.tilings[version]
        found += [(step.start, (ROW, COL))] * tiling.added + [(step.finish, (ROW, COL))]
        return [one for one in found if not _is_plain(one[0], tiling)]

    def _product(self, version: Version) -> Product:
        """The product whose rows the stacks of a version are blocks of."""
        step = self.launch.products.steps[version.step]
        assert isinstance(step, Product)
        return step if version.along == ROW else step.swapped()

    def _reads(self, version: Version) -> list[tuple[View, int]]:
        """Views that a version is made of, with the coordinate along which stacks of them are."""
        step = self.launch.products.steps[version.step]
        if isinstance(step, Elementwise):
            return [(view, version.along) for view in step.value.views]
        product = self._product(version)
        tiling = self._tiled(version, product)
        starts = ROW if tiling.is_swapped(0) else COL
        found = [(view, ROW) for view in (*product.left.views, *product.finish.views)]
        found += [(view, COL) for view in product.right.views]
        found += [(view, starts) for view in product.start.views if tiling.added]
        swap = {ROW: COL, COL: ROW, INNER: INNER}
        if version.along == ROW:
            return found
        return [(view.swapped(), swap[coordinate]) for view, coordinate in found]

    def _tiled(self, version: Version, product: Product) -> Tiling:
        if version not in self.tilings:
            sizes = self.launch.sizes(product)
            added = not _is_bias(product.start) or self._is_made(product, version.step)
            relu = positive_part(product.finish) == Term(SUM) and self._is_small(product, version)
            self.tilings[version] = tiled(sizes, self.mode, self.machine, relu=relu, added=added)
        return self.tilings[version]

    def _is_made(self, product: Product, number: int) -> bool:
        """Whether a step before makes the right matrix, which then has no bias beside it."""
        before = self.launch.products.steps[:number]
        return any(
            step.result.array in {v.array for v in product.right.views} for step in before
        ) or not _is_load(product.right)

    def _is_small(self, product: Product, version: Version) -> bool:
        """Whether no sum can be NaN, of which the array's max(x, 0) makes 0."""
        before = {s.result.array for s in self.launch.products.steps[: version.step]}
        terms = (product.left, product.right, product.start)
        if not all(_is_load(term) or term == ZERO for term in terms):
            return False
        if before & {view.array for view in product.views}:
            return False
        most = [
            float(np.abs(self.launch.arrays[term.view.array]).max()) if term.view else 0.0
            for term in terms
        ]
        return bool(most[0] * most[1] * self.launch.sizes(product).depth + most[2] < _LARGEST)

    # --- the job ----------------------------------------------------------------------------------

    def add(self, job: Job) -> None:
        """Add all steps to a job."""
        for version in self.versions:
            step = self.launch.products.steps[version.step]
            place = self.launch.place(step.result, step)
            if isinstance(step, Elementwise):
                other = COL if version.along == ROW else ROW
                made = self._by_tiles(job, step.value, step, (version.along, other))
            else:
                made = self._multiplied(job, version)
            self._made[place.key, place.along(version.along)] = made

    def write(self) -> None:
        """Write the results of a job that is done into their arrays; not what is written again."""
        last = {
            self.launch.place(step.result, step).key: number
            for number, step in enumerate(self.launch.products.steps)
            if not step.edges
        }
        for version in self.versions:
            step = self.launch.products.steps[version.step]
            place = self.launch.place(step.result, step)
            if version.step < last.get(place.key, 0):
                continue
            stacks, _ = self._made[place.key, place.along(version.along)]
            rows, cols = (limit - first for first, limit in self.launch.box(step)[:INNER])
            if version.along == ROW:
                values = unstacked(stacks, rows, cols)
            else:
                values = unstacked(stacks, cols, rows).T
            target = self.launch.arrays[place.array]
            mask = self.launch.mask(step)
            axes = [place.along(c) for c in (ROW, COL)]
            missing = tuple(number for number, axis in enumerate(axes) if axis < 0)
            part = np.expand_dims(target[place.index], missing)
            np.copyto(part, values, where=mask)

    def _multiplied(self, job: Job, version: Version) -> tuple[Stacks, tuple[int, ...]]:
        """The steps of a product, and of what is done before and after it."""
        product, tiling = self._product(version), self.tilings[version]
        left, first = self._computed(job, product.left, product, ROW, INNER)
        right, second = self._computed(job, product.right, product, COL, INNER)
        start: Stacks | None = None
        started: tuple[int, ...] = ()
        if tiling.added:
            along, other = (ROW, COL) if tiling.is_swapped(0) else (COL, ROW)
            start, started = self._computed(job, product.start, product, along, other)
        else:
            right = self._with_bias(right, product)
        before = (*first, *second, *self._on_arrays)
        made, done = add_product(job, tiling, Operands(left, right, start, before, started))
        self._on_arrays = done
        if product.finish == Term(SUM) or tiling.relu:
            return made, done
        return self._computed(job, product.finish, product, ROW, COL, (made, done))

    def _with_bias(self, right: Stacks, product: Product) -> Stacks:
        depth = self.launch.sizes(product).depth
        whole = np.zeros((right.shape[0], depth + 1, right.shape[2]), np.float32)
        whole[:, :depth] = right[:, :depth]
        if product.start.view is not None:
            place = self.launch.place(product.start.view, product)
            bias = self.launch.matrix(place, ROW, COL, product)[0]
            whole[:, depth].reshape(-1)[: bias.size] = bias
            filled = np.zeros(whole.shape[0] * whole.shape[2], np.float32)
            filled[: bias.size] = bias
            whole[:, depth] = filled.reshape(whole.shape[0], -1)
        return whole

    def _computed(
        self,
        job: Job,
        term: Term,
        step: Step,
        along: int,
        other: int,
        total: tuple[Stacks, tuple[int, ...]] | None = None,
    ) -> tuple[Stacks, tuple[int, ...]]:
        """Stacks of an expression's values, blocks along one coordinate, and the steps that make
        them; without steps if the host has them.
        """
        if term.view is not None:
            return self._read(term.view, step, along, other)
        box = self.launch.box(step)
        if term.op in (CONST, INPUT):
            word = term.word if term.op == CONST else self.launch.words[term.key]
            shape = [box[c][1] - box[c][0] for c in (along, other)]
            return stacked(np.full(shape, float_of(word), np.float32), self.side), ()
        return self._by_tiles(job, term, step, (along, other), total)

    def _by_tiles(
        self,
        job: Job,
        term: Term,
        step: Step,
        coordinates: tuple[int, int],
        total: tuple[Stacks, tuple[int, ...]] | None = None,
    ) -> tuple[Stacks, tuple[int, ...]]:
        box = self.launch.box(step)
        along, other = coordinates
        views = tuple(dict.fromkeys(term.views))
        sources = {f"x{n}": self._read(view, step, along, other) for n, view in enumerate(views)}
        if total is not None:
            sources["s"] = total
        shape = [-(-(box[c][1] - box[c][0]) // self.side) for c in (along, other)]
        made = np.zeros((shape[0], shape[1] * self.side, self.side), np.float32)
        before = tuple(number for _, steps in sources.values() for number in steps)
        arrays = {name: values for name, (values, _) in sources.items()}
        done = loop_steps(
            job,
            term_program(term, views, self._tile_bytes),
            {**arrays, "y": made},
            "y",
            self.launch.scalars(term),
            (*before, *self._on_tiles),
        )
        self._on_tiles = done
        return made, done

    def _read(
        self, view: View, step: Step, along: int, other: int
    ) -> tuple[Stacks, tuple[int, ...]]:
        place = self.launch.place(view, step)
        known = self._made.get((place.key, place.along(along)))
        if known is not None:
            return known
        matrix = self.launch.matrix(place, along, other, step)
        return stacked(matrix, self.side), ()


def _leaves(term: Term) -> set[str]:
    return {term.op}.union(*(_leaves(arg) for arg in term.args))


def _is_load(term: Term) -> bool:
    return term.op == LOAD


def _is_bias(term: Term) -> bool:
    """Whether it is a number for each column, which arrays start sums from by themselves."""
    if term.view is None:
        return term == ZERO
    return ROW not in {axis.coordinate for axis in term.view.axes}


def _is_plain(term: Term, tiling: Tiling) -> bool:
    """Whether nothing is computed: it is read, or the array's own doing."""
    is_relu = tiling.relu and positive_part(term) == Term(SUM)
    return term.op in (LOAD, CONST, INPUT, SUM) or is_relu

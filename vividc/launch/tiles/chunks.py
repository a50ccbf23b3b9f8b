"""How a parallel loop is cut into chunks: their length, the bytes each touches, and where those are
placed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field, replace

from vividc.arch import Accelerator, Scratchpad
from vividc.errors import ArgumentError, SourceLoc, warn
from vividc.launch.tiles.shares import Part, Sharing
from vividc.machine.parallel import Parallel
from vividc.machine.params import named_array
from vividc.program import WORD_BYTES, Program
from vividc.sim.footprint.coverage import written_whole
from vividc.sim.footprint.footprint import Touch, loop_bounds, touched

Interval = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Chunk:
    """Iterations `first` to before `last`, and what they touch of each array, in bytes.

    `overwritten`: arrays of whose slice every byte is written before it is read.
    `words`: which iterations it has of loops beside the parallel one.
    """

    first: int
    last: int
    touches: ReadOnly[str, Touch]
    overwritten: frozenset[str] = frozenset()
    words: ReadOnly[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plan:
    """A loop cut into chunks.

    Attributes
    ----------
    resident
        Arrays that every chunk reads the same bytes of: they are moved once. Word-aligned bytes.
    sliced
        Bytes of the largest slice of each other array.
    copies
        Places for the slices in each scratchpad: 2 if they are double-buffered.
    """

    chunks: tuple[Chunk, ...]
    resident: ReadOnly[str, Interval]
    sliced: ReadOnly[str, int]
    copies: int


@dataclass(frozen=True, slots=True)
class Cut:
    """What is to be cut: a program, its launch words, and the bytes of its arrays, those of its own
    that are sliced among them.
    """

    program: Program
    inputs: ReadOnly[str, int]
    sizes: ReadOnly[str, int]
    machine: Accelerator
    double_buffer: bool

    @property
    def scratchpad(self) -> Scratchpad:
        """That of every tile."""
        return self.program.fabric.scratchpad

    @property
    def local_sizes(self) -> dict[str, int]:
        """Bytes of the kernel's own arrays of which each tile has one."""
        whole = own_sizes(self.program, self.inputs)
        return {name: size for name, size in whole.items() if name not in self.sizes}

    def chunks(self, parts: Sequence[Part], *, whole: bool) -> tuple[Chunk, ...]:
        """The chunks of these iterations; `whole`: they are all there are."""
        parallel = self.program.parallel
        if parallel is None:
            stored = self.program.stored_arrays
            touches = {name: _whole(size, name in stored) for name, size in self.sizes.items()}
            return tuple(Chunk(part.first, part.last, touches) for part in parts)
        sharing = Sharing(parallel, self.inputs, self.sizes)
        shares = sharing.words(parts, whole=whole)
        return tuple(
            self._chunk(parallel, part, words) for part, words in zip(parts, shares, strict=True)
        )

    def _chunk(self, parallel: Parallel, part: Part, words: ReadOnly[str, int]) -> Chunk:
        inputs, ends = {**self.inputs, **words}, (part.first, part.last)
        touches = touched(parallel, inputs, self.sizes, *ends)
        over = {
            name
            for leading in (False, True)
            for name, whole in written_whole(parallel, inputs, *ends, leading=leading).items()
            if _is_overwritten(touches[name], whole, leading)
        }
        return Chunk(*ends, touches, frozenset(over), words)


def own_sizes(program: Program, inputs: ReadOnly[str, int]) -> dict[str, int]:
    """Bytes of the kernel's own arrays."""
    sizes = (local.at_launch(inputs) for local in program.locals)
    return {local.name: WORD_BYTES * local.words for local in sizes}


def _whole(size: int, is_stored: bool) -> Touch:
    part = (0, size) if size else None
    return Touch(part, part if is_stored else None)


def _is_overwritten(touch: Touch, written: Interval, leading: bool) -> bool:
    """`leading`: it is written before it is read."""
    if touch.hull is None or not (leading or touch.loads is None):
        return False
    return written[0] <= touch.hull[0] and touch.hull[1] <= written[1]


def plan_chunks(cut: Cut, length: int | None) -> Plan:
    """Cut the loop.

    Parameters
    ----------
    length
        Iterations of a chunk; None: as many as fit, but at least two chunks for each tile if the
        slices are double-buffered, which they are not if a single iteration would not fit then.

    Chunks that may touch what others write are one, with a warning.

    Raises
    ------
    ArgumentError
        Not even one iteration fits a scratchpad, `length` do not, or all do not where no chunks
        may be made.
    """
    parallel = cut.program.parallel
    first, last = (0, 1) if parallel is None else loop_bounds(parallel, cut.inputs)
    count = last - first
    tiles = len(cut.machine.tiles)
    if length is not None:
        if length < 1:
            raise ArgumentError(f"a chunk of {length} iterations")
        plan = _plan(cut, first, last, length)
        _demand_fit(cut, plan, length)
    else:
        most = max(1, -(-count // (tiles * (2 if cut.double_buffer else 1))))
        plan = _longest(cut, first, last, most)
        if _need(cut, plan) > cut.scratchpad.size_bytes and plan.copies > 1:
            plan = _longest(replace(cut, double_buffer=False), first, last, most)
        _demand_fit(cut, plan, 1)
    conflict = _conflict_of(cut, plan)
    return plan if conflict is None else _on_one_tile(cut, (first, last), conflict)


def _on_one_tile(cut: Cut, loop: Interval, conflict: ArgumentError) -> Plan:
    """Plan all iterations as one chunk, which keeps the order of the loop."""
    plan = _plan(replace(cut, double_buffer=False), *loop, max(1, loop[1] - loop[0]))
    if _need(cut, plan) > cut.scratchpad.size_bytes:
        raise conflict
    where = "" if conflict.loc is None else f"{conflict.loc}: "
    text = f"{where}{cut.program.name} runs on one tile only: {conflict.reason}"
    warn(text)
    return plan


def _longest(cut: Cut, first: int, last: int, most: int) -> Plan:
    """The plan with the longest chunks that fit: bisection over a few chunks, then all. Chunks of
    one iteration may not fit either.
    """
    low, high = 1, most
    while low < high:
        middle = (low + high + 1) // 2
        if _need(cut, _probe(cut, first, last, middle)) <= cut.scratchpad.size_bytes:
            low = middle
        else:
            high = middle - 1
    while True:
        plan = _plan(cut, first, last, low)
        if _need(cut, plan) <= cut.scratchpad.size_bytes or low == 1:
            return plan
        low = max(1, low * 3 // 4)


def _starts(first: int, last: int, length: int) -> range:
    return range(first, max(last, first + 1), length)


def _plan(cut: Cut, first: int, last: int, length: int) -> Plan:
    starts = _starts(first, last, length)
    parts = [Part(a, min(a + length, last), n, len(starts)) for n, a in enumerate(starts)]
    return _laid_out(cut, cut.chunks(parts, whole=True), len(starts))


def _probe(cut: Cut, first: int, last: int, length: int) -> Plan:
    """A plan of a few chunks in the place of all."""
    starts = _starts(first, last, length)
    some = sorted({0, len(starts) // 2, len(starts) - 1, min(1, len(starts) - 1)})
    parts = [Part(starts[k], min(starts[k] + length, last), k, len(starts)) for k in some]
    return _laid_out(cut, cut.chunks(parts, whole=False), len(starts))


def _laid_out(cut: Cut, chunks: tuple[Chunk, ...], count: int) -> Plan:
    own = {local.name for local in cut.program.locals}
    resident: dict[str, Interval] = {}
    sliced: dict[str, int] = {}
    for name in cut.sizes:
        hulls = [hull for chunk in chunks if (hull := chunk.touches[name].hull) is not None]
        if not hulls:
            continue
        stored = any(chunk.touches[name].stores is not None for chunk in chunks)
        if not stored and len(set(hulls)) == 1 and name not in own:
            resident[name] = aligned(hulls[0])
        else:
            sliced[name] = max(end - start for start, end in map(aligned, hulls))
    twice = cut.double_buffer and count > len(cut.machine.tiles)
    return Plan(chunks, resident, sliced, 2 if twice else 1)


def aligned(interval: Interval) -> Interval:
    """The words around some bytes."""
    return (
        interval[0] // WORD_BYTES * WORD_BYTES,
        -(-interval[1] // WORD_BYTES) * WORD_BYTES,
    )


def slack(scratchpad: Scratchpad) -> int:
    """Bytes that a place has more than its array, so that this can start in any bank."""
    return WORD_BYTES * (scratchpad.banks - 1)


def _need(cut: Cut, plan: Plan) -> int:
    """Bytes of scratchpad."""
    more = slack(cut.scratchpad)
    resident = sum(end - start + more for start, end in plan.resident.values())
    sliced = sum(size + more for size in plan.sliced.values())
    error = WORD_BYTES if cut.program.results is not None and cut.program.results.error else 0
    return resident + sum(cut.local_sizes.values()) + plan.copies * (sliced + error)


def _demand_fit(cut: Cut, plan: Plan, length: int) -> None:
    need, room = _need(cut, plan), cut.scratchpad.size_bytes
    if need <= room:
        return
    parts = [f"{name} {end - start} whole" for name, (start, end) in plan.resident.items()]
    parts += [f"{name} {size} of its own" for name, size in cut.local_sizes.items()]
    parts += [f"{name} {size} of {cut.sizes[name]}" for name, size in plan.sliced.items()]
    if plan.copies > 1:
        parts.append("slices twice, to move while the tile computes")
    what = "the whole kernel needs"
    if cut.program.parallel is not None:
        what = f"{length} iteration{'s' if length > 1 else ''} of the loop over prange need"
    raise ArgumentError(
        f"{what} {need} bytes of a scratchpad of {room}: {', '.join(parts)}",
        loc=None if cut.program.parallel is None else cut.program.parallel.loc,
        hint=_way_out(cut, plan),
    )


def _way_out(cut: Cut, plan: Plan) -> str:
    if cut.program.parallel is None:
        return (
            "mark the kernel's outer loop with numba.prange, so that it can be cut; a warning of "
            "the compiler says why one that is marked cannot"
        )
    whole = [name for name, size in plan.sliced.items() if size >= cut.sizes[name]]
    whole += list(plan.resident)
    if whole:
        return (
            f"{', '.join(whole)}: index by the loop's variable first, as in x[i, j], to have it "
            "cut, or pass a smaller piece"
        )
    return "let an iteration do less: loop over rows, or over blocks of them"


def _conflict_of(cut: Cut, plan: Plan) -> ArgumentError | None:
    """Return why the loop cannot be cut so: a chunk may touch what another writes. None: it can."""
    if len(plan.chunks) == 1:
        return None
    parallel = cut.program.parallel
    alike = () if parallel is None else parallel.alike
    for name in (name for name in cut.sizes if name not in alike):
        uses = sorted(_uses(plan.chunks, name), key=lambda use: use[:4])
        open_: list[tuple[int, int, bool, SourceLoc | None]] = []
        for start, number, end, writes, loc in uses:
            open_ = [use for use in open_ if use[0] > start]
            for _, other, other_writes, other_loc in open_:
                if other != number and (writes or other_writes):
                    both = writes and other_writes
                    return _conflict(cut, name, both, (loc if writes else other_loc))
            open_.append((end, number, writes, loc))
    return None


def _uses(
    chunks: Sequence[Chunk], name: str
) -> Iterator[tuple[int, int, int, bool, SourceLoc | None]]:
    for number, chunk in enumerate(chunks):
        touch = chunk.touches[name]
        if touch.loads is not None:
            yield touch.loads[0], number, touch.loads[1], False, touch.load_loc
        if touch.stores is not None:
            yield touch.stores[0], number, touch.stores[1], True, touch.store_loc


def _conflict(cut: Cut, name: str, both_write: bool, loc: SourceLoc | None) -> ArgumentError:
    what = "write" if both_write else "read and write"
    own = {local.name for local in cut.program.locals}
    which = named_array(name) if name in own else name
    return ArgumentError(
        f"iterations on different tiles may {what} the same bytes of {which}, so the loop over "
        f"prange in line {_line(cut.program)} cannot be spread",
        loc=loc,
        hint="index what is written by the loop's variable first, as in y[i, j]; read and write "
        "different arrays; or pass arrays that fit one tile",
    )


def _line(program: Program) -> str:
    loc = None if program.parallel is None else program.parallel.loc
    return "?" if loc is None else str(loc.line)

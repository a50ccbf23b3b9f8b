"""What the edges of a systolic array cannot compute of each element: the tiles do, as GPUs do.

exp and sigmoid take FMAs, which the load/store units at the edge have none of; the job switches the
tiles to a program of one loop over the results. So do kernels' own expressions.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.dfg.builder import GraphBuilder, Operand
from vividc.dfg.ir import DFG, Node
from vividc.dfg.pipeline import optimize
from vividc.errors import TimeLimit
from vividc.gemm.layer import Apart
from vividc.gemm.modes import sized
from vividc.gemm.program import CountedLoop, loops_program
from vividc.host import time_limit
from vividc.launch import At, Job
from vividc.launch.turns import Turns
from vividc.machine.opcodes import Opcode
from vividc.machine.params import DType, Param
from vividc.machine.product import CONST, INPUT, SUM, Term, View
from vividc.mapper import MapResult
from vividc.mapper.api import map_dfg
from vividc.program import WORD_BYTES, Program

_ONE: Final = 0x3F800000
_TIME_LIMITS_S: Final = (5.0, 30.0, 180.0)
_PATIENCE: Final = 10.0
_PARTS: Final = 2
"""Chunks that a scratchpad holds: one comes or goes while the other is worked on."""


def elementwise_steps(
    job: Job, values: NDArray[np.float32], kind: Apart, before: tuple[int, ...]
) -> tuple[int, ...]:
    """Add to a job: every element of a contiguous array in DRAM, replaced by its image.

    Parameters
    ----------
    before
        Steps that write `values`.

    Returns
    -------
    The steps that must be done before `values` is read.
    """
    program = elementwise_program(kind, job.accelerator.fabric.scratchpad.size_bytes)
    return loop_steps(job, program, {"x": values}, "x", {}, before)


def loop_steps(
    job: Job,
    program: Program,
    arrays: Mapping[str, NDArray[np.float32]],
    stored: str,
    scalars: Mapping[str, object],
    before: tuple[int, ...],
) -> tuple[int, ...]:
    """Add to a job: a program of one loop over n elements of contiguous arrays in DRAM, all of one
    size, of which it writes one.

    Parameters
    ----------
    scalars
        Further arguments.
    before
        Steps that write the others.

    Returns
    -------
    The steps that must be done before what is stored is read.
    """
    machine = job.accelerator
    tiles = range(len(machine.tiles))
    flat = {name: values.reshape(-1) for name, values in arrays.items()}
    total = flat[stored].size
    most = machine.fabric.scratchpad.words // (_PARTS * len(flat))
    size = min(most, -(-total // (len(tiles) * _PARTS)))
    starts = range(0, total, size)
    job.configure(tiles[: len(starts)], program)
    turns, done = Turns(tiles, _PARTS), []
    for start in starts:
        tile, part, freed = turns.take()
        chunks = {name: values[start : start + size] for name, values in flat.items()}
        count = chunks[stored].size
        first = part * len(flat) * most
        places = {name: (first + n * most) * WORD_BYTES for n, name in enumerate(flat)}
        moved = [
            job.move_in(tile, chunk, places[name], after=[*before, *freed])
            for name, chunk in chunks.items()
            if name in program.loaded_arrays
        ]
        given = {name: At(place, (count,)) for name, place in places.items()}
        after = moved or [*before, *freed]
        ran = job.run(tile, program, after=after, n=count, **given, **scalars)
        done.append(job.move_out(tile, places[stored], chunks[stored], after=[ran]))
        turns.free(tile, part, done[-1])
    return tuple(done)


@lru_cache(maxsize=32)
def term_program(term: Term, views: tuple[View, ...], tile_bytes: int) -> Program:
    """A loop that makes y[i] of the elements i of `x0`, `x1`, ... in place of `views`, of `s` in
    place of the sum, and of scalars, which are its parameters.
    """
    builder = GraphBuilder("elementwise")
    shift = WORD_BYTES.bit_length() - 1
    loaded: dict[str, Operand] = {}

    def element(name: str) -> Operand:
        if name not in loaded:
            node = Node(0, Opcode.LOAD, name=name, shift=shift)
            base = builder.live_in(f"&{name}")
            loaded[name] = builder.add_node(node, [builder.iv()], base=base)
        return loaded[name]

    def made(one: Term) -> Operand:
        if one.view is not None:
            return element(f"x{views.index(one.view)}")
        if one.op == SUM:
            return element("s")
        if one.op == INPUT:
            return builder.live_in(one.key)
        if one.op == CONST:
            return builder.const(one.word)
        return builder.add(Opcode(one.op), [made(arg) for arg in one.args])

    value = made(term)
    node = Node(0, Opcode.STORE, name="y", shift=shift)
    builder.add_node(node, [builder.iv(), value], base=builder.live_in("&y"))
    arrays = (*loaded, "y")
    params = [Param(name, DType.F32, 1) for name in arrays]
    params += [Param(key, DType.F32) for key in dict.fromkeys(term.keys)]
    params.append(Param("n", DType.I32))
    return loop_program("elementwise", builder.build(), tuple(params), tile_bytes)


@lru_cache(maxsize=8)
def elementwise_program(kind: Apart, tile_bytes: int) -> Program:
    """A loop that replaces x[i] by its image, for 0 <= i < n.

    exp is that of docs/math.md; sigmoid is 1 / (1 + exp(-x)), each operation rounded.
    """
    params = (Param("x", DType.F32, 1), Param("n", DType.I32))
    return loop_program(kind, _graph(kind), params, tile_bytes)


def loop_program(
    name: str, graph: DFG, params: tuple[Param, ...], tile_bytes: int | None = None
) -> Program:
    """The program of one loop of n iterations on a tile; `tile_bytes`: of its scratchpad, if it has
    another size than vivid-tile's.
    """
    fabric = arch.load_tile("vivid-tile") if tile_bytes is None else sized("vivid-tile", tile_bytes)
    loop = optimize(graph)
    result = _mapped(loop, fabric)
    if result.mapping is None:
        hint = "try again on a machine that has less to do"
        raise TimeLimit(f"{name} was not mapped in time: {result.explain()}", hint=hint)
    return loops_program(name, fabric, params, [CountedLoop("", name, "n", loop, result)])


def _mapped(loop: DFG, fabric: Fabric) -> MapResult:
    """Map a loop with a short time limit, or with longer ones if that fails.

    Effort and not the clock ends them, so that a product takes the same cycles on a busy machine;
    within a limit of a caller's, that holds.
    """
    with nullcontext() if time_limit.current() else time_limit.patient(_PATIENCE):
        for limit in _TIME_LIMITS_S:
            result = map_dfg(loop, fabric, time_limit_s=limit, effort="thorough")
            if result.mapping is not None:
                break
    return result


def _graph(kind: Apart) -> DFG:
    builder = GraphBuilder(kind)
    base = builder.live_in("&x")
    shift = WORD_BYTES.bit_length() - 1
    load = Node(0, Opcode.LOAD, name="x", shift=shift)
    word = builder.add_node(load, [builder.iv()], base=base)
    store = Node(0, Opcode.STORE, name="x", shift=shift)
    builder.add_node(store, [builder.iv(), _image(builder, kind, word)], base=base)
    return builder.build()


def _image(builder: GraphBuilder, kind: Apart, word: Operand) -> Operand:
    if kind == "exp":
        return builder.add(Opcode.EXP, [word])
    one = builder.const(_ONE)
    power = builder.add(Opcode.EXP, [builder.add(Opcode.FNEG, [word])])
    return builder.add(Opcode.FDIV, [one, builder.add(Opcode.FADD, [one, power])])

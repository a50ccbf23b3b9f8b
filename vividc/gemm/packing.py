"""Results that become operands of 16 or 8 bits: the tiles pack them, in GPU-like mode."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.dfg.ir import DFG, Node
from vividc.gemm.elementwise import loop_program
from vividc.gemm.systolic import Precision, lanes
from vividc.launch import At, Job
from vividc.launch.turns import Turns
from vividc.machine.opcodes import Opcode
from vividc.machine.params import DType, Param
from vividc.program import WORD_BYTES, Program

Matrix = NDArray[np.float32]

_PARTS: Final = 2
_PAIR: Final = 2
_SHIFT: Final = WORD_BYTES.bit_length() - 1


def pack_steps(
    job: Job, values: Matrix, words: int, precision: Precision, before: tuple[int, ...]
) -> tuple[Matrix, tuple[int, ...]]:
    """Add to a job: results in DRAM, by blocks, become operands of a format, on the tiles.

    Parameters
    ----------
    values
        float32 [blocks, columns, rows of a block].
    words
        Of a row of the operands.
    before
        Steps that write `values`.

    Returns
    -------
    The operands [blocks, words, rows of a block], as `gemm.packed` has them, and the steps that
    must be done before they are read.
    """
    machine, count = job.accelerator, lanes(precision)
    rows = values.shape[2]
    program = pack_program(precision, rows, machine.fabric.scratchpad.size_bytes)
    target = np.zeros((values.shape[0], words, rows), np.float32)
    room = machine.fabric.scratchpad.words // _PARTS
    tiles = range(len(machine.tiles))
    chunks = _chunks(values.shape[0], words, room // (rows * (count + 1)), len(tiles))
    job.configure(tiles[: len(chunks)], program)
    turns, done = Turns(tiles, _PARTS), []
    for blocks, part_words in chunks:
        tile, place, freed = turns.take()
        columns = slice(part_words.start * count, part_words.stop * count)
        source, result = values[blocks, columns], target[blocks, part_words]
        first = place * room * WORD_BYTES
        second = first + source.nbytes
        moved = job.move_in(tile, source, first, after=[*before, *freed])
        x, y = At(first, (source.size,)), At(second, (result.size,))
        ran = job.run(tile, program, after=[moved], x=x, y=y, n=result.size)
        done.append(job.move_out(tile, second, result, after=[ran]))
        turns.free(tile, place, done[-1])
    return target, tuple(done)


def _chunks(blocks: int, words: int, most: int, tiles: int) -> list[tuple[slice, slice]]:
    """Blocks and words of each launch, of at most `most` words of a row each."""
    if most < words:
        parts = range(0, words, most)
        return [
            (slice(b, b + 1), slice(w, min(w + most, words))) for b in range(blocks) for w in parts
        ]
    size = min(most // words, -(-blocks // (tiles * _PARTS)))
    return [(slice(b, min(b + size, blocks)), slice(0, words)) for b in range(0, blocks, size)]


@lru_cache(maxsize=8)
def pack_program(precision: Precision, rows: int, tile_bytes: int) -> Program:
    """A loop that makes word y[t] of the elements x of as many columns as a word has lanes, for
    0 <= t < n; columns are `rows` long, a power of two.
    """
    params = (Param("x", DType.F32, 1), Param("y", DType.F32, 1), Param("n", DType.I32))
    return loop_program(f"pack_{precision}", _graph(precision, rows), params, tile_bytes)


def _graph(precision: Precision, rows: int) -> DFG:
    """Column p of words holds row i at t = p rows + i; its lane k is column lanes p + k of x."""
    builder, count = GraphBuilder("pack"), lanes(precision)
    x, y, t = builder.live_in("&x"), builder.live_in("&y"), builder.iv()
    bits = rows.bit_length() - 1

    def do(op: Opcode, operand: Operand, number: int) -> Operand:
        return builder.add(op, [operand, builder.const(number)])

    row = do(Opcode.AND, t, rows - 1)
    column = do(Opcode.LSHR, t, bits)
    first = do(Opcode.SHL, column, bits + count.bit_length() - 1)
    index = builder.add(Opcode.OR, [first, row])
    loads = []
    for lane in range(count):
        offset = lane * rows * WORD_BYTES
        node = Node(0, Opcode.LOAD, name="x", shift=_SHIFT, offset=offset)
        loads.append(builder.add_node(node, [index], base=x))
    suffix = f"{precision}x{count}"
    word = builder.add(Opcode(f"pack.{suffix}"), loads[:_PAIR])
    if count > _PAIR:
        word = builder.add(Opcode(f"pack_high.{suffix}"), [*loads[_PAIR:], word])
    store = Node(0, Opcode.STORE, name="y", shift=_SHIFT)
    builder.add_node(store, [t, word], base=y)
    return builder.build()

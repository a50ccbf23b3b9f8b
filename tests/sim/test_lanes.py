"""Every operation on lanes, as words of a program: the interpreter and both engines agree."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sim.native.agreement import assert_engines_agree, launch
from tests.sim.one_pe import map_region, one_pe
from vividc import simulate
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.forms.json_form import from_json, to_json
from vividc.dfg.forms.text import to_text
from vividc.dfg.forms.text_parser import parse
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.regions import Kernel
from vividc.machine.lane_semantics import LANE_SEMANTICS
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.machine.params import DType, Param
from vividc.machine.semantics import evaluate
from vividc.program import Program, disassemble, encode, load
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref

ROW = 4  # words of operands
OPS = sorted(LANE_SEMANTICS, key=lambda op: op.value)
COUNT = 24


def function(ops: list[Opcode], columns: int) -> Function:
    """for i in range(n): y[i, k] = ops[k](x[i, 0], x[i, 1], x[i, 2]) for each k."""
    i = Ref(0)
    shift = columns.bit_length() + 1
    header = Block(
        "header",
        (Phi(0, Type.I32, (("entry", Const(0)), ("body", Ref(2)))),),
        (Instr(1, Opcode.ICMP_SLT, Type.PRED, (i, Input("n"))),),
        Branch("body", Ref(1), "exit"),
    )
    body = [Instr(2, Opcode.ADD, Type.I32, (i, Const(1)), exact=True)]
    body += [
        Instr(3 + k, Opcode.LOAD, Type.ANY, (Input("&x"), i), "x", shift=4, offset=4 * k)
        for k in range(3)
    ]
    operands = tuple(Ref(3 + k) for k in range(3))
    for k, op in enumerate(ops):
        info, at = OPCODES[op], 6 + 2 * k
        body.append(Instr(at, op, info.result, operands[: info.arity]))
        store = (Input("&y"), i, Ref(at))
        body.append(Instr(at + 1, Opcode.STORE, Type.NONE, store, "y", shift=shift, offset=4 * k))
    blocks = (
        Block("entry", (), (), Branch("header")),
        header,
        Block("body", (), tuple(body), Branch("header")),
        Block("exit", (), (), Branch()),
    )
    params = (Param("x", DType.U32, 2), Param("y", DType.U32, 2), Param("n", DType.I32))
    return Function("lanes", params, blocks)


def words(count: int) -> np.ndarray:
    """Operands: any bits, and lanes of moderate numbers."""
    rng = np.random.default_rng(1)
    found = rng.integers(0, 1 << 32, (count, ROW), np.uint32)
    found[::2] &= np.uint32(0xBFBFBFBF)
    found[::3, 2] = rng.integers(0x3E000000, 0x41000000, (count, ROW))[::3, 2]
    return found


def kernel_of(ops: list[Opcode]) -> Kernel:
    return build_kernel(function(ops, 1 << (len(ops) - 1).bit_length()))


def through_a_file(program: Program, folder: Path) -> Program:
    program.save(folder / "lanes.vivid")
    again = load(folder / "lanes.vivid")
    assert again == program
    return again


def test_forms_of_graphs_know_every_operation() -> None:
    for region in kernel_of(OPS).regions:
        assert parse(to_text(region.dfg)) == region.dfg
        assert from_json(to_json(region.dfg)) == region.dfg


@pytest.mark.parametrize("latencies", ["{}", "{float: 4, convert: 2, dot: 9, compare: 3, load: 2}"])
def test_interpreter_and_engines_agree(latencies: str, tmp_path: Path) -> None:
    ops = OPS
    fabric = one_pe(latencies, 1, scratchpad_bytes=1 << 15)
    kernel = kernel_of(ops)
    x, columns = words(COUNT), 1 << (len(ops) - 1).bit_length()
    wanted = np.zeros((COUNT, columns), np.uint32)
    for row, given in zip(wanted, x.tolist(), strict=True):
        row[: len(ops)] = [evaluate(op, given[: OPCODES[op].arity]) for op in ops]
    memory = np.concatenate([x.ravel(), np.zeros(COUNT * columns, np.uint32)])
    inputs = {"&x": 0, "&y": x.nbytes, "n": COUNT}
    shapes = {"x.shape0": COUNT, "x.shape1": ROW, "y.shape0": COUNT, "y.shape1": columns}
    interpret(kernel, memory, inputs | shapes, iteration_limit=1000)
    np.testing.assert_array_equal(memory[x.size :].reshape(wanted.shape), wanted)

    mappings = {i: map_region(region, fabric) for i, region in enumerate(kernel.regions)}
    program = through_a_file(encode(kernel, fabric, mappings), tmp_path)
    text = disassemble(program)
    assert all(f" {op.value} " in text for op in ops)
    y = np.zeros_like(wanted)
    simulate(program, x, y, COUNT)
    np.testing.assert_array_equal(y, wanted)
    assert_engines_agree(program, launch(program, x, np.zeros_like(wanted), COUNT))

"""A dump, parsed back, gives what was recorded."""

import re

import numpy as np
import pytest

from tests.sim.view.test_recording import X, strided_arguments
from vividc.program.words.layout import OPCODE_NUMBERS
from vividc.sim.reference.predecode import StateMap
from vividc.sim.view import record, to_vcd


def declared(head):
    """(scope, name) of each identifier."""
    scopes, names = [], {}
    for line in head.splitlines():
        if line.startswith("$scope module "):
            scopes.append(line.split()[2])
        elif line.startswith("$upscope"):
            scopes.pop()
        elif line.startswith("$var"):
            _, kind, width, ident, name, _ = line.split()
            assert kind == "wire"
            assert int(width) in (1, 8, 32)
            assert ident not in names
            names[ident] = (".".join(scopes), name)
    assert scopes == []
    return names


def parse(text):
    """{(scope, name): [value of each cycle, None for x]}, and the cycles with an end."""
    head, body = text.split("$enddefinitions $end\n")
    names = declared(head)
    values = {key: [] for key in names.values()}
    current, times = {}, []
    for line in body.splitlines():
        if line.startswith("#"):
            until = int(line[1:])
            while times and times[-1] < until:
                for key, column in values.items():
                    column.append(current[key])
                times.append(times[-1] + 1)
            times = times or [until]
        elif not line.startswith("$"):
            match = re.fullmatch(r"b([01]+|x) (\S+)|([01])(\S+)", line)
            assert match, line
            bits, ident = match[1] or match[3], match[2] or match[4]
            current[names[ident]] = None if bits == "x" else int(bits, 2)
    return values, times


@pytest.fixture(params=[("total", (0, 1000)), ("total", (7, 30)), ("strided", (0, 1000))])
def dumped(request, programs):
    name, window = request.param
    arguments = (X, 40) if name == "total" else strided_arguments()
    recording = record(programs[name], arguments, {}, window=window)
    return recording, *parse(to_vcd(recording))


def test_cycles_and_scopes(dumped):
    recording, values, times = dumped
    assert (times[0], times[-1]) == (recording.first, recording.end)
    assert {scope for scope, _ in values} == {"tile", *(f"tile.pe_{pe}" for pe in range(16))}
    assert {len(column) for column in values.values()} == {recording.end - recording.first}


def test_opcodes_say_what_issued(dumped):
    recording, values, _ = dumped
    seen = {
        (recording.first + cycle, pe, OPCODE_NUMBERS[number].value)
        for pe in range(16)
        for cycle, number in enumerate(values[f"tile.pe_{pe}", "opcode"])
        if number
    }
    issued = {
        (int(cycle), one.pe, one.op)
        for cycle, ops in zip(recording.cycles, recording.issued, strict=True)
        for one in ops
    }
    assert seen == issued


def test_words_are_those_recorded(dumped):
    recording, values, _ = dumped
    cells = StateMap(recording.program.fabric)
    fabric = recording.program.fabric
    for sample, cycle in enumerate(recording.cycles - recording.first):
        for pe in range(16):
            word = values[f"tile.pe_{pe}", "out"][cycle]
            assert (-1 if word is None else word) == recording.words[sample, cells.out_base + pe]
        for link in fabric.links:
            word = values[f"tile.pe_{link.dst}", f"link_from_{link.src}"][cycle]
            assert (-1 if word is None else word) == recording.words[sample, link.id]


def test_stalls(dumped):
    recording, values, _ = dumped
    np.testing.assert_array_equal(values["tile", "stall"], recording.stalled())


def test_loaded_words_and_their_sum_are_seen_in_output_registers(programs):
    """0 + 1 + .. + 39 = 780."""
    values, _ = parse(to_vcd(record(programs["total"], (X, 40), {})))
    outs = set().union(*(column for (_, name), column in values.items() if name == "out"))
    assert {*range(40), 780} <= outs

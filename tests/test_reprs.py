"""What a console or a notebook shows of each object: a line, whatever its size."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

import vividc
from vividc import LoopOptions, arch, launch, mapper
from vividc.compiler.driver import lower


@vividc.kernel("float32(float32[:, ::1], float32[::1], int64)")
def rows(a, y, n):
    total = np.float32(0)
    for i in range(n):
        y[i] = a[i, 0] + a[i, 1]
        total += y[i]
    return total


def test_each_is_a_line() -> None:
    tile = arch.load("vivid-tile")
    program = vividc.compile(rows, loops=LoopOptions(auto=False))
    args = (np.ones((4, 2), np.float32), np.zeros(4, np.float32), 4)
    result = vividc.simulate(program, *args)
    [loop] = [region.dfg for region in lower(rows).regions if region.kind == "loop"]
    found = mapper.map_dfg(loop, tile)
    shown = {
        repr(rows): "<kernel rows(a: float32[:, ::1], y: float32[::1], n: int64) -> float32>",
        repr(tile): "<Fabric vivid-tile: 4x4 PEs, 32768 bytes in 8 banks>",
        repr(arch.load("vivid")): "<Accelerator vivid: 4x4 tiles>",
        repr(launch.Job("vivid")): "<Job on vivid: 0 steps>",
        repr(program): "<Program rows(a, y, n) for vivid-tile: ",
        repr(result): f"<Result: {result.cycles} cycles, value 8.0, ",
        repr(loop): f"<DFG {loop.name}: {len(loop.nodes)} nodes, {len(loop.edges)} edges>",
        repr(found): f"<MapResult: II {found.ii}, optimal; lower bound {found.ii}; auto>",
        repr(found.mapping): f"<Mapping at II {found.ii}: ",
    }
    for text, start in shown.items():
        assert text.startswith(start)
        assert text.endswith(">")
        assert len(text) < 120
        assert "\n" not in text


def test_a_notebook_shows_tables_and_pictures() -> None:
    program = vividc.compile(rows, loops=LoopOptions(auto=False))
    args = (np.ones((4, 2), np.float32), np.zeros(4, np.float32), 4)
    result = vividc.simulate(program, *args)
    spread = vividc.simulate(vividc.compile(rows, fabric="vivid"), *args, fabric="vivid")
    loop = next(region for region in program.regions if region.kind == "loop")
    for one, words in (
        (program, ("loop", "II", "optimal")),
        (result, ("bank stalls", loop.name)),
        (spread, ("tile", "waits: dma")),
        (loop.result, ("ResMII", "RecMII")),
    ):
        shown = ElementTree.fromstring(one._repr_html_())
        text = "".join(shown.itertext())
        assert all(word in text for word in words)
    for picture in (loop.dfg, loop.mapping, loop.dfg.plot(), program.fabric):
        assert ElementTree.fromstring(picture._repr_svg_()).tag.endswith("svg")

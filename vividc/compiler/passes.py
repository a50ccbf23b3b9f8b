"""Every stage of a compilation by name, in order, and how what it leaves is written and checked.

`vividc compile --print-after` and `vividc opt` are made of these lists.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from vividc.compiler.regions.map_regions import Unmapped
from vividc.dfg.check import check
from vividc.dfg.cut.build import SHAPING
from vividc.dfg.forms.text import to_text as graph_text
from vividc.dfg.ir import DFG
from vividc.dfg.pipeline import PassOptions, pipeline
from vividc.dfg.regions import Kernel
from vividc.frontend.c.unrotate import unrotate
from vividc.frontend.narrow import narrow as narrowing
from vividc.frontend.stages import RESOLVING, SIMPLIFYING, STRAIGHTENING, TIDYING, Pointers
from vividc.host.watch import name_of
from vividc.program import Program, disassemble
from vividc.ssa.check import check_function
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.blocks import remove_unreachable_blocks
from vividc.ssa.rewrite.combine_additions import combine_additions
from vividc.ssa.rewrite.contract import contract
from vividc.ssa.rewrite.dead import remove_unused
from vividc.ssa.rewrite.hoist import hoist_invariants
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.number_values import merge_equal, number_values
from vividc.ssa.rewrite.simplify import simplify
from vividc.ssa.rewrite.tidy import tidy
from vividc.ssa.text import to_text as function_text


@dataclass(frozen=True, slots=True)
class Stage:
    """One stage: what it does, and the type of what it leaves."""

    name: str
    does: str
    leaves: type


_FUNCTION: Final[tuple[Callable[[Function], Function], ...]] = (
    *SHAPING,
    simplify,
    remove_unused,
    remove_unreachable_blocks,
    canonical_loops,
    combine_additions,
    number_values,
    merge_equal,
    hoist_invariants,
    contract,
    tidy,
)
FUNCTION_PASSES: Final[Mapping[str, Callable[[Function], Function]]] = {
    name_of(one): one for one in _FUNCTION
}
"""Passes from words to words, for `vividc opt`."""


def narrow(function: Function) -> Function:
    """LLVM's operations as the machine's, on words; what its warnings are about is left out."""
    return narrowing.narrow(function).function


LLVM_PASSES: Final[Mapping[str, Callable[[Function], Function]]] = {
    name_of(one): one for one in (*STRAIGHTENING, unrotate, *SIMPLIFYING, narrow)
}
"""Passes on functions that are LLVM's yet; `narrow` leaves words."""
GRAPH_PASSES: Final[Mapping[str, Callable[[DFG], DFG]]] = {
    name_of(one): one for one in pipeline(PassOptions(contract=True))
}
"""Passes from graph to graph, in the order of the pipeline."""

STAGES: Final = (
    *(Stage(name_of(one), "memory: pointers become arrays", Function) for one in RESOLVING),
    *(
        Stage(name_of(one), "LLVM's forms are undone", Function)
        for one in (*STRAIGHTENING, unrotate)
    ),
    *(Stage(name_of(one), "what ranges of values decide", Function) for one in SIMPLIFYING),
    Stage(
        "narrow", "operations of LLVM's become the machine's, 64 bits one or two words", Function
    ),
    *(Stage(name_of(one), "on words", Function) for one in TIDYING),
    Stage("frontend", "from Python or C to SSA, 64 bits to words", Function),
    Stage("cut-parallel-loop", "for an accelerator: a launch deals out its iterations", Function),
    Stage("contract", "products and sums become FMAs", Function),
    Stage("in-format", "float32 arithmetic in the format that --precision asks for", Function),
    Stage(
        "choose",
        "loops transformed as an estimate says it pays; again if that does not map",
        Function,
    ),
    Stage("prepare", "normalised, with numbers of 16 and 8 bits in lanes", Function),
    *(Stage(name_of(one), "shapes the function for cutting", Function) for one in SHAPING),
    Stage("build-kernel", "regions are cut, each with a graph", Kernel),
    *(Stage(name, "on each region's graph", DFG) for name in GRAPH_PASSES),
    Stage("optimize", "all passes on all graphs", Kernel),
    Stage("map", "loops are modulo-scheduled, straight regions list-scheduled", Kernel),
    Stage("encode", "configuration words", Program),
)
"""From a kernel to its program, in processing order. Each is seen by `vividc.host.watch`."""


def text_of(made: object) -> str:
    """What a stage left, as text: SSA, graphs, or words."""
    made = _main(made)
    if isinstance(made, Function):
        return function_text(made)
    if isinstance(made, DFG):
        return graph_text(made)
    if isinstance(made, Program):
        return disassemble(made)
    if isinstance(made, Unmapped):
        return str(made.error)
    assert isinstance(made, Kernel)
    return "\n".join(
        f"# region {index}: {region.kind} {region.header}\n{graph_text(region.dfg)}"
        for index, region in enumerate(made.regions)
    )


def problems_of(made: object) -> list[str]:
    """Broken invariants of what a stage left."""
    made = _main(made)
    if isinstance(made, Function):
        return check_function(made)
    if isinstance(made, DFG):
        return check(made)
    if isinstance(made, Kernel):
        return [problem for region in made.regions for problem in check(region.dfg)]
    return []


def _main(made: object) -> object:
    """What a stage left, without what goes beside it."""
    if isinstance(made, Pointers | narrowing.Narrowed):
        return made.function
    return made[0] if isinstance(made, tuple) else made

"""Functions of words as Python functions: what `interpret` computes, in a hundredth of the time.

Operations are the functions of `machine.semantics`; arrays are lists of words. Constants among
subscripts are not checked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.machine.semantics import SEMANTICS
from vividc.machine.words import WORD_MASK
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value

Run = Callable[..., bool]
"""Of arrays by name, inputs by key, and the most blocks to run: whether it ended within these."""

Watched = Mapping[int, tuple[Value, ...]]
"""Accesses by id, with values that are told of each."""


class Outside(Exception):
    """An access leaves its array."""


def compiled(
    function: Function,
    watched: Watched | None = None,
    touch: Callable[[int, int, tuple[int, ...]], None] | None = None,
) -> Run:
    """A function that runs `function`, whose accesses are of words: `run(arrays, inputs, most)`.

    `touch`: called at each access that is watched, with its id, the byte, and the values.

    Raises when it is run: `Outside`.
    """
    scope: dict[str, object] = {"Outside": Outside, "touch": touch}
    scope |= {_name(op): one for op, one in SEMANTICS.items()}
    exec("\n".join(_Writer(function, watched or {}).lines()), scope)
    made = scope["run"]
    assert callable(made)
    return made


def _name(op: Opcode) -> str:
    return "op_" + op.value.replace(".", "_")


class _Writer:
    def __init__(self, function: Function, watched: Watched) -> None:
        self.function = function
        self.watched = watched
        self.numbers = {block.name: n for n, block in enumerate(function.blocks)}
        self.inputs: dict[str, str] = {}

    def lines(self) -> Iterator[str]:
        """The text."""
        body = list(self._choice(list(self.function.blocks), 3))
        instrs = (i for block in self.function.blocks for i in block.instrs)
        arrays = dict.fromkeys(i.array for i in instrs if i.op in MEMORY)
        yield "def run(arrays, inputs, most):"
        yield from (f" m_{array} = arrays[{array!r}]" for array in arrays)
        yield from (f" {name} = inputs[{key!r}]" for key, name in self.inputs.items())
        yield " at = 0"
        yield " try:"
        yield "  for _ in range(most):"
        yield from body
        yield " except IndexError: raise Outside"
        yield " return False"

    def _choice(self, blocks: list[Block], deep: int) -> Iterator[str]:
        """The block that is next, found by halves."""
        if len(blocks) == 1:
            yield from (" " * deep + line for line in self._block(blocks[0]))
            return
        half = len(blocks) // 2
        yield " " * deep + f"if at < {self.numbers[blocks[half].name]}:"
        yield from self._choice(blocks[:half], deep + 1)
        yield " " * deep + "else:"
        yield from self._choice(blocks[half:], deep + 1)

    def _block(self, block: Block) -> Iterator[str]:
        for instr in block.instrs:
            yield from self._instr(instr)
        branch = block.branch
        if branch.target is None:
            yield "return True"
        elif branch.cond is None:
            yield from self._edge(block.name, branch.target)
        else:
            yield f"if {self._value(branch.cond)}:"
            yield from (" " + line for line in self._edge(block.name, branch.target))
            yield "else:"
            yield from (" " + line for line in self._edge(block.name, str(branch.otherwise)))

    def _edge(self, source: str, target: str) -> Iterator[str]:
        phis = self.function.by_name[target].phis
        if phis:
            values = (self._value(dict(phi.incoming)[source]) for phi in phis)
            yield f"{', '.join(f'v{phi.id}' for phi in phis)} = {', '.join(values)}"
        yield f"at = {self.numbers[target]}"

    def _instr(self, instr: Instr) -> Iterator[str]:
        values = [self._value(operand) for operand in instr.operands]
        if instr.op not in MEMORY:
            yield f"v{instr.id} = {_name(instr.opcode)}({', '.join(values)})"
            return
        assert instr.width == 4
        when = values.pop() if len(values) > OPCODES[instr.opcode].arity + 1 else ""
        at = f"({values[0]} + ({values[1]} << {instr.shift}) + {instr.offset} & {WORD_MASK})"
        cell = f"m_{instr.array}[{at} >> 2]"
        if instr.id in self.watched:
            told = "".join(f"{self._value(value)}, " for value in self.watched[instr.id])
            yield f"{f'if {when}: ' if when else ''}touch({instr.id}, {at}, ({told}))"
        if instr.op is Opcode.LOAD:
            yield f"v{instr.id} = {cell}" + (f" if {when} else 0" if when else "")
        else:
            yield f"{f'if {when}: ' if when else ''}{cell} = {values[2]}"

    def _value(self, value: Value) -> str:
        if isinstance(value, Ref):
            return f"v{value.id}"
        if isinstance(value, Const):
            return str(value.word)
        key = getattr(value, "key", "")
        return self.inputs.setdefault(key, f"in{len(self.inputs)}")

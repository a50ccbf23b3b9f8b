"""The precision policy: which functions of a kernel are computed in which format."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from vividc.errors import ArgumentError, quoted
from vividc.formats import E4M3, E5M2, F16, Format
from vividc.machine.opcodes import Opcode
from vividc.ssa.ir import Function

FUNCTIONS: Final = {"exp": Opcode.EXP, "exp2": Opcode.EXP2}
"""Functions that a policy may name."""
ARITHMETIC: Final = "fma"
"""Names sums, differences, products and fused products of float32."""
_ARITHMETIC: Final = {
    *(Opcode.FADD, Opcode.FSUB, Opcode.FMUL),
    *(Opcode.FMA, Opcode.FMS, Opcode.FNMA),
}
NAMES: Final = (*FUNCTIONS, ARITHMETIC)
ALL: Final = "all"
"""Each of `NAMES` that is not named."""
FORMAT_NAMES: Final[dict[str, Format | None]] = {
    "fp32": None,
    "fp16": F16,
    "fp8": E4M3,
    "e5m2": E5M2,
}
"""Formats by the name a user gives; None: as without a policy."""

FormatChoices = Mapping[str, str]
"""A policy as a user writes it: name of a format by function."""
Precision = tuple[tuple[str, str], ...]
"""A policy: (function, format's name) pairs, each function once, by name."""


def parse_precision(wanted: FormatChoices | None) -> Precision:
    """The policy that a user wants.

    Parameters
    ----------
    wanted
        Name of a format by function, as in {"exp": "fp8"}; what `all` says holds for every function
        that is not named.

    Raises
    ------
    ArgumentError
        An unknown function or format; says what there is.
    """
    if wanted is None:
        return ()
    if not isinstance(wanted, Mapping):
        hint = 'write precision={"exp": "fp8"}'
        raise ArgumentError(f"a precision policy cannot be {quoted(wanted)}", hint=hint)
    for name, fmt in wanted.items():
        if name not in (*NAMES, ALL):
            hint = f"it can be set for {', '.join(NAMES)}; `{ALL}` is each of them"
            raise ArgumentError(f"no precision can be set for {quoted(name, 40)}", hint=hint)
        if not isinstance(fmt, str) or fmt not in FORMAT_NAMES:
            hint = f"formats are {', '.join(FORMAT_NAMES)}"
            raise ArgumentError(f"{quoted(fmt, 40)} of {name} is not a format", hint=hint)
    named = {name: wanted.get(name, wanted.get(ALL)) for name in NAMES}
    return tuple((name, fmt) for name, fmt in named.items() if fmt not in (None, "fp32"))


def formats_of(policy: Precision) -> dict[Opcode, Format]:
    """The format of each opcode that has one."""
    formats = {FUNCTIONS[name]: FORMAT_NAMES[fmt] for name, fmt in policy if name in FUNCTIONS}
    return {opcode: fmt for opcode, fmt in formats.items() if fmt is not None}


def arithmetic_format(policy: Precision) -> Format | None:
    """The format of arithmetic; None: float32."""
    return next((FORMAT_NAMES[fmt] for name, fmt in policy if name == ARITHMETIC), None)


def idle_names(wanted: FormatChoices | None, function: Function) -> tuple[str, ...]:
    """What a policy names and the function does not have."""
    there = {instr.op for block in function.blocks for instr in block.instrs}
    opcodes = {name: {opcode} for name, opcode in FUNCTIONS.items()} | {ARITHMETIC: _ARITHMETIC}
    return tuple(name for name in wanted or () if name in NAMES and not opcodes[name] & there)

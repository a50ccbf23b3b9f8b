"""What an array computes of a product, and the formats of its operands and results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, get_args

from vividc.errors import demand_type
from vividc.formats import FORMATS
from vividc.gemm.systolic.array import SystolicError
from vividc.machine.opcodes import Opcode

Precision = Literal["f32", "f16", "e4m3", "e5m2"]
PRECISIONS: Final[tuple[Precision, ...]] = get_args(Precision)

PRODUCTS: Final[dict[Precision, Opcode]] = {
    "f32": Opcode.FMA,
    "f16": Opcode.DOT_F16X2,
    "e4m3": Opcode.DOT_E4M3X4,
    "e5m2": Opcode.DOT_E5M2X4,
}
"""The operation that adds a word's products to a sum in FP32."""


PACKS: Final[dict[Precision, tuple[Opcode, ...]]] = {
    "f32": (),
    "f16": (Opcode.PACK_F16X2,),
    "e4m3": (Opcode.PACK_E4M3X4, Opcode.PACK_HIGH_E4M3X4),
    "e5m2": (Opcode.PACK_E5M2X4, Opcode.PACK_HIGH_E5M2X4),
}
"""The operations that make a word of neighbouring results: of two, and of two more."""

LARGEST: Final[dict[Precision, Opcode]] = {
    "f32": Opcode.FMAX,
    "f16": Opcode.FMAX_F16X2,
    "e4m3": Opcode.FMAX_E4M3X4,
    "e5m2": Opcode.FMAX_E5M2X4,
}
"""The larger number, of each lane."""


@dataclass(frozen=True, slots=True)
class Form:
    """A product as an array computes it, whatever its rows and columns.

    Attributes
    ----------
    depth
        The inner dimension, in words of the operands: 1 or more.
    relu
        max(x, 0) of every result on its way out.
    precision
        Format of the operands. Sums are FP32.
    results
        Format of what is stored: the drains round it and put neighbouring columns into a word, as
        the next product reads them.
    added
        Sums start from the elements of a matrix, and not from a bias.
    """

    depth: int
    relu: bool = False
    precision: Precision = "f32"
    results: Precision = "f32"
    added: bool = False


def lanes(precision: Precision) -> int:
    """Operands in a word."""
    return 1 if precision == "f32" else FORMATS[precision].lanes


def check_precision(name: str) -> Precision:
    """`name` as a precision.

    Raises
    ------
    SystolicError
        There is no such format of operands.
    """
    demand_type(name, str, "the precision", f"give one of {', '.join(PRECISIONS)}")
    for known in PRECISIONS:
        if name == known:
            return known
    known_names = ", ".join(PRECISIONS)
    raise SystolicError(f"unknown precision {name!r}", hint=f"precisions: {known_names}")

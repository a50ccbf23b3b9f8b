"""The table of number formats: errors of each operation of each format against exact results.

The operations are those that FUs execute (`vividc.machine.semantics`). Exact results are
binary64's: sums and products of two numbers of these formats are exact in it, and what its rounding
adds to the others is below 1e-15.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vividc.formats import FORMATS, Format, round_array, to_floats
from vividc.machine.opcodes import Opcode
from vividc.machine.semantics import evaluate

TITLE = "Errors of operations in FP16 and FP8"
NOTES = (
    "Relative errors, largest and mean. *Alone*: operands are numbers of the format, every pair of",
    "positive codes for FP8 (else 40,000 drawn ones), and the exact result is between the format's",
    "smallest normal and its largest number; rounding once keeps the error within `bound`. *With",
    "operands*: the operands are FP32 numbers, log-uniform in [1/4, 4), and are rounded to the",
    "format first. `convert`: FP32 numbers, log-uniform over the format's normal numbers.",
    "`subnormal`: FP32 numbers uniform below the smallest normal number; errors in units of the",
    "smallest number. `dot 256`: 256 products of normally distributed operands (standard deviation",
    "1, rounded first), summed into FP32 by `dot`; *alone* against the exact sum of the rounded",
    "operands' products, *with operands* against that of the FP32 operands, both over the sum of",
    "the products' magnitudes. Minima, maxima, comparisons and conversions to FP32 are exact.",
)
HEADER = (
    "| format | operation | bound | alone, largest | alone, mean | with operands, largest "
    "| with operands, mean |\n|---|---|---|---|---|---|---|"
)
_COUNT = 40_000
_DOTS = 400
_LENGTH = 256

Floats = npt.NDArray[np.float64]
Codes = npt.NDArray[np.unsignedinteger[Any]]


@dataclass(frozen=True)
class Errors:
    """Relative errors, and how large they may be."""

    bound: float | None
    alone: Floats
    with_operands: Floats | None

    def row(self, fmt: Format, name: str) -> str:
        """A line of the table."""
        bound = "-" if self.bound is None else f"{self.bound:.3g}"
        cells = [*_two(self.alone), *_two(self.with_operands)]
        return f"| {fmt.name} | {name} | {bound} | {' | '.join(cells)} |"


def _two(errors: Floats | None) -> tuple[str, str]:
    if errors is None:
        return "-", "-"
    return f"{errors.max():.3g}", f"{errors.mean():.3g}"


def rows() -> Iterator[str]:
    """A line for each operation of each format."""
    for fmt in FORMATS.values():
        for name in _ARITHMETIC:
            yield arithmetic(fmt, name).row(fmt, name)
        yield conversion(fmt).row(fmt, "convert")
        yield _subnormal(fmt).row(fmt, "subnormal")
        yield _dots(fmt).row(fmt, f"dot {_LENGTH}")


_ARITHMETIC: dict[str, tuple[Callable[..., Floats], int]] = {
    "fadd": (lambda a, b: a + b, 2),
    "fmul": (lambda a, b: a * b, 2),
    "fma": (lambda a, b, c: a * b + c, 3),
}


def arithmetic(fmt: Format, name: str) -> Errors:
    """Errors of "fadd", "fmul" or "fma"."""
    function, arity = _ARITHMETIC[name]
    op = Opcode(f"{name}.{fmt.name}x{fmt.lanes}")
    codes = _operands(fmt, arity)
    exact = function(*(_values(fmt, column) for column in codes))
    normal = (exact >= fmt.min_normal) & (exact <= fmt.max_finite)
    alone = np.abs(_values(fmt, _on_lanes(fmt, op, codes)) - exact)[normal] / exact[normal]
    given = [np.exp2(column) for column in _random(name).uniform(-2, 2, (arity, _COUNT))]
    given = [column.astype(np.float32).astype(np.float64) for column in given]
    got = _values(fmt, _on_lanes(fmt, op, [round_array(fmt, column) for column in given]))
    wanted = function(*given)
    return Errors(_bound(fmt), alone, np.abs(got - wanted) / wanted)


def _operands(fmt: Format, arity: int) -> list[Codes]:
    """Positive finite operands: every pair, or drawn ones."""
    count = fmt.max_code + 1
    if arity == 2 and fmt.bits == 8:  # noqa: PLR2004 - pairs of FP8 codes
        pairs = np.divmod(np.arange(count * count // 4 * 4), count)
        return [column.astype(fmt.dtype) for column in pairs]
    drawn = _random(fmt.name).integers(0, count, (arity, _COUNT))
    return [column.astype(fmt.dtype) for column in drawn]


def _bound(fmt: Format) -> float:
    """Largest relative error of rounding once: that of half a last place above a power of two."""
    return fmt.epsilon / (1 + fmt.epsilon)


def conversion(fmt: Format) -> Errors:
    """Errors of rounding FP32 numbers."""
    low, high = np.log2(fmt.min_normal), np.log2(fmt.max_finite)
    given = np.exp2(_random("convert").uniform(low, high, _COUNT)).astype(np.float32)
    got = _values(fmt, _truncated(fmt, given))
    return Errors(_bound(fmt), np.abs(got - given) / given, None)


def _subnormal(fmt: Format) -> Errors:
    given = _random("subnormal").uniform(0, fmt.min_normal, _COUNT).astype(np.float32)
    got = _values(fmt, _truncated(fmt, given))
    return Errors(0.5, np.abs(got - given) / fmt.min_subnormal, None)


def _dots(fmt: Format) -> Errors:
    op = Opcode(f"dot.{fmt.name}x{fmt.lanes}")
    given = _random("dot").standard_normal((2, _DOTS, _LENGTH)).astype(np.float32)
    codes = round_array(fmt, given)
    words = np.ascontiguousarray(codes).view(np.uint32)
    totals = []
    for left, right in zip(words[0].tolist(), words[1].tolist(), strict=True):
        total = 0
        for a, b in zip(left, right, strict=True):
            total = evaluate(op, (a, b, total))
        totals.append(total)
    got = np.array(totals, np.uint32).view(np.float32).astype(np.float64)
    alone, with_operands = (
        np.abs(got - (a * b).sum(axis=1)) / np.abs(a * b).sum(axis=1)
        for a, b in (_values(fmt, codes), given.astype(np.float64))
    )
    return Errors(None, alone, with_operands)


def _truncated(fmt: Format, numbers: npt.NDArray[np.float32]) -> Codes:
    op = Opcode(f"fptrunc.{fmt.name}")
    words = numbers.view(np.uint32).tolist()
    return np.array([evaluate(op, (word,)) for word in words], fmt.dtype)


def _on_lanes(fmt: Format, op: Opcode, columns: list[Codes]) -> Codes:
    """Results of an operation, a word of lanes at a time."""
    words = [np.ascontiguousarray(column).view(np.uint32).tolist() for column in columns]
    results = [evaluate(op, row) for row in zip(*words, strict=True)]
    return np.array(results, np.uint32).view(fmt.dtype)


def _values(fmt: Format, codes: Codes) -> Floats:
    return to_floats(fmt, codes).astype(np.float64)


def _random(name: str) -> np.random.Generator:
    return np.random.default_rng(list(name.encode()))

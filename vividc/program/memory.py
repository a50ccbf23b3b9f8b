"""Where a launch's arrays lie in the scratchpad."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from collections.abc import Mapping as ReadOnly
from itertools import accumulate

from vividc.arch.fabric import Scratchpad
from vividc.errors import ArgumentError
from vividc.machine.params import TRAP
from vividc.machine.words import WORD_BYTES
from vividc.ssa.ir import pitch_of


def trapped(array: str) -> str | None:
    """The exception that an access to the array of this name stands for, None if it is none."""
    if not array.startswith(TRAP):
        return None
    return array.removeprefix(TRAP).replace(".", ": ").replace("_", " ")


def pitches_of(
    wishes: ReadOnly[str, int],
    shapes: ReadOnly[str, Sequence[int]],
    around: ReadOnly[str, int] | None = None,
) -> dict[str, int]:
    """Elements from one row to the next of each matrix of `wishes`: the least that is as wished
    modulo what all banks hold of it (`around`, in elements); None: what the rows take.
    """
    columns = {name: shapes[name][1] for name in wishes}
    if around is None:
        return columns
    return {name: n + (wishes[name] - n) % around[name] for name, n in columns.items()}


def pitch_words(pitches: ReadOnly[str, int]) -> dict[str, int]:
    """Pitches as launch words."""
    return {pitch_of(name, 1).key: pitch for name, pitch in pitches.items()}


def place_arrays(
    arrays: Sequence[tuple[str, int]],
    scratchpad: Scratchpad,
    banks: ReadOnly[str, int] | None = None,
) -> dict[str, int]:
    """Byte address of each array.

    Each array starts in the bank that `banks` asks for (see `choose_layout`), array j without a
    wish in bank j mod banks, so that accesses to several arrays at one index meet in no bank
    (structures of arrays). If the gaps this leaves do not fit, the arrays are packed without them.

    Parameters
    ----------
    arrays
        (name, size in 32-bit words), in the order of the kernel's parameters.

    Raises
    ------
    ArgumentError
        The arrays need more bytes than the scratchpad has.
    """
    sizes = [words for _, words in arrays]
    needed = sum(sizes)
    if needed > scratchpad.words:
        raise ArgumentError(
            f"the arrays need {needed * WORD_BYTES} bytes and the scratchpad has "
            f"{scratchpad.size_bytes}: "
            + ", ".join(f"{name} {words * WORD_BYTES}" for name, words in arrays if words),
            hint="run the kernel on pieces of the arrays that fit together",
        )
    wishes = banks or {}
    wanted = [wishes.get(name, j) for j, (name, _) in enumerate(arrays)]
    starts, end = _staggered(sizes, wanted, scratchpad.banks)
    if end > scratchpad.words:
        starts = list(accumulate(sizes, initial=0))[:-1]
    return {name: start * WORD_BYTES for (name, _), start in zip(arrays, starts, strict=True)}


def _staggered(sizes: Iterable[int], wanted: Sequence[int], banks: int) -> tuple[list[int], int]:
    starts = []
    end = 0
    for bank, words in zip(wanted, sizes, strict=True):
        start = end + (bank - end) % banks
        starts.append(start)
        if words:
            end = start + words
    return starts, end

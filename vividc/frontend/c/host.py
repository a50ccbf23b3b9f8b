"""A C kernel on the host, compiled by LLVM from the same `.ll` file: the reference that `--check`
and the tests compare with.

It shares with the compiler no more than the reading of the file: the instructions are those that
clang wrote, with 64-bit pointers, 64-bit integers and doubles. They run in a process of their own,
on copies of the arrays (`reference`, `llvm.child`).
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from vividc.errors import ArgumentError, InternalError, KernelError, SourceLoc, TimeLimit
from vividc.frontend.c.reference import ReferenceText
from vividc.frontend.llvm.child.client import MEMORY_BYTES, Late, Lost, ask

LIMIT_S = 600.0
"""What one call may take."""
_Array = npt.NDArray[Any]
_FAULT_HINT = "give larger arrays, or other numbers: C would do anything here"
_DIED_HINT = "it does what C leaves undefined, such as a division by 0"


class HostFunction:
    """A function of a module, run by this computer."""

    def __init__(
        self,
        reference: ReferenceText,
        params: Sequence[str],
        returns: str,
        *,
        unsigned: bool,
        loc: SourceLoc,
    ) -> None:
        """`params`, `returns`: LLVM types. `unsigned`: of the returned integer."""
        self._reference = reference
        self._request = {
            "do": "run",
            "text": reference.text,
            "params": list(params),
            "returns": returns,
            "unsigned": unsigned,
        }
        self._loc = loc

    def __call__(self, *args: object) -> object:
        """Run it on checked arguments; arrays are updated in place.

        Raises
        ------
        KernelError
            It accesses memory outside its arrays, does what C leaves undefined, or dies.
        TimeLimit
            It takes more than `LIMIT_S`.
        ArgumentError
            It changed an array that cannot be written.
        """
        arrays = [arg for arg in args if isinstance(arg, np.ndarray)]
        blocks = _blocks(arrays)
        blobs = [ctypes.string_at(start, size) for start, size in blocks]
        request = {**self._request, "arguments": [_argument(arg, blocks) for arg in args]}
        memory = MEMORY_BYTES + 3 * sum(map(len, blobs))
        try:
            answer, after = ask(request, blobs, limit_s=LIMIT_S, memory_bytes=memory)
        except Late as late:
            reason = f"the reference takes more than {LIMIT_S:.0f} s on this computer"
            raise TimeLimit(reason, loc=self._loc, hint="try smaller arrays") from late
        except Lost as lost:
            reason = f"the reference dies ({str(lost) or 'LLVM gives up'}) on this computer"
            raise KernelError(reason, loc=self._loc, hint=_DIED_HINT) from lost
        if "error" in answer:
            raise self._failure(answer)
        _refuse_changes(arrays, blocks, blobs, after)
        for (start, _), blob, new in zip(blocks, blobs, after, strict=True):
            if new != blob:
                ctypes.memmove(start, new, len(new))
        result: object = answer["value"]
        return result

    def _failure(self, answer: dict[str, Any]) -> Exception:
        if answer["kind"] == "memory":
            reason = "the reference takes too much memory on this computer"
            return KernelError(reason, loc=self._loc, hint="try smaller arrays")
        if answer["kind"] != "fault":
            return InternalError(f"LLVM cannot read the reference: {answer['error']}")
        fault = self._reference.faults[answer["place"]]
        reason = f"the reference {fault.reason}"
        return KernelError(reason, loc=fault.loc or self._loc, hint=_FAULT_HINT)


def _address(array: _Array) -> int:
    return int(array.__array_interface__["data"][0])


def _blocks(arrays: Sequence[_Array]) -> list[tuple[int, int]]:
    """Address and size of each stretch of memory that the arrays take: those that overlap stay
    together.
    """
    merged: list[tuple[int, int]] = []
    for start, size in sorted({(_address(array), array.nbytes) for array in arrays}):
        if merged and start < sum(merged[-1]):
            first, length = merged[-1]
            merged[-1] = (first, max(length, start + size - first))
        else:
            merged.append((start, size))
    return merged


def _argument(value: object, blocks: list[tuple[int, int]]) -> object:
    if isinstance(value, np.ndarray):
        return _place(value, blocks)
    return value.item() if isinstance(value, np.generic) else value


def _place(array: _Array, blocks: list[tuple[int, int]]) -> tuple[int, int, int]:
    """The array's block, the offset in it, and its size."""
    at = _address(array)
    number = next(
        number
        for number, (start, size) in enumerate(blocks)
        if start <= at and at + array.nbytes <= start + size
    )
    return number, at - blocks[number][0], array.nbytes


def _refuse_changes(
    arrays: Sequence[_Array],
    blocks: list[tuple[int, int]],
    before: Sequence[bytes],
    after: Sequence[bytes],
) -> None:
    """Memory of an array that may not be written stays as it is."""
    for array in arrays:
        if array.flags.writeable:
            continue
        number, offset, size = _place(array, blocks)
        if before[number][offset : offset + size] != after[number][offset : offset + size]:
            raise ArgumentError("the kernel writes an array that is read-only", hint="pass a copy")

"""`--check`: the kernel on the host (through numba, or LLVM for C) on the same inputs, compared
with what the machine gave.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from vividc.cli.arrays import Array, describe
from vividc.cli.kernels import kernel_file, load_kernel, load_kernel_of
from vividc.cli.say import say
from vividc.errors import ArgumentError, printable, quoted
from vividc.frontend import KernelFunction, LLKernel
from vividc.host.compiled_files import is_noted
from vividc.machine.params import Param, given
from vividc.program import Program

_LONGEST: Final = 200
"""Characters of a file's name in a message."""

AnyKernel = KernelFunction | LLKernel


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Floats agree if |simulated - reference| <= atol + rtol * |reference|; integers if equal."""

    rtol: float
    atol: float


@dataclass(frozen=True, slots=True)
class Mismatch:
    """An array, or `return`, that differs: its first differing element, and how many there are."""

    name: str
    index: tuple[int, ...]
    simulated: object
    reference: object
    count: int

    def __str__(self) -> str:
        where = self.name + (f"[{', '.join(map(str, self.index))}]" if self.index else "")
        more = f" ({self.count} elements differ)" if self.count > 1 else ""
        return f"{where} is {self.simulated}, the reference gives {self.reference}{more}"


def find_kernel(program: Program, bundle: Path, spec: str | None) -> AnyKernel:
    """The kernel to compare with: `spec` if given, else the file that the bundle was compiled from.

    It runs the file, and says so first. The bundle only records the file's path and hash, and may
    be from anyone, with a file beside it: that counts if it still has that hash, and this user
    compiled it at its place.

    Raises
    ------
    ArgumentError
        The file is gone, was changed, or was not compiled here, or the kernel has other parameters
        than the program.
    """
    if spec is None:
        file = _own_file(program, bundle)
        say(f"vividc: --check runs {os.path.abspath(file)}", err=True)
        # Apart: a name may hold what looks like the end of a path.
        kernel = load_kernel_of(file, program.name, program.provenance.kernel_sha256)
    else:
        say(f"vividc: --check runs {os.path.abspath(kernel_file(spec))}", err=True)
        kernel = load_kernel(spec)
    params = given(program.params)
    if _of_any_size(kernel.params) != _of_any_size(params):
        expected = ", ".join(describe(param) for param in params)
        reason = f"`{kernel.name}` in {kernel.file} does not have the program's parameters"
        raise ArgumentError(reason, loc="--check", hint=f"expected: {expected}")
    return kernel


def _of_any_size(params: Sequence[Param]) -> tuple[Param, ...]:
    return tuple(replace(param, known=()) for param in params)


def run_reference(
    kernel: AnyKernel, arguments: Mapping[str, Array]
) -> tuple[dict[str, Array], object]:
    """Arguments after a run on the host on copies of them, and the returned value."""
    copies = {name: array.copy() for name, array in arguments.items()}
    value = kernel(*scalars_unpacked(copies, kernel.params))
    return copies, value


def scalars_unpacked(arguments: Mapping[str, Array], params: Sequence[Param]) -> list[object]:
    """Arguments in order, 0-d arrays as numpy scalars of the parameter's type."""
    return [
        arguments[param.name] if param.ndim else arguments[param.name].astype(param.dtype.value)[()]
        for param in params
    ]


def mismatches(
    simulated: Mapping[str, Array], reference: Mapping[str, Array], tolerance: Tolerance
) -> list[Mismatch]:
    """Arrays that differ, in the order of `simulated`."""
    found = []
    for name in dict.fromkeys([*simulated, *reference]):
        one, other = simulated.get(name), reference.get(name)
        if one is None or other is None or one.shape != other.shape:
            found.append(Mismatch(name, (), _shape(one), _shape(other), 1))
        elif (item := _mismatch(name, one, other, tolerance)) is not None:
            found.append(item)
    return found


def _shape(array: Array | None) -> str:
    return "None" if array is None else f"an array of shape {array.shape}"


def _mismatch(name: str, found: Array, expected: Array, tolerance: Tolerance) -> Mismatch | None:
    if found.dtype.kind in "fc":
        wide = np.float64 if found.dtype.kind == "f" else np.complex128
        close = np.isclose(
            found.astype(wide),
            expected.astype(wide),
            rtol=tolerance.rtol,
            atol=tolerance.atol,
            equal_nan=True,
        )
    else:
        close = found == expected
    wrong = np.argwhere(~np.atleast_1d(close))
    if not len(wrong):
        return None
    index = tuple(int(axis) for axis in wrong[0]) if found.ndim else ()
    return Mismatch(name, index, found[index], expected[index], len(wrong))


def _own_file(program: Program, bundle: Path) -> Path:
    recorded = program.provenance.kernel_file
    suffix = ".ll" if recorded.endswith(".ll") else ".py"
    named = printable(f"FILE{suffix}:{program.name}")
    if not recorded:
        hint = f"name it: --source {named}"
        raise ArgumentError(f"{bundle} records no source", loc="--check", hint=hint)
    digest = program.provenance.kernel_sha256
    likely = (Path(recorded), bundle.parent / recorded, bundle.parent / Path(recorded).name)
    # `Path.is_file` raises for names that are too long, and folders that cannot be entered.
    places = [place for place in dict.fromkeys(likely) if os.path.isfile(place)]
    unchanged = [place for place in places if _sha256(place) == digest]
    for place in unchanged:
        if is_noted(place, digest):
            return place
    if unchanged:
        found = printable(str(unchanged[0]))
        fate = f"{found} was not compiled there by you on this computer"
        hint = f"it would be run: if you trust it, --source {found}:{printable(program.name)}"
    else:
        fate = f"{quoted(recorded, _LONGEST)[1:-1]} was not found"
        fate = f"{printable(str(places[0]))} was changed since" if places else fate
        hint = f"name it: --source {named}"
    raise ArgumentError(f"the kernel's source: {fate}", loc="--check", hint=hint)


def _sha256(file: Path) -> str | None:
    try:
        with file.open("rb") as opened:
            return hashlib.file_digest(opened, "sha256").hexdigest()
    except OSError:
        return None

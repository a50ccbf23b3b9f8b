"""Kernels in a user's Python or `.ll` file: runs the file as a module and finds its kernels."""

from __future__ import annotations

import hashlib
import os
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from types import CodeType, ModuleType
from typing import Final

from vividc.errors import InternalError, KernelError, SourceLoc, VividcError
from vividc.frontend import KernelFunction, LLKernel, load_ll
from vividc.host.inputs import SOURCE_BYTES, demand_utf8_path, read_bytes

_SUFFIX: Final = ".py"
_LL: Final = ".ll"
_RUNNING: Final = "VIVIDC_RUNNING_FILES"
"""Files that this process and those above it are running; inherited by what they start."""


def load_kernel(spec: str) -> KernelFunction | LLKernel:
    """The kernel that `FILE.py` or `FILE.py:KERNEL` names, or the C function of a `.ll` file.

    Raises
    ------
    KernelError
        The path is not UTF-8; the file cannot be read or fails when it runs (with its line); it
        has no such kernel, or several and none is named.
    """
    return load_kernel_of(*_split(spec))


def load_kernel_of(
    file: Path, name: str | None, sha256: str | None = None
) -> KernelFunction | LLKernel:
    """The kernel `name` of a file; as `load_kernel`.

    Parameters
    ----------
    sha256
        What the hash of a Python file has to be; of any other nothing runs.
    """
    demand_utf8_path(file, KernelError)
    if file.suffix == _LL:
        return load_ll(file, name)
    kernels = _kernels(_run(file, sha256))
    if name is not None:
        return _named(kernels, name, file)
    return _only(_unique(kernels, file), file)


def kernels_of(file: Path) -> list[KernelFunction]:
    """The kernels of a Python file.

    Raises
    ------
    KernelError
        It is no Python file, cannot be read, or fails when it runs.
    """
    demand_utf8_path(file, KernelError)
    return [*_unique(_kernels(_run(file, None)), file).values()]


def kernel_file(spec: str) -> Path:
    """The file of `FILE` or `FILE:KERNEL`."""
    return _split(spec)[0]


def _split(spec: str) -> tuple[Path, str | None]:
    head, colon, tail = spec.rpartition(":")
    named = colon and head.endswith((_SUFFIX, _LL))
    return (Path(head), tail) if named else (Path(spec), None)


def _run(file: Path, sha256: str | None) -> ModuleType:
    """Execute `file` as a module, with its folder on the import path as for a script."""
    code = _compiled(file, sha256)
    module = ModuleType(f"_vividc_kernel_{file.stem}")
    module.__file__ = os.path.abspath(file)
    sys.modules[module.__name__] = module
    with _once(file), _imports_from(file.resolve().parent), redirect_stdout(sys.stderr):
        try:
            exec(code, module.__dict__)
        except (VividcError, InternalError):
            raise
        except (Exception, SystemExit) as error:  # a user's file may raise anything
            raise _as_kernel_error(error, file) from error
    return module


def _compiled(file: Path, sha256: str | None = None) -> CodeType:
    """From the text and never from a .pyc, which may be older than an edit of the same second."""
    hint = "the form is FILE.py or FILE.py:KERNEL"
    source = read_bytes(file, SOURCE_BYTES, KernelError, hint)
    if sha256 is not None and hashlib.sha256(source).hexdigest() != sha256:
        raise KernelError("was changed just now", loc=str(file), hint="try again")
    try:
        # Absolute, as an import would have it: the program records it, for runs from other folders.
        return compile(source, os.path.abspath(file), "exec", dont_inherit=True)
    except SyntaxError as error:
        raise KernelError(
            f"not Python: {error.msg}", loc=SourceLoc(str(file), error.lineno or 1)
        ) from error
    except ValueError as error:
        raise KernelError(f"not Python: {error}", loc=str(file)) from error
    except (RecursionError, MemoryError) as error:
        raise KernelError("nested too deeply to be compiled", loc=str(file)) from error


@contextmanager
def _once(file: Path) -> Iterator[None]:
    """Refuse a file that starts vividc on itself while it runs: that would never end."""
    path = str(file.resolve())
    running = os.environ.get(_RUNNING, "")
    if path in running.split(os.pathsep):
        hint = 'put what is not needed to define its kernels under `if __name__ == "__main__":`'
        raise KernelError("starts vividc on itself when it is run", loc=str(file), hint=hint)
    os.environ[_RUNNING] = f"{running}{os.pathsep}{path}"
    try:
        yield
    finally:
        os.environ[_RUNNING] = running


@contextmanager
def _imports_from(folder: Path) -> Iterator[None]:
    before = list(sys.path)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path[:] = before


def _as_kernel_error(error: BaseException, file: Path) -> KernelError:
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == os.path.abspath(file)]
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    hint = "the file is run to find its kernels; it must be importable"
    return KernelError(what, loc=SourceLoc(str(file), (lines and lines[-1]) or 1), hint=hint)


def _kernels(module: ModuleType) -> dict[str, KernelFunction]:
    return {name: item for name, item in vars(module).items() if isinstance(item, KernelFunction)}


def _unique(kernels: Mapping[str, KernelFunction], file: Path) -> dict[str, KernelFunction]:
    """One name for each kernel; those of the file itself hide those that it imports."""
    names: dict[int, str] = {}
    for name, kernel in kernels.items():
        names.setdefault(id(kernel), name)
    unique = {name: kernels[name] for name in names.values()}
    own = {name: item for name, item in unique.items() if _is_of(item, file)}
    return own or unique


def _is_of(kernel: KernelFunction, file: Path) -> bool:
    return Path(kernel.file).resolve() == file.resolve()


def _named(kernels: Mapping[str, KernelFunction], name: str, file: Path) -> KernelFunction:
    by_own_name = {kernel.name: kernel for kernel in kernels.values()}
    chosen = kernels.get(name) or by_own_name.get(name)
    if chosen is None:
        known = ", ".join(kernels) or "none"
        raise KernelError(f"has no kernel `{name}`", loc=str(file), hint=f"its kernels: {known}")
    return chosen


def _only(kernels: Mapping[str, KernelFunction], file: Path) -> KernelFunction:
    if not kernels:
        hint = 'mark a function with `@vividc.kernel("void(float32[::1], int32)")`'
        raise KernelError("has no kernel", loc=str(file), hint=hint)
    if len(kernels) > 1:
        names = ", ".join(kernels)
        hint = f"choose one: {file}:{next(iter(kernels))}"
        raise KernelError(f"has several kernels: {names}", loc=str(file), hint=hint)
    return next(iter(kernels.values()))

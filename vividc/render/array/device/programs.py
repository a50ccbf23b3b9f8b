"""Programs of the stages: kernels of `kernels/`, compiled once and kept on disk."""

from __future__ import annotations

import importlib.util
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Final

import vividc
from vividc.errors import TimeLimit, VividcError, VividcWarning
from vividc.program import kept
from vividc.render.array.device.kernels import Options, options_of
from vividc.render.errors import SceneError

_PACKAGE: Final = Path(vividc.__file__).resolve().parent
_KIND: Final = "stage"
SHIPPED: Final = _PACKAGE / "programs"
"""Compiled programs in an installed vividc; a checkout has none."""

_LATE: Final = "the clock ended the search for a mapping"
_AGAIN: Final = "run it again when the machine is less busy; programs already compiled are kept"

_PATIENCE: Final = 100.0
"""Times the limit that the clock allows: on a busy machine the words are to be the same. Ten times
30 s were over on two cores at a load of 8 while `splat_footprints` was mapped."""


@dataclass(slots=True)
class Programs:
    """Compiled kernels by name, for the tiles of one accelerator.

    A program is kept in the user's cache under the kernel's file, the tile, the options and the
    compiler's own source. A damaged one is compiled again. An installed vividc has those of its
    renderers with it, under the same keys (`ship`).

    Attributes
    ----------
    machine
        What the kernels are compiled for.
    tell
        Called with a line for each kernel that has to be compiled.
    mapping_s
        Seconds for mapping a kernel.
    common
        Options of `vividc.compile` for kernels that have none of their own.
    """

    machine: vividc.arch.Accelerator
    tell: Callable[[str], None] | None = None
    mapping_s: float = 20.0
    common: Options = field(default_factory=dict)
    _loaded: dict[str, vividc.Program] = field(default_factory=dict)

    def get(self, kernel: str, **options: object) -> vividc.Program:
        """Return the program of `kernel`, as in "render/rays:pixel_rays".

        Parameters
        ----------
        options
            Of `vividc.compile`, beside those that the kernel always has (`options_of`).

        Raises
        ------
        SceneError
            There is no such kernel.
        VividcError
            It cannot be compiled for this accelerator.
        """
        if not self.is_at_hand(kernel, **options):
            every = self._all_options(kernel, options)
            self._loaded[_name(kernel, every)] = self._made(kernel, every)
        return self._loaded[_name(kernel, self._all_options(kernel, options))]

    def is_at_hand(self, kernel: str, **options: object) -> bool:
        """Whether a kernel need not be compiled; its program is loaded then.

        Raises
        ------
        SceneError
            The kernel's file cannot be read.
        """
        name = _name(kernel, self._all_options(kernel, options))
        if name not in self._loaded:
            key = self._key_of(kernel, options)
            made = kept.read_program(_KIND, key) or kept.read_shipped(SHIPPED, key)
            if made is None:
                return False
            self._loaded[name] = made
        return True

    def ship(self, folder: Path, kernel: str, **options: object) -> None:
        """Write the program of a kernel to a folder that becomes `programs/` of a package.

        Raises
        ------
        VividcError
            It cannot be compiled or written, or the clock ended the search for a mapping.
        """
        program = self.get(kernel, **options)
        if program.hurried:
            raise VividcError(f"{program.name}: {_LATE}", hint="do it on a less busy machine")
        kept.write_shipped(folder, self._key_of(kernel, options), program, _PACKAGE.parent)

    def _key_of(self, kernel: str, options: Options) -> str:
        """Return what the program of a kernel is known by, the same on every machine."""
        file, function = _place(kernel)
        return self._key(file, function, self._all_options(kernel, options))

    def _all_options(self, kernel: str, options: Options) -> Options:
        usual: Options = {"time_limit_s": self.mapping_s, "effort": "thorough", **self.common}
        return {**usual, **options_of(kernel), **options}

    @property
    def late(self) -> tuple[str, ...]:
        """One line for each loaded program whose mapping the time limit cut short: a less busy
        machine may map it differently.
        """
        programs = self._loaded.values()
        return tuple(f"{one.name}: {_LATE}" for one in programs if one.hurried)

    def _made(self, kernel: str, options: Options) -> vividc.Program:
        """Compile a kernel, and keep its program."""
        file, function = _place(kernel)
        key = self._key(file, function, options)
        self._say(f"compiling {kernel} (kept for the next time)")
        program = self._compile(file, function, options)
        if program.hurried:
            self._say(f"{kernel}: {_LATE}; not kept: it is compiled again")
        else:
            kept.write_program(_KIND, key, program)
        return program

    def _say(self, line: str) -> None:
        if self.tell is not None:
            self.tell(line)

    def _compile(self, file: Path, function: str, options: Options) -> vividc.Program:
        kernel = getattr(kernel_module(file), function, None)
        if not isinstance(kernel, vividc.KernelFunction):
            raise SceneError(f"has no kernel `{function}`", loc=str(file))
        try:
            with warnings.catch_warnings(), vividc.patient(_PATIENCE):
                warnings.simplefilter("ignore", VividcWarning)
                compiled: vividc.Program = vividc.compile(
                    kernel,
                    self.machine,
                    cache=False,  # it is kept here, for all tiles of a kind
                    **options,  # type: ignore[arg-type]
                )
        except TimeLimit as error:
            raise TimeLimit(error.reason, loc=error.loc, hint=_AGAIN) from error
        return compiled

    def _key(self, file: Path, function: str, options: Options) -> str:
        """Return the cache key of a program."""
        parts = (
            function,
            kept.text_of(self.machine.fabric),
            repr(sorted(options.items())),
            kept.source_digest(*kept.COMPILER),
        )
        digest = sha256("\n".join(parts).encode())
        digest.update(_source(file))
        return digest.hexdigest()


def _name(kernel: str, options: Options) -> str:
    return f"{kernel} {sorted(options.items())}"


def _place(kernel: str) -> tuple[Path, str]:
    """Return a kernel's file and its name there."""
    path, _, function = kernel.partition(":")
    return kernel_folder() / f"{path}.py", function


def kernel_folder() -> Path:
    """Return where the kernels are: inside the installed package, or beside it in a checkout.

    Raises
    ------
    SceneError
        They were not installed.
    """
    for folder in (_PACKAGE / "kernels", _PACKAGE.parent / "kernels"):
        if (folder / "render").is_dir():
            return folder
    raise SceneError(
        "the rendering kernels are not installed", loc=str(_PACKAGE), hint="install vividc again"
    )


@cache
def kernel_module(file: Path) -> ModuleType:
    """Run a kernel file as a module."""
    name = f"_vividc_kernels_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _source(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}", loc=str(file)) from error

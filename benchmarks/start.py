"""What a newcomer waits for: commands in processes of their own, with empty caches and again."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

TITLE: Final = "The first five minutes"
NOTES: Final = """\
Each command runs in a process of its own. Cold: caches of vividc and numba are empty, and nothing
else has run there; warm: once more after it. Bytecode is written at installation. `cpu`: seconds
of user CPU of the process and its children, which an idle machine spreads over its cores. Frames
are of `mic` at 200x200 in FP8, every pixel simulated. "As installed": of the caches, those kernels
are left that a wheel has with it (`make wheel`).
""".splitlines()
HEADER: Final = "| command | cold s | cold cpu s | warm s | warm cpu s |\n|---|---|---|---|---|"
_ROOT: Final = Path(__file__).resolve().parents[1]
_VIVIDC: Final = (sys.executable, "-m", "vividc")
_KERNELS: Final = (
    "kernels/dot.py",
    "kernels/fir.py",
    "kernels/gs_blend.py",
    "kernels/render/encodings.py:hash_level",
    "kernels/general/linear_algebra.py:gemm",
    "kernels/general/searching.py:shell_sort",
)
_SCENES: Final = {
    "3dgs": "mic_3dgs_sh3.ply",
    "kilonerf": "mic_kilonerf.npz",
    "instant-ngp": "mic_ngp_hash.npz",
    "tensorf": "mic_tensorf_vm.npz",
}
_FRAME: Final = ("--engine", "array", "--precision", "fp8", "--size", "200x200")
_SYSTOLIC: Final = """\
import numpy as np
from vividc.gemm import Layer, mlp
x = np.ones((64, 32), np.float32)
mlp(x, [Layer(np.ones((32, 16), np.float32))], mode="tpu-unified")
"""


@dataclass(frozen=True, slots=True)
class Times:
    """Of a command: seconds on the clock and of CPU."""

    wall: float
    cpu: float


def rows(*_: object) -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    with tempfile.TemporaryDirectory() as out:
        for name, command in _commands(Path(out)).items():
            with tempfile.TemporaryDirectory() as home:
                cold, warm = (timed(command, home) for _ in range(2))
            yield _row(name, cold, warm)
        for method, file in _SCENES.items():
            scene, picture = f"scenes/mic/{file}", str(Path(out) / "frame.png")
            command = (*_VIVIDC, "render", scene, *_FRAME, "-o", picture)
            with tempfile.TemporaryDirectory() as home:
                cold, warm = (timed(command, home) for _ in range(2))
                yield _row(f"vividc render, {method}", cold, warm)
                for entry in Path(home).rglob("entries/*"):
                    if not entry.name.startswith("stage-"):
                        entry.unlink()
                yield _row(f"vividc render, {method}, as installed", timed(command, home), warm)


def _row(name: str, cold: Times, warm: Times) -> str:
    cells = (f"{n:.2f}" for n in (cold.wall, cold.cpu, warm.wall, warm.cpu))
    return f"| {name} | {' | '.join(cells)} |"


def _commands(out: Path) -> Mapping[str, Sequence[str]]:
    """What is run, by what the table calls it."""
    found: dict[str, Sequence[str]] = {
        "import vividc": (sys.executable, "-c", "import vividc"),
        "vividc --version": (*_VIVIDC, "--version"),
        "vividc --help": (*_VIVIDC, "--help"),
        "vividc list kernels kernels/dot.py": (*_VIVIDC, "list", "kernels", "kernels/dot.py"),
    }
    for kernel in _KERNELS:
        if (_ROOT / kernel.partition(":")[0]).is_file():
            path = str(out / "out.vivid")
            found[f"vividc compile {kernel}"] = (*_VIVIDC, "compile", kernel, "-o", path)
    found["the first product in a TPU-like mode"] = (sys.executable, "-c", _SYSTOLIC)
    return found


def timed(command: Sequence[str], home: str) -> Times:
    """Run a command to its end in the checkout, with caches in `home`.

    Raises
    ------
    subprocess.CalledProcessError
        It failed.
    """
    kept = {name: home for name in ("HOME", "XDG_CACHE_HOME", "XDG_STATE_HOME")}
    settings = {key: value for key, value in os.environ.items() if not key.startswith("VIVIDC_")}
    before, start = os.times(), time.perf_counter()
    subprocess.run(command, cwd=_ROOT, env=settings | kept, check=True, capture_output=True)
    wall, after = time.perf_counter() - start, os.times()
    return Times(wall, after.children_user - before.children_user)

"""NPBench's numba programs as they are found, in float32 at small sizes: which run, and agree.

NPBench (Ziogas et al., "Productivity, portability, performance: data-centric Python", 2021; ETH
Zurich, BSD) has programs of 54 kinds that its authors wrote for numba, `*_numba_n.py`. They stay
outside this repository: the table is made from a copy that the user has.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import geometric_mean
from types import ModuleType
from typing import Any, Final, TypeVar

import click
import numpy as np

import vividc
from benchmarks.polybench.inputs import INPUTS
from benchmarks.polybench.suite import CASES
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.pipeline import optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.errors import InternalError, VividcError
from vividc.frontend import KernelFunction
from vividc.machine.opcodes import Type
from vividc.program import Program
from vividc.sim.bind import bind
from vividc.ssa.results import named_leaves
from vividc.ssa.rewrite.normalize import normalize

TITLE: Final = "NPBench: numba programs as they are found"
HEADER: Final = (
    "| program | runs | agrees with numba | cycles | loops by hand | operations / 16 | compile s "
    "| why not |\n|---|---|---|---|---|---|---|---|"
)
NOTES: Final = [
    "The programs that NPBench's authors wrote for numba, each as it stands, for the types of its",
    "arguments: arrays and floats in float32, sizes of at most 14, on `vivid-tile`.",
    "",
    "- agrees: floats differ from numba's (Python's, if numba would need SciPy) by at most 1e-4 of",
    "  the greatest number in their array; integers are equal. Arrays after the run are compared,",
    "  and what is returned.",
    "- loops by hand: cycles of PolyBench's kernel of that name (`benchmarks/polybench`), which is",
    "  written in loops, with arrays of the same sizes.",
    "- operations / 16: float operations that the kernel as written executes, an FMA being one,",
    "  over the PEs of a tile.",
    "- compile s: seconds on a machine that does nothing else.",
    "",
    "The matrix of spmv is made without SciPy, which NPBench's own function needs.",
]
SPREAD_NOTES: Final = [
    "## With loops over `prange`",
    "",
    "None of these programs has one. Where NPBench's authors wrote another with loops over",
    "`prange` (`*_numba_npr.py`), it is compiled for `vivid` here, with the same arguments. Its",
    "`cycles` are those of a launch, which moves arrays from DRAM and back and configures tiles.",
]
SPREAD_HEADER: Final = (
    "| program | runs | agrees with numba | cycles | tiles | cycles on `vivid-tile` | why not, or "
    "why one tile |\n|---|---|---|---|---|---|---|"
)
RTOL: Final = 1e-4
_MOST: Final = 14
_STEPS: Final = frozenset({"TSTEPS", "nt", "nit", "TMAX", "tEnd"})
_FEW_STEPS: Final = 3
_SIZES: Final[Mapping[str, Mapping[str, float]]] = {
    "heat_3d": {"N": 9},
    "stockham_fft": {"R": 2, "K": 4},
    "spmv": {"M": 14, "N": 14, "nnz": 40},
    "lenet": {"N": 1, "H": 28, "W": 28},
    "conv2d": {"N": 2, "C_in": 2, "C_out": 3, "K": 3, "H": 8, "W": 8},
    "resnet": {"N": 1, "W": 4, "H": 4, "C1": 3, "C2": 2},
    "softmax": {"N": 2, "H": 2, "SM": 8},
    "contour_integral": {"NR": 4, "NM": 5, "slab_per_bc": 2, "num_int_pts": 3},
    "cavity_flow": {"nt": 2, "nit": 2},
    "channel_flow": {"ny": 8, "nx": 8, "nit": 2},
    "nbody": {"N": 5, "tEnd": 0.2, "dt": 0.05},
    "hdiff": {"I": 6, "J": 6, "K": 4},
    "vadv": {"I": 6, "J": 6, "K": 5},
    "mandelbrot1": {"XN": 8, "YN": 8, "maxiter": 8},
    "mandelbrot2": {"XN": 8, "YN": 8, "maxiter": 8},
}
"""Sizes that others do not fit, or that would be many more operations."""
_BY_HAND: Final[Mapping[str, tuple[str, str]]] = {
    "adi": ("adi", "TSTEPS N"),
    "atax": ("atax", "M N"),
    "bicg": ("bicg", "N M"),
    "cholesky": ("cholesky", "N"),
    "cholesky2": ("cholesky", "N"),
    "correlation": ("correlation", "N M"),
    "covariance": ("covariance", "N M"),
    "covariance2": ("covariance", "N M"),
    "deriche": ("deriche", "W H"),
    "doitgen": ("doitgen", "NR NQ NP"),
    "durbin": ("durbin", "N"),
    "fdtd_2d": ("fdtd_2d", "TMAX NX NY"),
    "floyd_warshall": ("floyd_warshall", "N"),
    "gemm": ("gemm", "NI NJ NK"),
    "gemver": ("gemver", "N"),
    "gesummv": ("gesummv", "N"),
    "gramschmidt": ("gramschmidt", "M N"),
    "heat_3d": ("heat_3d", "TSTEPS N"),
    "jacobi_1d": ("jacobi_1d", "TSTEPS N"),
    "jacobi_2d": ("jacobi_2d", "TSTEPS N"),
    "k2mm": ("two_mm", "NI NJ NK NL"),
    "k3mm": ("three_mm", "NI NJ NK NL NM"),
    "lu": ("lu", "N"),
    "ludcmp": ("ludcmp", "N"),
    "mvt": ("mvt", "N"),
    "nussinov": ("nussinov", "N"),
    "seidel_2d": ("seidel_2d", "TSTEPS N"),
    "symm": ("symm", "M N"),
    "syr2k": ("syr2k", "N M"),
    "syrk": ("syrk", "N M"),
    "trisolv": ("trisolv", "N"),
    "trmm": ("trmm", "M N"),
}
"""The kernel in loops that computes what a program does, and the sizes that it is made for."""
_MUCH: Final = 1.2
"""Times the cycles of loops by hand, above which a program is named."""
_NARROW: Final = {"float64": np.float32, "complex128": np.complex64, "int64": np.int32}
_SECONDS: Final = 900
_PATIENCE: Final = 10.0
"""Times the limit that the clock allows: on a busy machine the words are to be the same."""


_SPREAD: Final = "npr"
_ONE_TILE: Final = "runs on one tile only: "


@dataclass(frozen=True, slots=True)
class Row:
    """A program; `refused`: why it does not run; `error` as of `polybench.measure.Row`."""

    program: str
    error: float | None = None
    cycles: int | None = None
    by_hand: int | None = None
    operations: int | None = None
    compile_s: float | None = None
    refused: str = ""

    @property
    def line(self) -> str:
        """Its line of the table."""
        runs = self.cycles is not None
        agrees = "" if self.error is None else "yes" if self.error <= RTOL else "**no**"
        cycles = "" if self.cycles is None else f"{self.cycles:,}"
        ideal = "" if self.operations is None else f"{self.operations / 16:,.0f}"
        took = "" if self.compile_s is None else f"{self.compile_s:.1f}"
        loops = "" if self.by_hand is None else f"{self.by_hand:,}"
        name = f"| {self.program} | {'yes' if runs else 'no'} | {agrees} | {cycles} | {loops} "
        return f"{name}| {ideal} | {took} | {self.refused.replace('|', '/')} |"


@dataclass(frozen=True, slots=True)
class Spread:
    """A program with loops over `prange`; `on_tile`: cycles on one tile, without moves."""

    program: str
    error: float | None = None
    cycles: int | None = None
    tiles: int | None = None
    on_tile: int | None = None
    refused: str = ""

    @property
    def line(self) -> str:
        """Its line of the table."""
        runs = "no" if self.cycles is None else "yes"
        agrees = "" if self.error is None else "yes" if self.error <= RTOL else "**no**"
        numbers = (self.cycles, self.tiles, self.on_tile)
        shown = " | ".join("" if number is None else f"{number:,}" for number in numbers)
        why = self.refused.replace("|", "/")
        return f"| {self.program} | {runs} | {agrees} | {shown} | {why} |"


def programs(suites: Path, kind: str = "n") -> dict[str, Path]:
    """The programs in a folder, by name; `kind`: the end of their files' names."""
    ending = f"_numba_{kind}.py"
    found = {path.name.removesuffix(ending): path for path in sorted(suites.rglob(f"*{ending}"))}
    if not found:
        reason = f"{suites} has no program {ending}: get NPBench, https://github.com/spcl/npbench"
        raise click.BadParameter(reason)
    return found


def lines(suites: Path, only: Sequence[str] = ()) -> Iterator[str]:
    """The table, each program in a process of its own: one may take all memory, or not end."""
    yield from (*NOTES, "", *HEADER.splitlines())
    rows = []
    for name in programs(suites):
        if only and name not in only:
            continue
        rows.append(in_process(suites, name, Row))
        yield rows[-1].line
    right = sum(row.error is not None and row.error <= RTOL for row in rows)
    wrong = sum(row.error is not None and row.error > RTOL for row in rows)
    yield from ("", f"{right} of {len(rows)} run and agree, {wrong} differ.")
    yield from ("", *_beside_loops(rows))
    yield from ("", *SPREAD_NOTES, "", *SPREAD_HEADER.splitlines())
    spread = []
    for name in programs(suites, _SPREAD):
        if not only or name in only:
            spread.append(in_process(suites, name, Spread))
            yield spread[-1].line
    right = sum(row.error is not None and row.error <= RTOL for row in spread)
    on_many = sum((row.tiles or 0) > 1 for row in spread)
    yield from ("", f"{right} of {len(spread)} run and agree, {on_many} on more tiles than one.")


def _beside_loops(rows: Sequence[Row]) -> Iterator[str]:
    """How the programs compare with loops by hand."""
    pairs = {row.program: row.cycles / row.by_hand for row in rows if row.cycles and row.by_hand}
    if pairs:
        above = [f"{name} {ratio:.2f}" for name, ratio in pairs.items() if ratio > _MUCH]
        mean = geometric_mean(pairs.values())
        yield f"Cycles over those of loops by hand: {mean:.2f} (geometric mean of {len(pairs)});"
        yield f"more than {_MUCH} of {len(above)}: {', '.join(above) or 'none'}."


_Kind = TypeVar("_Kind", Row, Spread)


def in_process(suites: Path, name: str, kind: type[_Kind]) -> _Kind:
    """The row of a program, made by a process of its own."""
    command = [sys.executable, "-m", "benchmarks.npbench", str(suites), name, kind.__name__]
    try:
        run = subprocess.run(command, capture_output=True, timeout=_SECONDS, text=True, check=False)
    except subprocess.TimeoutExpired:
        return kind(name, refused=f"past {_SECONDS} s")
    last = run.stdout.strip().splitlines()[-1:] or ["{}"]
    if run.returncode or not last[0].startswith("{"):
        told = run.stderr.strip().splitlines()[-1:] or [""]
        return kind(name, refused=f"crashes: {told[0]}")
    return kind(**json.loads(last[0]))


def measured(suites: Path, name: str) -> Row:
    """The row of a program."""
    row = Row(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        arguments, function = _found(suites, name)
        theirs, mine = _fresh(arguments), _fresh(arguments)
        try:
            kernel = vividc.jit(function).kernel(*arguments)
            value = _run(function, kernel, theirs)
        except VividcError as error:
            return replace(row, refused=_told(error))
        except Exception as error:  # numba has many
            return replace(row, refused=f"numba: {str(error).strip().splitlines()[0]}")
        try:
            start = time.perf_counter()
            with vividc.patient(_PATIENCE):
                program = vividc.compile(kernel)
            row = replace(row, compile_s=round(time.perf_counter() - start, 1))
            counted = operations(kernel, program, _fresh(arguments))
            result = vividc.simulate(program, *mine)
        except (VividcError, InternalError) as error:
            return replace(row, refused=_told(error))
        error = largest_error([*mine, result.value], [*theirs, value])
        by_hand = _loops_by_hand(suites, name)
    return replace(row, cycles=result.cycles, error=error, operations=counted, by_hand=by_hand)


def spread(suites: Path, name: str) -> Spread:
    """The row of a program with loops over `prange`."""
    row = Spread(name)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", vividc.VividcWarning)
        arguments, function = _found(suites, name, _SPREAD)
        theirs, mine = _fresh(arguments), _fresh(arguments)
        kernel = vividc.jit(function).kernel(*arguments)
        value = _run(function, kernel, theirs)
        try:
            with vividc.patient(_PATIENCE):
                on_tile = vividc.simulate(vividc.compile(kernel), *_fresh(arguments))
                row = replace(row, on_tile=on_tile.cycles)
                result = vividc.simulate(vividc.compile(kernel, "vivid"), *mine)
        except (VividcError, InternalError) as error:
            return replace(row, refused=_told(error))
        tiles = len(result.stats["tiles"])
        why = [str(one.message) for one in told if _ONE_TILE in str(one.message)]
    text = why[0].split(_ONE_TILE)[1].split(";")[0] if why and tiles == 1 else ""
    error = largest_error([*mine, result.value], [*theirs, value])
    return replace(row, cycles=result.cycles, tiles=tiles, error=error, refused=text)


def _loops_by_hand(suites: Path, name: str) -> int | None:
    """Cycles of the kernel in loops that computes the same; None: there is none."""
    if name not in _BY_HAND:
        return None
    kernel, names = _BY_HAND[name]
    sizes = _sizes(suites, name)
    arguments = INPUTS[kernel](*(int(sizes[size]) for size in names.split()))
    case = next(case for case in CASES.values() if case.kernel.name == kernel)
    with vividc.patient(_PATIENCE):
        program = vividc.compile(case.kernel)
    return vividc.simulate(program, *arguments).cycles


def _run(function: Any, kernel: KernelFunction, arguments: Sequence[object]) -> Any:
    """What numba gives; or Python, as linear algebra needs SciPy to be compiled by numba."""
    try:
        return kernel(*arguments)
    except ImportError:
        return getattr(function, "py_func", function)(*arguments)


def _told(error: VividcError | InternalError) -> str:
    return str(getattr(error, "reason", error)).splitlines()[0]


def _found(suites: Path, name: str, kind: str = "n") -> tuple[list[object], Any]:
    """Arguments and function of a program."""
    path = programs(suites, kind)[name]
    known, sizes = _described(suites, name), _sizes(suites, name)
    values: dict[str, object] = dict(sizes)
    init = known.get("init")
    if init:
        maker = _MADE.get(name) or getattr(_module(path.with_name(f"{name}.py")), init["func_name"])
        made = maker(*(sizes[given] for given in init["input_args"]))
        made = made if isinstance(made, tuple) else (made,)
        values |= dict(zip(init["output_args"], made, strict=True))
    arguments = [_narrowed(values[given]) for given in known["input_args"]]
    return arguments, getattr(_module(path), known["func_name"])


def _sizes(suites: Path, name: str) -> dict[str, float]:
    """Those of a program that are run."""
    given = _described(suites, name)["parameters"]["S"]
    sizes = {
        size: min(value, _FEW_STEPS if size in _STEPS else _MOST) if value > 1 else value
        for size, value in given.items()
    }
    return sizes | dict(_SIZES.get(name, {}))


def _sparse_matrix(rows: int, columns: int, count: int) -> tuple[np.ndarray, ...]:
    """A random matrix in CSR form and a vector, as NPBench makes them with SciPy."""
    rng = np.random.default_rng(42)
    x = rng.random(columns)
    places = np.sort(rng.choice(rows * columns, count, replace=False))
    starts = np.searchsorted(places, columns * np.arange(rows + 1))
    return starts.astype(np.uint32), (places % columns).astype(np.uint32), rng.random(count), x


_MADE: Final[Mapping[str, Callable[..., tuple[np.ndarray, ...]]]] = {"spmv": _sparse_matrix}
"""What makes arguments in place of NPBench's own function."""


def _described(suites: Path, name: str) -> dict[str, Any]:
    for path in sorted(suites.rglob("bench_info/*.json")):
        described: dict[str, Any] = json.loads(path.read_text())["benchmark"]
        if described["module_name"] == name:
            return described
    raise click.BadParameter(f"{suites} has no description of {name} in bench_info")


def _module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _narrowed(value: object) -> object:
    """An argument in float32; integers in arrays, too, have 32 bits."""
    if isinstance(value, np.ndarray):
        dtype = _NARROW.get(value.dtype.name, value.dtype)
        return np.array(value, dtype=dtype, order="C")
    if isinstance(value, np.generic):
        value = value.item()
    return np.float32(value) if isinstance(value, float) else value


def _fresh(arguments: Sequence[object]) -> list[object]:
    return [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]


def operations(kernel: KernelFunction, program: Program, arguments: Sequence[object]) -> int:
    """Float operations of the kernel as written, run by the interpreter."""
    written = optimize_kernel(build_kernel(normalize(kernel.lower())))
    bound = bind(program, arguments, {})
    ran = interpret(written, bound.memory, bound.inputs)
    return sum(n * each for n, each in zip(ran.iterations, _floats(written), strict=True))


def _floats(kernel: Kernel) -> Iterator[int]:
    for region in kernel.regions:
        nodes = region.dfg.nodes
        yield sum(n.uses_fu and n.info.operands[:1] == (Type.F32,) for n in nodes)


def largest_error(mine: Sequence[object], numbas: Sequence[object]) -> float:
    """The largest difference, as a share of the greatest number of its array; infinite where
    shapes, types or integers differ.
    """
    worst = 0.0
    ours, theirs = dict(named_leaves(tuple(mine))), dict(named_leaves(tuple(numbas)))
    if ours.keys() != theirs.keys():
        return np.inf
    for name, one in ours.items():
        other = theirs[name]
        if one.shape != other.shape or one.dtype.kind != other.dtype.kind:
            return np.inf
        if one.dtype.kind not in "fc" or not np.array_equal(np.isfinite(one), np.isfinite(other)):
            worst = max(worst, 0.0 if np.array_equal(one, other) else np.inf)
            continue
        finite = np.isfinite(other)
        away = np.abs(one[finite].astype(np.complex128) - other[finite]).max(initial=0.0)
        worst = max(worst, float(away / max(np.abs(other[finite]).max(initial=0.0), 1e-30)))
    return worst


if __name__ == "__main__":
    made = spread if sys.argv[3:] == [Spread.__name__] else measured
    click.echo(json.dumps(asdict(made(Path(sys.argv[1]), sys.argv[2]))))

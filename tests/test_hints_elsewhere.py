"""What the hints about matrix products, C, launches, rendering and mappers say helps."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import vividc
from tests.test_hints import GRAPH, Row
from vividc import arch
from vividc.cli import main
from vividc.gemm import Layer, gemm, mlp, mlp_job
from vividc.mapper import MapResult, map_dfg

A, B = np.ones((8, 4), np.float32), np.ones((4, 8), np.float32)
BIAS = np.ones(8, np.float32)
MODE = "tpu-partitioned"
INCREMENT = """define void @add(ptr %x, i32 %n) {
  store i32 %n, ptr %x
  ret void
}
"""


def product(a=A, b=B, bias=None, mode=MODE, **how):
    return gemm(a, b, bias, mode=mode, **how)


@vividc.jit(effort="fast")
def scaled(a, x):
    for i in range(len(x)):
        x[i] *= a


def double(x: np.ndarray, a: object = 2.0) -> None:
    scaled(a, x)


@pytest.fixture(scope="module")
def c(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], vividc.LLKernel]:
    """A function that reads a body as the C function `f`."""
    folder = tmp_path_factory.mktemp("c")

    def read(body: str, text: str = "define void @f(ptr %x) {{\n {}\n ret void\n}}\n"):
        path = folder / f"f{len(list(folder.iterdir()))}.ll"
        path.write_text(text.format(body))
        kernel = vividc.load_ll(path)
        kernel.lower()
        return kernel

    return read


X = np.ones(8, np.float32)
PRODUCTS = {
    "float64": Row(
        lambda: product(A.astype(np.float64)),
        r"x\.astype\(np\.float32\)",
        lambda: product(A.astype(np.float64).astype(np.float32)),
    ),
    "integers in one row": Row(
        lambda: product(A[0].astype(np.int64)),
        r"x\.astype\(np\.float32\)\.reshape\(1, -1\)",
        lambda: product(A[0].astype(np.int64).astype(np.float32).reshape(1, -1)),
    ),
    "list": Row(
        lambda: product(A.tolist()),
        r"np\.array\(x, np\.float32\)",
        lambda: product(np.array(A.tolist(), np.float32)),
    ),
    "bias with two axes": Row(
        lambda: product(bias=BIAS[None]),
        r"x\.reshape\(-1\)",
        lambda: product(bias=BIAS[None].reshape(-1)),
    ),
    "shape": Row(lambda: product(A, B.T), r"weights \[depth, columns\]", lambda: product(A, B.T.T)),
    "length of a bias": Row(
        lambda: product(bias=BIAS[:3]), "one for each column", lambda: product(bias=BIAS)
    ),
    "activation": Row(
        lambda: product(activation="sigmoid"),
        r"mlp_job\(x, \[Layer\(weights, activation='sigmoid'\)\]\)",
        lambda: mlp_job(A, [Layer(B, activation="sigmoid")], mode=MODE),
    ),
    "precision": Row(lambda: product(precision="fp16"), "f16", lambda: product(precision="f16")),
    "mode": Row(lambda: product(mode="tpu"), MODE, product),
    "no list of layers": Row(
        lambda: mlp(A, B, mode=MODE), r"\[Layer\(weights", lambda: mlp(A, [Layer(B)], mode=MODE)
    ),
}
LAUNCHES = {
    "float64": Row(
        lambda: double(X.astype(np.float64)),
        r"x = np\.ascontiguousarray\(x, np\.float32\)",
        lambda: double(np.ascontiguousarray(X.astype(np.float64), np.float32)),
    ),
    "strides": Row(
        lambda: double(np.ones(16, np.float32)[::2]),
        r"x = np\.ascontiguousarray\(x\)",
        lambda: double(np.ascontiguousarray(np.ones(16, np.float32)[::2])),
    ),
    "list": Row(
        lambda: double([1.0, 2.0]),
        r"x = np\.array\(x, np\.float32\)",
        lambda: double(np.array([1.0, 2.0], np.float32)),
    ),
    "text": Row(lambda: double(X, "2"), "numbers and booleans", lambda: double(X, 2.0)),
    "list for a program": Row(
        lambda: vividc.simulate(ready(), 2.0, [1.0]),
        r"x = np\.array\(x, np\.float32\)",
        lambda: vividc.simulate(ready(), 2.0, np.array([1.0], np.float32)),
    ),
    "none": Row(
        lambda: vividc.simulate(ready(), 2.0, None),
        "the parameters are a, x",
        lambda: vividc.simulate(ready(), a=2.0, x=X.copy()),
    ),
    "order": Row(
        lambda: vividc.simulate(ready(), X, 2.0),
        "in the order of the parameters",
        lambda: vividc.simulate(ready(), 2.0, X.copy()),
    ),
    "an array of one number": Row(
        lambda: vividc.simulate(ready(), np.float32([2]), X),
        r"a\.item\(\)",
        lambda: vividc.simulate(ready(), np.float32([2]).item(), X.copy()),
    ),
}


def ready() -> vividc.Program:
    """The program of `scaled`."""
    scaled(2.0, X.copy())
    assert scaled.program is not None
    return scaled.program


def nothing(problem, request) -> MapResult:
    return None  # type: ignore[return-value]  # the mistake


def gives_up(problem, request) -> MapResult:
    return MapResult("timeout", None, 1, (), None, "mine", 0.0)


@pytest.mark.parametrize("row", [*PRODUCTS.values(), *LAUNCHES.values()])
def test_what_a_hint_says_helps(row: Row) -> None:
    with pytest.raises(vividc.VividcError) as caught:
        row.wrong()
    assert re.search(row.says, str(caught.value)), str(caught.value)
    row.mended()


def test_a_mapper_that_returns_nothing_is_told_what_to_return() -> None:
    fabric = arch.load("mesh-2x2")
    with pytest.raises(vividc.VividcError, match="status `timeout` if there is no mapping"):
        map_dfg(GRAPH, fabric, nothing)
    assert map_dfg(GRAPH, fabric, gives_up).status == "timeout"


def test_a_place_of_an_override_goes_under_at() -> None:
    text = "rows: 2\ncols: 2\ntopology: mesh\noverrides:\n  - {%s, memory: true}\n"
    with pytest.raises(vividc.VividcError, match=r"`at: \{cols: \.\.\.\}`"):
        arch.load_text(text % "cols: 0", "mine.yaml")
    arch.load_text(text % "at: {cols: 0}", "mine.yaml")


@pytest.mark.parametrize(
    ("wrong", "says", "mended"),
    [
        (
            "%v = load <2 x i32>, ptr %x\n store <2 x i32> %v, ptr %x",
            "-fno-vectorize",
            "%v = load i32, ptr %x\n store i32 %v, ptr %x",
        ),
        (
            "%v = load i64, ptr %x\n %w = add i64 %v, 1\n store i64 %w, ptr %x",
            "8, 16 or 32 bits",
            "%v = load i16, ptr %x\n store i16 %v, ptr %x",
        ),
        (
            "%v = load double, ptr %x\n %w = fadd double %v, 1.0\n store double %w, ptr %x",
            "arrays hold float",
            "%v = load float, ptr %x\n store float %v, ptr %x",
        ),
    ],
)
def test_what_a_hint_about_c_says_helps(c, wrong: str, says: str, mended: str) -> None:
    with pytest.raises(vividc.VividcError, match=f"hint: .*{says}"):
        c(wrong)
    c(mended)


def test_hints_about_files_of_c(c, tmp_path: Path) -> None:
    with pytest.raises(vividc.VividcError, match="opaque"):
        c("", "define void @f(float* %x) {{\n ret void\n}}\n")
    with pytest.raises(vividc.VividcError, match="clang -O1 -g -emit-llvm -S"):
        c("", "void f(float *x) {{ }}\n")
    with pytest.raises(vividc.VividcError, match="check the path"):
        vividc.load_ll(tmp_path / "none.ll")
    both = tmp_path / "both.ll"
    both.write_text(INCREMENT + INCREMENT.replace("@add", "@sum"))
    with pytest.raises(vividc.VividcError, match=r"choose one: .*both\.ll:add"):
        vividc.load_ll(both)
    vividc.load_ll(both, "add").lower()


SCENE = "ball.ply"
RENDERS = {
    "no scene": ("in.txt", "a scene is a 3DGS .ply", f"{SCENE}"),
    "format of the picture": (f"{SCENE} -o p.jpg", r"end it in \.png", f"{SCENE} -o p.png"),
    "view without views": (f"{SCENE} --view 0", "give --views", f"{SCENE} --views v.npz --view 0"),
    "precision of the reference": (f"{SCENE} --precision fp8", "leave it out", SCENE),
    "sample of the reference": (f"{SCENE} --sample 0.5", "--engine array", None),
    "a tile for an accelerator": (
        f"{SCENE} --engine array --fabric vivid-tile",
        "accelerators: vivid",
        None,
    ),
    "share": (f"{SCENE} --engine array --sample 2", "above 0 and at most 1", None),
    "no views": (f"{SCENE} --views ball.npz", r"c2w \[V,4,4\]", f"{SCENE} --views v.npz"),
}


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a scene of one Gaussian and a view of it."""
    folder = tmp_path_factory.mktemp("scenes")
    names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1"]
    names += ["scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    header = ["ply", "format binary_little_endian 1.0", "element vertex 2"]
    header += [*(f"property float {name}" for name in names), "end_header", ""]
    rows = np.zeros((2, len(names)), "<f4")
    rows[:, 0] = 0, 1
    rows[:, 7:11] = -1, -1, -1, 1
    (folder / SCENE).write_bytes("\n".join(header).encode() + rows.tobytes())
    (folder / "in.txt").write_text("no scene")
    np.savez(folder / "ball.npz", x=X)
    pose = np.eye(4, dtype=np.float32)
    pose[2, 3] = 4
    images = np.zeros((1, 8, 8, 3), np.float32)
    np.savez(folder / "v.npz", c2w=pose[None], images=images, focal=8.0, size=8)
    return folder


@pytest.mark.parametrize(("wrong", "says", "mended"), RENDERS.values(), ids=RENDERS)
def test_what_a_hint_about_rendering_says_helps(
    scenes: Path, monkeypatch: pytest.MonkeyPatch, wrong: str, says: str, mended: str | None
) -> None:
    monkeypatch.chdir(scenes)
    done = CliRunner().invoke(main, ["render", *wrong.split(), "--size", "8x8"])
    assert done.exit_code == 2
    assert re.search(f"hint: .*{says}", done.stderr), done.stderr
    if mended is not None:
        done = CliRunner().invoke(main, ["render", *mended.split(), "--size", "8x8"])
        assert done.exit_code == 0, done.stderr

"""C functions from `.ll` files: what is taken, and what is refused with which message."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.errors import ArgumentError, KernelError, VividcWarning
from vividc.frontend.c import source as ll_source
from vividc.frontend.llvm.child.client import Lost
from vividc.machine.params import DType
from vividc.ssa.interpret import interpret as run

LOOP = """
define i32 @sum(ptr %x, i32 %n) {
  %first = icmp sgt i32 %n, 0
  br i1 %first, label %start, label %end
start:
  %wide = zext i32 %n to i64
  br label %loop
loop:
  %i = phi i64 [ 0, %start ], [ %next, %loop ]
  %s = phi i32 [ 0, %start ], [ %t, %loop ]
  %p = getelementptr inbounds i32, ptr %x, i64 %i
  %v = load i32, ptr %p
  %t = add i32 %s, %v
  %next = add nuw nsw i64 %i, 1
  %done = icmp eq i64 %next, %wide
  br i1 %done, label %end, label %loop
end:
  %result = phi i32 [ 0, %0 ], [ %t, %loop ]
  ret i32 %result
}
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "k.ll"
    path.write_text(text)
    return path


def kernel(folder: Path, body: str, head: str = "void @f(ptr %x, i32 %n)") -> vividc.LLKernel:
    return vividc.load_ll(write(folder, f"define {head} {{\n{body}\n}}\n"), "f")


def test_a_rotated_loop_is_a_while_loop_again(tmp_path: Path) -> None:
    loaded = vividc.load_ll(write(tmp_path, LOOP))
    program = vividc.compile(loaded, loops=vividc.LoopOptions(auto=False))
    [loop] = [region for region in program.regions if region.kind == "loop"]
    assert (loop.ii, loop.status) == (1, "optimal")
    for n in (0, 1, 7):
        x = np.arange(7, dtype=np.int32)
        assert vividc.simulate(program, x, n).value == loaded(x, n) == sum(range(n))


def test_arrays_have_any_number_of_dimensions(tmp_path: Path) -> None:
    program = vividc.compile(vividc.load_ll(write(tmp_path, LOOP)))
    x = np.arange(24, dtype=np.int32).reshape(2, 3, 4)
    assert vividc.simulate(program, x, 24).value == x.sum()


def test_types_can_be_given(tmp_path: Path) -> None:
    path = write(tmp_path, LOOP)
    assert vividc.load_ll(path).params[0].dtype is DType.I32
    assert vividc.load_ll(path, types={"x": "uint32"}).params[0].dtype is DType.U32
    with pytest.raises(KernelError, match="types: 'y'"):
        vividc.load_ll(path, types={"y": "uint32"})


def test_parameters_without_names_are_numbered(tmp_path: Path) -> None:
    body = "  store float 1.0, ptr %0\n  ret void"
    loaded = kernel(tmp_path, body, "void @f(ptr %0, i8 signext %1, i1 zeroext %2, i64 %3)")
    assert [(p.name, p.dtype) for p in loaded.params] == [
        ("arg0", DType.F32),
        ("arg1", DType.I32),
        ("arg2", DType.BOOL),
        ("arg3", DType.I64),
    ]


def test_members_of_structures_have_offsets(tmp_path: Path) -> None:
    text = """
%struct.inner = type { i32, [3 x float] }
%struct.outer = type { float, %struct.inner, float }
define void @f(ptr %x, i32 %n) {
  %wide = sext i32 %n to i64
  %p = getelementptr inbounds %struct.outer, ptr %x, i64 %wide, i32 1, i32 1, i64 2
  store float 1.0, ptr %p
  ret void
}
"""
    loaded = vividc.load_ll(write(tmp_path, text))
    x, y = np.zeros((3, 6), np.float32), np.zeros((3, 6), np.float32)
    run(loaded.lower(), x, 2)
    loaded(y, 2)
    assert x[2, 4] == 1.0
    np.testing.assert_array_equal(x, y)


_COPIED = "ptr align 4 %y, ptr align 4 %x, i64 {bytes}, i1 false)"
BLOCKS = {
    "memset": "call void @llvm.memset.p0.i64(ptr align 4 %x, i8 {value}, i64 {bytes}, i1 false)",
    "memcpy": "call void @llvm.memcpy.p0.p0.i64(" + _COPIED,
    "memmove": "call void @llvm.memmove.p0.p0.i64(" + _COPIED,
}
DECLARED = """
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
declare void @llvm.memmove.p0.p0.i64(ptr, ptr, i64, i1)
"""


def block_kernel(folder: Path, call: str, target: str, bytes_: str) -> vividc.LLKernel:
    line = call.format(value="171", bytes=bytes_).replace("%y", target)
    text = f"""
define void @f(ptr %x, ptr %other, i32 %n) {{
  %up = getelementptr i32, ptr %x, i64 2
  %from = getelementptr i32, ptr %x, i64 0
  %wide = sext i32 %n to i64
  %bytes = shl nsw i64 %wide, 2
  {line}
  ret void
}}
{DECLARED}"""
    return vividc.load_ll(write(folder, text), "f")


@pytest.mark.parametrize("target", ["%up", "%other"])
@pytest.mark.parametrize("kind", BLOCKS)
@pytest.mark.parametrize("bytes_", ["%bytes", "20"])
def test_block_operations_are_loops(tmp_path: Path, kind: str, target: str, bytes_: str) -> None:
    if (kind, target) == ("memcpy", "%up"):
        target = "%other"  # C leaves a copy to an overlapping place undefined
    loaded = block_kernel(tmp_path, BLOCKS[kind], target, bytes_)
    function = loaded.lower()
    for n in (0, 1, 5):
        ours = [np.arange(10, dtype=np.int32), np.zeros(10, np.int32)]
        host = [array.copy() for array in ours]
        run(function, *ours, n)
        loaded(*host, n)
        np.testing.assert_array_equal(ours, host)


@pytest.mark.parametrize("kind", BLOCKS)
@pytest.mark.parametrize("aligned", [True, False])
def test_blocks_of_bytes(tmp_path: Path, kind: str, *, aligned: bool) -> None:
    call = BLOCKS[kind] if aligned else BLOCKS[kind].replace(" align 4", "")
    loaded = block_kernel(tmp_path, call, "%other", "%wide")
    dtype = loaded.params[0].dtype.value
    function = loaded.lower()
    for n in (0, 1, 5, 8, 15):
        ours = [np.arange(40, dtype=np.uint8).view(dtype), np.zeros(40, np.uint8).view(dtype)]
        host = [array.copy() for array in ours]
        dtypes = [param.dtype.value for param in loaded.params[:2]]
        run(function, *ours, n)
        loaded(*(array.view(type_) for array, type_ in zip(host, dtypes, strict=True)), n)
        np.testing.assert_array_equal(ours, host)


@pytest.mark.parametrize(("attribute", "value"), [("signext", -56), ("zeroext", 200)])
def test_small_returned_integers_keep_their_sign(
    tmp_path: Path, attribute: str, value: int
) -> None:
    body = "  %r = trunc i32 %n to i8\n  ret i8 %r"
    loaded = kernel(tmp_path, body, f"{attribute} i8 @f(i32 %n)")
    assert run(loaded.lower(), 456) == loaded(456) == value


def test_double_parameters_are_warned_of(tmp_path: Path) -> None:
    body = (
        "  %y = fmul double %a, 0x3FB999999999999A\n"
        "  %z = fptrunc double %y to float\n  ret float %z"
    )
    loaded = kernel(tmp_path, body, "float @f(double %a)")
    with pytest.warns(VividcWarning) as caught:
        loaded.lower()
    messages = [str(warning.message) for warning in caught]
    assert any("parameter a is a double and is rounded" in text for text in messages)
    assert any(":2: float64 arithmetic runs in float32" in text for text in messages)
    assert not any("np." in text for text in messages)
    with pytest.raises(KernelError, match="a double"):
        loaded.lower(strict_fp=True)


def test_host_calls_check_their_arguments(tmp_path: Path) -> None:
    loaded = vividc.load_ll(write(tmp_path, LOOP))
    with pytest.raises(ArgumentError, match="got 1 arguments"):
        loaded(np.zeros(3, np.int32))
    with pytest.raises(ArgumentError, match="C-contiguous int32"):
        loaded(np.zeros(3, np.float32), 3)
    with pytest.raises(ArgumentError, match="C-contiguous int32"):
        loaded(np.zeros(6, np.int32)[::2], 3)
    with pytest.raises(ArgumentError, match="expected a int32"):
        loaded(np.zeros(6, np.int32), "3")


REFUSED = {
    "vectors": ("  %v = load <4 x float>, ptr %x\n  ret void", 2, "vectors"),
    "atomics": ("  %v = atomicrmw add ptr %x, i32 1 seq_cst\n  ret void", 2, "atomic"),
    "atomic loads": ("  %v = load atomic i32, ptr %x seq_cst, align 4\n  ret void", 2, "atomic"),
    "i128": ("  %v = zext i32 %n to i128\n  ret void", 2, "integers of 128 bits"),
    "i33": ("  %v = zext i32 %n to i33\n  ret void", 2, "integers of 33 bits"),
    "long double": ("  %v = sitofp i32 %n to x86_fp80\n  ret void", 2, "long double"),
    "pointer call": ("  call void %x(i32 %n)\n  ret void", 2, "call through a pointer"),
    "assembly": ('  call void asm "nop", ""()\n  ret void', 2, "inline assembly"),
    "recursion": ("  call void @f(ptr %x, i32 %n)\n  ret void", 2, "recursion through `f`"),
    "computed goto": ("  indirectbr ptr %x, [label %b]\nb:\n  ret void", 2, "computed goto"),
    "addresses": (
        "  %a = ptrtoint ptr %x to i64\n  %b = trunc i64 %a to i32\n"
        "  store i32 %b, ptr %x\n  ret void",
        2,
        "arithmetic on addresses",
    ),
    "pointers in memory": (
        "  %p = load ptr, ptr %x\n  store i32 1, ptr %p\n  ret void",
        2,
        "an array access of type ptr",
    ),
    "endless": ("  br label %b\nb:\n  store i32 1, ptr %x\n  br label %b", 1, "never ends"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_refused_with_its_line(tmp_path: Path, what: str) -> None:
    body, line, message = REFUSED[what]
    with pytest.raises(KernelError, match=rf"k\.ll:{line}: .*{message}") as caught:
        kernel(tmp_path, body).lower()
    assert caught.value.hint


REFUSED_TEXT = {
    "typed pointers": ("define void @f(i32* %x) {\n  ret void\n}\n", ":1: pointers with element"),
    "variable arguments": ("define void @f(i32 %n, ...) {\n  ret void\n}\n", ":1: variable arg"),
    "printf": (
        "declare i32 @printf(ptr, ...)\ndefine void @f(ptr %x) {\n"
        "  %r = call i32 (ptr, ...) @printf(ptr %x)\n  ret void\n}\n",
        ":3: a call of `printf`, which takes variable",
    ),
    "unknown intrinsic": (
        "declare i32 @llvm.x86.sse42.crc32.32.32(i32, i32)\ndefine i32 @f(i32 %n) {\n"
        "  %r = call i32 @llvm.x86.sse42.crc32.32.32(i32 %n, i32 7)\n  ret i32 %r\n}\n",
        ":3: a call of `x86.sse42.crc32",
    ),
    "other arrays": (
        "define i1 @f(ptr %x, ptr %y) {\n  %r = icmp ult ptr %x, %y\n  ret i1 %r\n}\n",
        ":2: a comparison of pointers to different arrays",
    ),
    "structure": ("define void @f({ i32, i32 } %x) {\n  ret void\n}\n", ":1: parameter x has type"),
    "by value": (
        "define void @f(ptr byval([2 x i32]) %x) {\n  ret void\n}\n",
        ":1: a structure passed",
    ),
    "not IR": ("int f(int x) { return x; }\n", ": not LLVM IR"),
    "broken IR": ("define void @f() {\n  bogus\n}\n", ":2: not LLVM IR that can be read"),
    "broken signature": (
        "declare i32 @llvm.x86.rdtsc()\ndefine i32 @f(i32 %n) {\n"
        "  %r = call i32 @llvm.x86.rdtsc()\n  ret i32 %r\n}\n",
        "not LLVM IR that can be read: Intrinsic has incorrect return type",
    ),
    "no function": ("declare void @g()\n", ": has no function `f`"),
}


@pytest.mark.parametrize("what", REFUSED_TEXT)
def test_refused_text(tmp_path: Path, what: str) -> None:
    text, message = REFUSED_TEXT[what]
    with pytest.raises(KernelError) as caught:
        vividc.load_ll(write(tmp_path, text), "f").lower()
    assert message in str(caught.value)
    assert caught.value.hint


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(KernelError, match="No such file"):
        vividc.load_ll(tmp_path / "none.ll")
    (tmp_path / "b.ll").write_bytes(b"BC\xc0\xde\x35\x14")
    with pytest.raises(KernelError, match="bitcode"):
        vividc.load_ll(tmp_path / "b.ll")
    (tmp_path / "c.ll").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(KernelError, match="no text"):
        vividc.load_ll(tmp_path / "c.ll")


def test_a_function_must_be_chosen(tmp_path: Path) -> None:
    text = "define void @f() {\n  ret void\n}\ndefine void @g() {\n  ret void\n}\n"
    with pytest.raises(KernelError, match="several functions: f, g"):
        vividc.load_ll(write(tmp_path, text))
    text = text.replace("define void @f", "define internal void @f")
    assert vividc.load_ll(write(tmp_path, text)).name == "g"


def test_a_function_that_llvm_keeps_apart_is_not_taken_for_one_of_its_name(tmp_path: Path) -> None:
    """The array computes sines; this one returns its argument."""
    own = "define float @sinf(float %v) presplitcoroutine {\n  ret float %v\n}\n"
    call = "define float @f(float %a) {\n  %r = call float @sinf(float %a)\n  ret float %r\n}\n"
    with pytest.raises(KernelError, match="`sinf` is called, and LLVM cannot inline it"):
        vividc.load_ll(write(tmp_path, own + call), "f").lower()
    inlined = vividc.load_ll(write(tmp_path, own.replace("presplitcoroutine ", "") + call), "f")
    assert inlined(np.float32(3.0)) == 3.0


def test_a_file_of_which_llvm_dies_in_any_form_is_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dies(*_: object, **__: object) -> None:
        raise Lost("SIGABRT")

    monkeypatch.setattr(ll_source, "ask", dies)
    with pytest.raises(KernelError, match=r"k\.ll: LLVM cannot read it: it dies \(SIGABRT\)"):
        vividc.load_ll(write(tmp_path, LOOP), "sum")

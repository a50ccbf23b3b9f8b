"""C kernels from files that nobody vouches for: what is read, what runs on the host, and where."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.errors import KernelError, SimulationError, TimeLimit, VividcError
from vividc.frontend.c import host as ll_host
from vividc.frontend.memory.tables import tables_of
from vividc.ssa.interpret import interpret as run

HEAD = "define void @f(ptr %x, i32 %n) {\n"
BLOCKS = """
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
declare void @llvm.memmove.p0.p0.i64(ptr, ptr, i64, i1)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
"""


def load(folder: Path, text: str, name: str = "f") -> vividc.LLKernel:
    path = folder / "k.ll"
    path.write_text(text)
    return vividc.load_ll(path, name)


def body(text: str) -> str:
    return f"{HEAD}{text}\n  ret void\n}}\n"


def array(kernel: vividc.LLKernel) -> np.ndarray:
    return np.arange(1, 17).astype(kernel.params[0].dtype.value)


def assert_as_on_the_host(kernel: vividc.LLKernel, *numbers: int) -> None:
    program = vividc.compile(kernel, loops=vividc.LoopOptions(auto=False))
    for n in numbers:
        by_array, by_host = array(kernel), array(kernel)
        assert vividc.simulate(program, by_array, n).value == kernel(by_host, n)
        np.testing.assert_array_equal(by_array, by_host)


SYSTEM = """
@command = constant [{size} x i8] c"touch {path}\\00"
declare i32 @system(ptr)
define float @sinf(float %x) {{
  %r = call i32 @system(ptr @command)
  ret float 1.0
}}
define void @start() {{
  %r = call i32 @system(ptr @command)
  ret void
}}
define void @f(ptr %x, i32 %n){attribute} {{
  %v = load float, ptr %x
  %s = call float @llvm.sin.f32(float %v)
  store float %s, ptr %x
  ret void
}}
declare float @llvm.sin.f32(float)
"""
_LIST = (
    "appending global [1 x { i32, ptr, ptr }] [{ i32, ptr, ptr } { i32 1, ptr @start, ptr null }]"
)
FOREIGN = {
    "a function named like one of C's library": "",
    "constructors": f"@llvm.global_ctors = {_LIST}\n",
    "destructors": f"@llvm.global_dtors = {_LIST}\n",
    "module asm": 'module asm ".globl cosf"\nmodule asm "cosf: ud2"\n',
    "a function that nobody calls, of another file": (
        "declare void @polybench()\n"
        "define i32 @main() {\n  call void @polybench()\n  ret i32 0\n}\n"
    ),
    "an ifunc": "@odd = ifunc void (), ptr @pick\ndefine ptr @pick() {\n  ret ptr @start\n}\n",
    "a variable of each thread": "@t = thread_local global i32 7\n",
}


@pytest.mark.parametrize("what", FOREIGN)
def test_only_the_kernel_runs_on_the_host(tmp_path: Path, what: str) -> None:
    marker = tmp_path / "executed"
    size = len(f"touch {marker}") + 1
    text = FOREIGN[what] + SYSTEM.format(size=size, path=marker, attribute=' gc "erlang"')
    kernel = load(tmp_path, text)
    x = np.full(4, 0.5, np.float32)
    kernel(x, 1)
    assert x[0] == np.float32(np.sin(0.5))
    assert not marker.exists()


def test_of_a_prologue_nothing_runs(tmp_path: Path) -> None:
    kernel = load(tmp_path, body("  store float 2.0, ptr %x").replace("{", "prologue i32 -1 {", 1))
    x = np.zeros(1, np.float32)
    kernel(x, 1)
    assert x[0] == 2


FAULTS = {
    "beyond the array": (
        "  %w = sext i32 %n to i64\n  %p = getelementptr float, ptr %x, i64 %w\n"
        "  store float 1.0, ptr %p",
        ":4: the reference accesses memory outside its arrays",
    ),
    "a division by zero": (
        "  %v = load i32, ptr %x\n  %d = sub i32 %n, 16\n  %q = sdiv i32 %v, %d\n"
        "  store i32 %q, ptr %x",
        r"the reference dies \(SIGFPE\) on this computer",
    ),
    "code that C leaves undefined": (
        "  %c = icmp eq i32 %n, 0\n  br i1 %c, label %a, label %b\nb:\n  unreachable\na:",
        ":5: the reference reaches what C leaves undefined",
    ),
    "a block of 4 GiB": (
        "  call void @llvm.memset.p0.i64(ptr %x, i8 0, i64 4294967296, i1 0)",
        ":2: the reference accesses memory outside its arrays",
    ),
}


@pytest.mark.parametrize("what", FAULTS)
def test_what_c_leaves_undefined_is_a_message(tmp_path: Path, what: str) -> None:
    text, message = FAULTS[what]
    kernel = load(tmp_path, body(text) + BLOCKS)
    x = array(kernel)
    with pytest.raises(KernelError, match=message) as caught:
        kernel(x, 16)
    assert caught.value.exit_code == 2
    np.testing.assert_array_equal(x, array(kernel))


def test_a_reference_that_never_ends_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ll_host, "LIMIT_S", 0.2)
    text = "  br label %l\nl:\n  %v = load volatile i32, ptr %x\n  %c = icmp eq i32 %v, 0\n"
    kernel = load(tmp_path, body(f"{text}  br i1 %c, label %e, label %l\ne:"))
    with pytest.raises(TimeLimit) as caught:
        kernel(array(kernel), 1)
    assert caught.value.exit_code == 4


def test_arrays_that_overlap_stay_together(tmp_path: Path) -> None:
    text = "define void @f(ptr %x, ptr %y) {\n  store i32 7, ptr %x\n  %v = load i32, ptr %y\n"
    kernel = load(tmp_path, text + "  store i32 %v, ptr %y\n  ret void\n}\n")
    x = np.zeros(4, np.int32)
    kernel(x[1:], x[:2])
    assert x.tolist() == [0, 7, 0, 0]


def test_calls_in_a_fork_have_a_process_of_their_own(tmp_path: Path) -> None:
    kernel = load(tmp_path, body("  store i32 %n, ptr %x"))
    kernel(np.zeros(1, np.int32), 1)
    child = os.fork()
    if not child:
        x = np.zeros(1, np.int32)
        kernel(x, 3)
        os._exit(int(x[0]))
    kernel(np.zeros(1, np.int32), 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3


@pytest.mark.parametrize("size", [2**32, 2**33 + 4, 2**34, 2**34 - 4, 2**40 + 1, 2**63])
@pytest.mark.parametrize("kind", ["memcpy", "memmove", "memset"])
def test_sizes_of_blocks_are_not_cut(tmp_path: Path, kind: str, size: int) -> None:
    what = (
        "p0.i64(ptr align 4 %x, i8 1"
        if kind == "memset"
        else ("p0.p0.i64(ptr align 4 %x, ptr align 4 %y")
    )
    text = "  %y = getelementptr i8, ptr %x, i64 8\n"
    kernel = load(
        tmp_path, body(f"{text}  call void @llvm.{kind}.{what}, i64 {size}, i1 0)") + BLOCKS
    )
    program = vividc.compile(kernel, loops=vividc.LoopOptions(auto=False))
    with pytest.raises(SimulationError, match="out-of-bounds"):
        vividc.simulate(program, array(kernel), 1)


def test_a_size_of_64_bits_at_launch_is_not_cut(tmp_path: Path) -> None:
    text = body("  call void @llvm.memset.p0.i64(ptr align 4 %x, i8 1, i64 %n, i1 0)")
    program = vividc.compile(load(tmp_path, text.replace("i32 %n", "i64 %n") + BLOCKS))
    for size in (2**34, 2**34 + 8):
        with pytest.raises(VividcError):
            vividc.simulate(program, np.zeros(16, np.int32), size)
    x = np.zeros(16, np.int32)
    vividc.simulate(program, x, 8)
    assert x.tolist() == [0x01010101] * 2 + [0] * 14


@pytest.mark.parametrize("text", [r"a\\b\22\C2\00", r"\\\\", r"$\\\C2", r"\\22", ""])
def test_bytes_of_strings(tmp_path: Path, text: str) -> None:
    raw, place = bytearray(), 0
    while place < len(text):
        step = 1 if text[place] != "\\" else 2 if text[place + 1] == "\\" else 3
        raw.append(int(text[place + 1 : place + 3], 16) if step == 3 else ord(text[place]))
        place += step
    raw += b"\1\2"
    string = f'@t = internal constant [{len(raw)} x i8] c"{text}\\01\\02"\n'
    assert list(tables_of(string)["t"].values) == list(raw)
    access = "  %w = sext i32 %n to i64\n  %p = getelementptr i8, ptr @t, i64 %w\n"
    access += "  %v = load i8, ptr %p\n  store i8 %v, ptr %x"
    kernel = load(tmp_path, string + body(access))
    assert_as_on_the_host(kernel, *range(len(raw)))


def test_line_breaks_do_not_matter(tmp_path: Path) -> None:
    text = (
        "define void @f(ptr %x,\n i32 %n) {\n  %v = load i32,\n   ptr %x %w = add i32\n %v\n, 3\n"
        "store i32 %w, ptr\n %x switch i32 %n, label %a [ i32 1,\n label %b ]\n"
        "a: ret void\nb:\n  store i32 1, ptr %x ret void }\n"
    )
    assert_as_on_the_host(load(tmp_path, text), 0, 1)


def test_places_are_lines_of_the_file_however_it_breaks_them(tmp_path: Path) -> None:
    text = HEAD + "  %v = load i32,\n   ptr %x\n\n  %w = sdiv i32 %v,\n  7\n"
    text += "  %q = call i32\n   @other(i32 %w)\n  ret void\n}\ndeclare i32 @other(i32)\n"
    with pytest.raises(KernelError, match=r"k\.ll:7: a call of `other`"):
        load(tmp_path, text)


def test_results_without_names(tmp_path: Path) -> None:
    text = (
        "define i32 @f(ptr %0, i32 %1) {\n  load i32, ptr %0\n  add i32 %3, %1\n  ret i32 %4\n}\n"
    )
    assert_as_on_the_host(load(tmp_path, text), 5)


def test_names_with_blanks_and_quotes(tmp_path: Path) -> None:
    text = (
        '%"a b" = type { i32, i32 }\ndefine void @"f g\\22h"(ptr %"x y", i32 %n) {\n'
        '  %"p q" = getelementptr %"a b", ptr %"x y", i32 %n, i32 1\n'
        '  store i32 %n, ptr %"p q"\n  ret void\n}\n'
    )
    assert_as_on_the_host(load(tmp_path, text, 'f g"h'), 0, 2)


def test_arrays_of_arrays_of_bytes(tmp_path: Path) -> None:
    kind = "[16 x [8 x i8]]"
    text = (
        f"  %t = alloca {kind}\n  %p = getelementptr {kind}, ptr %t, i64 0, i64 3, i32 %n\n"
        "  store i8 7, ptr %p\n  %v = load i8, ptr %p\n  store i8 %v, ptr %x"
    )
    assert_as_on_the_host(load(tmp_path, body(text)), 5)


_DEEP = "{ " * 20_000 + "i32" + " }" * 20_000
_NAMED = "\n".join(f"%s{i + 1} = type {{ %s{i}, %s{i} }}" for i in range(3000))
REFUSED = {
    "nested types": (f"%t = type {_DEEP}\n" + body(""), ":1: brackets nested 20000 deep"),
    "nested constants": (
        body(f"  store i32 {'add (i32 1, i32 ' * 20_000}1{')' * 20_000}, ptr %x"),
        ":2: brackets nested 20001 deep",
    ),
    "nested names": (
        f"%s0 = type {{ i32 }}\n{_NAMED}\n"
        + body("  %p = getelementptr %s3000, ptr %x, i64 1\n  store i32 1, ptr %p"),
        "nested more than 100 deep|LLVM",
    ),
    "a NUL byte": (body("  \0"), ":2: a NUL byte"),
    "a large table": (
        "@t = constant [1099511627776 x float] zeroinitializer\n"
        + body(
            "  %p = getelementptr float, ptr @t, i32 %n\n  %v = load float, ptr %p\n"
            "  store float %v, ptr %x"
        ),
        "a constant array of 1099511627776 elements",
    ),
    "a table of another file": (
        "@t = external constant [4 x float]\n"
        + body("  %v = load float, ptr @t\n  store float %v, ptr %x"),
        "k.ll:3: ",
    ),
    "a far address": (
        body("  %p = getelementptr i8, ptr %x, i64 17179869188\n  store i32 5, ptr %p"),
        ":2: an address 2 GiB or more away",
    ),
    "a far element": (
        body("  %p = getelementptr [4294967297 x i32], ptr %x, i64 1\n  store i32 5, ptr %p"),
        ":2: an address 2 GiB or more away",
    ),
    "a far constant": (
        "@t = constant [4 x i32] [i32 1, i32 2, i32 3, i32 4]\n"
        + body(
            "  %v = load i32, ptr getelementptr (i8, ptr @t, i64 4294967300)\n"
            "  store i32 %v, ptr %x"
        ),
        ":3: an address 2 GiB or more away",
    ),
    "names of ours": (
        "declare i32 @vividc.mulhs(i32, i32)\n"
        + body("  %v = call i32 @vividc.mulhs(i32 %n, i32 %n)\n  store i32 %v, ptr %x"),
        "the name `vividc.mulhs`",
    ),
    "an entry of ours": (body("").replace("@f", "@vividc.entry"), "the name `vividc.entry`"),
    "another address space": (
        body("").replace("ptr %x", "ptr addrspace(1) %x"),
        ":1: a pointer to another address space",
    ),
    "puts": (
        '@s = constant [2 x i8] c"a\\00"\ndeclare i32 @puts(ptr)\n'
        + body("  %r = call i32 @puts(ptr @s)"),
        ":4: a call of `puts`",
    ),
    "a jump": (
        "@b = global [200 x i8] zeroinitializer\ndeclare i32 @_setjmp(ptr) returns_twice\n"
        + body("  %r = call i32 @_setjmp(ptr @b)\n  store i32 %r, ptr %x"),
        "(?s):4: a call of `_setjmp`, which leaves functions.*hint: leave loops by conditions",
    ),
    "a variable of a thread": (
        "@t = thread_local global i32 0\ndeclare ptr @llvm.threadlocal.address.p0(ptr)\n"
        + body(
            "  %p = call ptr @llvm.threadlocal.address.p0(ptr @t)\n  %v = load i32, ptr %p\n"
            "  store i32 %v, ptr %x"
        ),
        ":4: a thread-local variable",
    ),
    "memory of any size": (
        "declare ptr @malloc(i32)\n"
        + body("  %p = call ptr @malloc(i32 %n)\n  %v = load i32, ptr %p\n  store i32 %v, ptr %x"),
        "(?s):3: a call of `malloc`.*hint: an array has a constant size, or is a parameter",
    ),
    "a name that begins like Python's": (
        "declare i32 @Pyramid(i32)\n"
        + body("  %v = call i32 @Pyramid(i32 %n)\n  store i32 %v, ptr %x"),
        ":3: a call of `Pyramid`",
    ),
    "a global variable": (
        "@g = global i32 5\n"
        + body("  %v = load i32, ptr @g\n  store i32 %n, ptr @g\n  store i32 %v, ptr %x"),
        "(?s)a global that is no constant.*hint: pass it as a parameter, or make it const",
    ),
    "a function of another file with a name of math.h": (
        "declare i32 @sinf(i32)\n" + body("  %r = call i32 @sinf(i32 1)\n  store i32 %r, ptr %x"),
        ":3: a call of `sinf of another file`",
    ),
    "a function of LLVM that writes": (
        "declare void @llvm.experimental.memset.pattern.p0.i32.i64(ptr, i32, i64, i1)\n"
        + body(
            "  call void @llvm.experimental.memset.pattern.p0.i32.i64("
            "ptr %x, i32 7, i64 4, i1 false)"
        ),
        ":3: a call of `experimental.memset.pattern",
    ),
    "a table of addresses as numbers": (
        "@t = constant [2 x i32] [i32 ptrtoint (ptr @t to i32), i32 2]\n"
        + body(
            "  %p = getelementptr i32, ptr @t, i32 %n\n  %v = load i32, ptr %p\n"
            "  store i32 %v, ptr %x"
        ),
        "an access to a global that is no constant",
    ),
    "too many blocks": (
        HEAD
        + "".join(
            f"  %c{i} = icmp eq i32 %n, {i}\n  br i1 %c{i}, label %y{i}, label %n{i}\n"
            f"y{i}:\n  store volatile i32 {i}, ptr %x\n  br label %n{i}\nn{i}:\n"
            for i in range(600)
        )
        + "  ret void\n}\n",
        "instructions, where 8192 are the most|blocks, where 1024",
    ),
    "too many instructions": (
        "define float @f(float %v0, float %a) {\n"
        + "".join(f"  %v{i + 1} = fadd float %v{i}, %a\n" for i in range(9000))
        + "  ret float %v9000\n}\n",
        "a function of 900. instructions, where 8192 are the most",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_refused(tmp_path: Path, what: str) -> None:
    text, message = REFUSED[what]
    with pytest.raises(KernelError, match=message) as caught:
        load(tmp_path, text, "vividc.entry" if "of ours" in what and "entry" in what else "f")
    assert len(str(caught.value)) < 600


def test_a_file_without_end(tmp_path: Path) -> None:
    (tmp_path / "zero.ll").symlink_to("/dev/zero")
    with pytest.raises(KernelError, match="the limit is 16 MiB"):
        vividc.load_ll(tmp_path / "zero.ll", "f")


PROGRAM = Path(__file__).parent / "c" / "program.ll"
KERNELS = {
    "atax": (2, 3, np.arange(6, dtype=np.float32), np.ones(3, np.float32), np.ones(3, np.float32)),
    "levinson": (4, np.float32([0.5, 0.25, -0.5, 0.125]), *np.zeros((2, 4), np.float32)),
    "substitute": (np.arange(16, dtype=np.uint8), np.zeros(16, np.uint8), 16),
}


@pytest.mark.parametrize("name", KERNELS)
def test_kernels_beside_a_main_program(name: str) -> None:
    kernel = vividc.load_ll(PROGRAM, name)
    by_array, by_host = (
        [x.copy() if isinstance(x, np.ndarray) else x for x in KERNELS[name]] for _ in range(2)
    )
    run(kernel.lower(), *by_array)
    kernel(*by_host)
    for array, host in zip(by_array, by_host, strict=True):
        np.testing.assert_allclose(array, host, rtol=1e-5)


def test_a_main_program_is_no_kernel() -> None:
    with pytest.raises(KernelError, match=r"program\.ll:\d+: a call of `fprintf`"):
        vividc.load_ll(PROGRAM, "main")


def test_attributes_of_unoptimised_code_may_be_a_group_of_their_own(tmp_path: Path) -> None:
    text = body("  store i32 %n, ptr %x").replace(") {", ") #0 {")
    assert_as_on_the_host(load(tmp_path, text + "attributes #0 = { noinline optnone }\n"), 3)


def test_addresses_of_functions_are_not_null(tmp_path: Path) -> None:
    text = "  %t = icmp eq ptr @other, null\n  %u = zext i1 %t to i32\n  store i32 %u, ptr %x"
    assert_as_on_the_host(load(tmp_path, "declare void @other()\n" + body(text)), 1)

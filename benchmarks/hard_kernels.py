"""Kernels that are hard to compile in a short time, each in one dimension, as files' texts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from random import Random

_HEAD = "import numpy as np\nimport numba\nimport vividc\n\n"
_SEED = 1


def _python(signature: str, names: str, *lines: str) -> str:
    body = "\n".join(f"    {line}" for line in lines)
    return f'{_HEAD}@vividc.kernel("{signature}")\ndef hard({names}):\n{body}\n'


def chain(count: int) -> str:
    """Additions one after another, each of another element."""
    sums = (f"a += x[{i}] * {i % 7}" for i in range(count))
    return _python("int32(int32[::1])", "x", "a = np.int32(0)", *sums, "return np.int32(a)")


def expression(count: int) -> str:
    """One expression of so many operands."""
    terms = " + ".join(f"x[i + {i}] * y[i ^ {i % 5}]" for i in range(count))
    return _python(
        "void(int32[::1], int32[::1], int32[::1])",
        "x, y, o",
        "for i in range(len(o)):",
        f"    o[i] = {terms}",
    )


def mixed_widths(count: int) -> str:
    """Expressions in a loop whose operands are of 8 to 64 bits."""
    operands = ("a[i]", "b[i]", "c[i]", "d[i]", "i", "n")
    draw = Random(_SEED)
    lines = []
    for index in range(count):
        first, second, third = (draw.choice(operands) for _ in range(3))
        operator = draw.choice(("+", "-", "*", "&", "^", "|"))
        lines.append(
            f"    o[i, {index}] = (({first} {operator} {second}) >> {index % 9}) + {third}"
        )
    return _python(
        "void(int8[::1], uint16[::1], int32[::1], uint32[::1], int64, int32[:, ::1])",
        "a, b, c, d, n, o",
        "for i in range(len(a)):",
        *lines,
    )


def nest(depth: int) -> str:
    """Loops inside each other."""
    lines = ["s = np.int32(0)"]
    lines += [f"{'    ' * level}for i{level} in range(n):" for level in range(depth)]
    indices = " ^ ".join(f"i{level}" for level in range(depth))
    lines += [f"{'    ' * depth}s += x[({indices}) & 7]", "return np.int32(s)"]
    return _python("int32(int32[::1], int32)", "x, n", *lines)


def loops(count: int) -> str:
    """Loops after each other."""
    lines = []
    for index in range(count):
        lines += ["for i in range(len(x)):", f"    x[i] = x[i] * {index + 2} + y[i] // {index + 3}"]
    return _python("void(int32[::1], int32[::1])", "x, y", *lines)


def branches(count: int) -> str:
    """Conditions after each other in straight code: a region each."""
    lines = ["s = np.int32(0)"]
    for index in range(count):
        lines += [f"if x[{index}] > s:", f"    y[{index}] = s", f"    s += x[{index + 1}]"]
        lines += [f"    for i in range(s & {index + 3}):", "        s ^= y[i]"] * (index % 4 == 0)
    return _python("int32(int32[::1], int32[::1])", "x, y", *lines, "return np.int32(s)")


def switch(cases: int) -> str:
    """A loop around a choice of so many cases."""
    lines = ["s = np.int32(0)", "for i in range(len(x)):"]
    for index in range(cases):
        word = "elif" if index else "if"
        lines += [f"    {word} x[i] == {index * 3}:", f"        s = s * {index + 2} + y[{index}]"]
    return _python("int32(int32[::1], int32[::1])", "x, y", *lines, "return np.int32(s)")


def local_arrays(count: int) -> str:
    """Arrays of the kernel's own, each filled by a loop and read by another."""
    lines = []
    for index in range(count):
        lines += [
            f"t{index} = np.zeros((len(x), {index % 3 + 1}), np.int32)",
            "for i in range(len(x)):",
            f"    t{index}[i, {index % (index % 3 + 1)}] = x[i] + {index}",
        ]
    sums = " + ".join(f"t{index}[i, 0]" for index in range(count))
    return _python("void(int32[::1])", "x", *lines, "for i in range(len(x)):", f"    x[i] = {sums}")


def whole_arrays(count: int) -> str:
    """Statements over whole arrays."""
    draw = Random(_SEED)
    lines = [
        f"{draw.choice('xyz')}[:] = {draw.choice('xyz')} * {i + 1} + np.abs({draw.choice('xyz')})"
        for i in range(count)
    ]
    return _python("void(float32[::1], float32[::1], float32[::1])", "x, y, z", *lines)


def functions(count: int) -> str:
    """Elementary functions in one loop."""
    names = ("exp", "sin", "log", "sqrt", "tanh", "cos", "arctan", "cbrt")
    lines = [f"    s += np.{names[i % len(names)]}(x[i] + np.float32({i}))" for i in range(count)]
    return _python(
        "float32(float32[::1])",
        "x",
        "s = np.float32(0)",
        "for i in range(len(x)):",
        *lines,
        "return s",
    )


def stencil(points: int) -> str:
    """A loop whose iterations hand on so many values."""
    names = [f"v{i}" for i in range(points)]
    lines = [f"{name} = x[{i}]" for i, name in enumerate(names)] + ["for i in range(len(x)):"]
    lines += [
        f"    {name} = {names[i - 1]} * np.float32({i + 1}) + {name}"
        for i, name in enumerate(names)
    ]
    lines += ["    x[i] = " + " + ".join(names)]
    return _python("void(float32[::1])", "x", *lines)


def divisions(count: int) -> str:
    """Divisions of integers by variables, outside of loops."""
    lines = [
        f"y[{i}] = x[{i}] // (y[{i + 1}] | 1) + x[{i + 1}] % (x[{i}] | 3)" for i in range(count)
    ]
    return _python("void(int32[::1], int32[::1])", "x, y", *lines)


def c_straight(count: int) -> str:
    """A C function of one long block, as an unrolled cipher is."""
    lines, last = [], "%v0"
    for i in range(1, count):
        lines.append(f"  %p{i} = getelementptr inbounds i32, ptr %x, i64 {i % 64}")
        lines.append(f"  %l{i} = load i32, ptr %p{i}, align 4")
        lines.append(f"  %s{i} = lshr i32 {last}, {i % 31 + 1}")
        lines.append(f"  %m{i} = mul i32 {last}, {i * 2 + 1}")
        lines.append(f"  %n{i} = xor i32 %m{i}, %s{i}")
        lines.append(f"  %v{i} = add i32 %n{i}, %l{i}")
        lines.append(f"  store i32 %v{i}, ptr %p{i}, align 4")
        last = f"%v{i}"
    body = "\n".join(lines)
    return (
        "define void @hard(ptr noundef %x) {\n"
        "  %v0 = load i32, ptr %x, align 4\n"
        f"{body}\n  ret void\n}}\n"
    )


def c_switch(cases: int) -> str:
    """A C function: a loop around a switch, as of an interpreter of byte code."""
    arms = "\n".join(
        f"c{i}:\n  %m{i} = mul i32 %s, {i + 2}\n  %a{i} = add i32 %m{i}, %k\n  br label %next"
        for i in range(cases)
    )
    table = " ".join(f"i32 {i * 3}, label %c{i}" for i in range(cases))
    merged = ", ".join(f"[ %a{i}, %c{i} ]" for i in range(cases))
    return f"""define i32 @hard(ptr noundef %x, i32 noundef %n) {{
entry:
  br label %loop
loop:
  %i = phi i32 [ 0, %entry ], [ %j, %next ]
  %s = phi i32 [ 1, %entry ], [ %t, %next ]
  %c = icmp slt i32 %i, %n
  br i1 %c, label %body, label %done
body:
  %w = sext i32 %i to i64
  %p = getelementptr inbounds i32, ptr %x, i64 %w
  %k = load i32, ptr %p, align 4
  switch i32 %k, label %next [ {table} ]
{arms}
next:
  %t = phi i32 [ %s, %body ], {merged}
  %j = add nsw i32 %i, 1
  br label %loop
done:
  ret i32 %s
}}
"""


def c_nest(depth: int) -> str:
    """Loops of C inside each other, deeper than Python has them."""
    blocks = []
    for level in range(depth):
        outer, inner = (f"latch{level - 1}" if level else "done"), f"head{level + 1}"
        before = f"head{level - 1}" if level else "entry"
        blocks.append(
            f"head{level}:\n"
            f"  %i{level} = phi i32 [ 0, %{before} ], [ %j{level}, %latch{level} ]\n"
            f"  %s{level} = phi i32 [ {f'%s{level - 1}' if level else '0'}, %{before} ], "
            f"[ %t{level}, %latch{level} ]\n"
            f"  %c{level} = icmp slt i32 %i{level}, %n\n"
            f"  br i1 %c{level}, label %{inner if level < depth - 1 else 'body'}, label %{outer}\n"
            f"latch{level}:\n"
            f"  %t{level} = phi i32 "
            f"[ {f'%s{level + 1}, %head{level + 1}' if level < depth - 1 else '%sum, %body'} ]\n"
            f"  %j{level} = add nsw i32 %i{level}, 1\n"
            f"  br label %head{level}\n"
        )
    return (
        "define i32 @hard(ptr noundef %x, i32 noundef %n) {\nentry:\n  br label %head0\n"
        + "".join(blocks)
        + f"body:\n  %w = sext i32 %i{depth - 1} to i64\n"
        "  %p = getelementptr inbounds i32, ptr %x, i64 %w\n"
        "  %k = load i32, ptr %p, align 4\n"
        f"  %sum = add i32 %s{depth - 1}, %k\n"
        f"  br label %latch{depth - 1}\n"
        "done:\n  ret i32 %s0\n}\n"
    )


Maker = Callable[[int], str]

FAMILIES: Mapping[str, tuple[Maker, tuple[int, ...]]] = {
    "chain": (chain, (500, 20_000)),
    "expression": (expression, (60, 300)),
    "mixed widths": (mixed_widths, (16, 48)),
    "nest": (nest, (8, 18)),
    "loops": (loops, (12, 60)),
    "branches": (branches, (40, 160)),
    "switch": (switch, (30, 120)),
    "local arrays": (local_arrays, (8, 40)),
    "whole arrays": (whole_arrays, (10, 60)),
    "functions": (functions, (8, 40)),
    "stencil": (stencil, (16, 100)),
    "divisions": (divisions, (20, 120)),
    "C, straight": (c_straight, (300, 3_000)),
    "C, switch": (c_switch, (30, 250)),
    "C, nest": (c_nest, (20, 60)),
}
"""Makers of kernels' texts by family, each with the sizes that the table has rows of."""

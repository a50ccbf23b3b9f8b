"""Random kernels over arrays and scalars of every width, and their runs in the interpreter."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from random import Random

import numpy as np

from vividc.dfg.interpreter import interpret
from vividc.dfg.regions import Kernel
from vividc.frontend import KernelFunction

HEADER = """import numpy as np
from vividc.frontend import kernel


@kernel("{returns}(uint8[::1], int8[::1], uint16[::1], int16[::1], boolean[::1], int32[::1], "
        "uint8[:, ::1], uint8, int8, uint16, int16)")
def program(a, b, c, d, e, f, g, p, q, r, s):
    acc = np.{returns}(1)
    total = 0
    for i in range({trip}):
{body}    return np.{returns}({result})
"""

RETURNS = ("int32", "int8", "uint8", "int16", "uint16", "uint32")
TRIPS = ("16", "1, 16", "a.shape[0]", "15, -1, -1", "0, 14, 3", "p & 15", "q & 7")
INDICES = ("i", "15 - i", "i - 1", "acc & 15", "p & 15", "i >> 1", "a[i] & 15", "(i + 1) & 15", "3")
ARRAYS = "abcdef"
CASTS = ("np.uint8", "np.int8", "np.uint16", "np.int16", "np.int32", "np.uint32")
CONSTANTS = (0, 1, -1, 7, 127, 128, 200, 255, 256, -128, 32767, -32768, 65535)
FORMS = (
    "{cast}({a})",
    "{cast}({a})",
    "({cast}({a}) >> {shift})",
    "(np.int32({a}) >> {shift})",
    "np.uint8(np.uint8({a}) >> {shift})",
    "np.int8(np.int8({a}) >> {shift})",
    "np.int16(np.int16({a}) << {shift})",
    "np.uint16(np.uint16({a}) >> {shift})",
    "(np.int16({a}) << {shift})",
    "min({cast}({a}), {cast}({b}))",
    "max(np.int32({a}), np.int32({b}))",
    "min(max(np.int32({a}), -128), 127)",
    "min(max(np.int32({a}), 0), 255)",
    "abs({cast}({a}))",
    "({a} & 255)",
    "np.int32(np.float32(np.int16({a})))",
    "({a} if {cond} else {b})",
)
RING = ("+", "-", "*", "&", "|", "^")
TESTS = ("<", "<=", ">", ">=", "==", "!=")
LENGTH = 16


def random_source(seed: int) -> str:
    """Source of a module whose `program` is a kernel."""
    random = Random(seed)
    body = "".join(_statement(random, 2, 2) for _ in range(random.randint(1, 5)))
    return HEADER.format(
        trip=random.choice(TRIPS),
        body=body,
        returns=random.choice(RETURNS),
        result=random.choice(["acc", "total"]),
    )


def random_kernel(seed: int, folder: Path) -> KernelFunction:
    """The kernel of `random_source`."""
    file = folder / f"bytes{seed}.py"
    file.write_text(random_source(seed), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    kernel: KernelFunction = module.program
    return kernel


def random_arguments(seed: int, trial: int) -> list[object]:
    """Arguments of the kernel; later trials have values nearer to 0."""
    rng = np.random.default_rng([seed, trial])

    def draw(dtype: str, *shape: int) -> np.ndarray:
        info = np.iinfo(dtype)
        limit = (info.max, 200, 3)[trial % 3]
        low, high = max(info.min, -limit - 1), min(info.max, limit)
        return rng.integers(low, high, shape, dtype=dtype, endpoint=True)

    arrays: list[object] = [draw(t, LENGTH) for t in ("uint8", "int8", "uint16", "int16")]
    arrays += [draw("uint8", LENGTH) > LENGTH // 2, draw("int32", LENGTH), draw("uint8", 4, 5)]
    return arrays + [draw(t, 1)[0] for t in ("uint8", "int8", "uint16", "int16")]


def interpreted(lowered: Kernel, arguments: list[object]) -> int | None:
    """Run the graphs; arrays are updated in place, each at the next multiple of 4 bytes."""
    memory = bytearray()
    inputs: dict[str, int] = {}
    places: list[tuple[int, np.ndarray]] = []
    for param, value in zip(lowered.params, arguments, strict=True):
        if isinstance(value, np.ndarray):
            inputs[f"&{param.name}"] = len(memory)
            inputs |= {f"{param.name}.shape{k}": n for k, n in enumerate(value.shape)}
            places.append((len(memory), value))
            memory += value.tobytes() + bytes(-value.nbytes % 4)
        else:
            assert isinstance(value, np.generic)
            inputs[param.name] = int(value) & (1 << 8 * param.dtype.size_bytes) - 1
    result = interpret(lowered, memory, inputs, iteration_limit=100_000)
    for start, array in places:
        raw = np.frombuffer(bytes(memory[start : start + array.nbytes]), array.dtype)
        array[...] = raw.reshape(array.shape)
    return result.value


def _expression(random: Random, depth: int) -> str:
    if depth == 0:
        return _leaf(random)
    a, b = _expression(random, depth - 1), _expression(random, depth - 1)
    if random.random() < 0.5:
        return f"({a} {random.choice(RING)} {b})"
    return random.choice(FORMS).format(
        a=a,
        b=b,
        cast=random.choice(CASTS[:5]),
        cond=_condition(random, depth - 1),
        shift=random.choice([0, 1, 3, 7]),
    )


def _leaf(random: Random) -> str:
    kind = random.random()
    if kind < 0.5:
        return f"{random.choice(ARRAYS)}[{random.choice(INDICES)}]"
    if kind < 0.6:
        return "g[i & 3, (i + 1) & 3]"
    return random.choice("pqrs") if kind < 0.8 else str(random.choice((*CONSTANTS, "acc", "i")))


def _condition(random: Random, depth: int) -> str:
    cast = random.choice(CASTS)
    a, b = _expression(random, depth), _expression(random, depth)
    return f"({cast}({a}) {random.choice(TESTS)} {cast}({b}))"


def _statement(random: Random, depth: int, indent: int) -> str:
    pad = "    " * indent
    kind = random.randint(0, 8) if depth else random.randint(0, 4)
    if kind <= 1:
        return f"{pad}acc = np.{random.choice(RETURNS)}({_expression(random, 2)})\n"
    if kind <= 3:
        return _store(random, pad)
    if kind == 4:
        return f"{pad}total = np.int32(total + {_expression(random, 1)})\n"
    inner = _statement(random, depth - 1, indent + 1)
    if kind <= 6:
        return f"{pad}if {_condition(random, 1)}:\n{inner}"
    if kind == 7:
        return f"{pad}for j in range({random.choice(['3', 'p & 3', '1, 9, 2'])}):\n{inner}"
    leave = random.choice(["continue", "break"])
    return f"{pad}if {_condition(random, 1)}:\n{pad}    {leave}\n"


def _store(random: Random, pad: str) -> str:
    array = random.choice(ARRAYS + "g")
    if array == "g":
        return f"{pad}g[i & 3, i >> 2] = {_expression(random, 2)}\n"
    value = _condition(random, 1) if array == "e" else _expression(random, 2)
    operator = random.choice(["=", "=", "+=", "^="]) if array != "e" else "="
    return f"{pad}{array}[{random.choice(INDICES)}] {operator} {value}\n"

"""Random float32 expressions: those that every machine rounds alike, and elementary functions."""

from __future__ import annotations

from tests.fuzz.integers import Context, integer

EXACT = (
    "({a} + {b})",
    "({a} + {b})",
    "({a} - {b})",
    "({a} * {b})",
    "({a} * {b})",
    "({a} * np.float32({half}))",
    "({a} / np.float32({half}))",
    "min({a}, {b})",
    "max({a}, {b})",
    "abs({a})",
    "(-{a})",
    "({a} if {cond} else {b})",
    "({a} if {a} < {b} else {b})",
    "math.sqrt(abs({a}))",
    "np.floor({a})",
    "np.ceil({a})",
    "np.trunc({a})",
    "np.rint({a})",
    "np.copysign({a}, {b})",
    "blend({a}, {b})",
)
INEXACT = (
    "({a} / {b})",
    "(np.float32(1.0) / {a})",
    "math.exp(min({a}, np.float32(20.0)))",
    "math.exp2(min({a}, np.float32(20.0)))",
    "math.log(abs({a}) + np.float32(0.25))",
    "math.log2(abs({a}) + np.float32(0.25))",
    "math.log1p(abs({a}))",
    "math.sin(min(max({a}, np.float32(-100.0)), np.float32(100.0)))",
    "math.cos(min(max({a}, np.float32(-100.0)), np.float32(100.0)))",
    "math.tanh({a})",
    "math.atan({a})",
    "math.atan2({a}, {b})",
    "math.hypot({a}, {b})",
    "({a} / np.float32(3.0))",
    "(math.sqrt(abs({a})) * np.float32(0.5))",
    "({a} ** 2)",
)
"""Within some ulp of numba's: nothing may depend on their last bits."""


def real(at: Context, depth: int) -> str:
    """A float32 expression whose value is the same bits on every machine."""
    if depth == 0:
        return _leaf(at)
    a, b = real(at, depth - 1), real(at, at.random.randint(0, depth - 1))
    form = at.random.choice(EXACT)
    half = at.random.choice(["0.5", "2.0", "-4.0", "0.0625"])
    return form.format(a=a, b=b, cond=at.condition(0), half=half)


def elementary(at: Context) -> str:
    """A float32 expression of which the last bits depend on the machine."""
    return at.random.choice(INEXACT).format(a=real(at, 1), b=real(at, 0))


def _leaf(at: Context) -> str:
    kind = at.random.random()
    if at.more and kind < 0.1:
        method = at.real_method()
        if method is not None:
            return method
    if kind < 0.4:
        found = at.element(("float32",), False)
        if found is not None:
            return found[0]
    if kind < 0.55:
        inner = integer(at, at.random.randint(0, 1)).text
        dtype = at.random.choice(["int16", "int32", "uint8", "uint32"])
        return f"np.float32(np.{dtype}({inner}))"
    constants = ["np.float32(1.25)", "np.float32(-3.0)", "np.float32(0.1)", "np.float32(0.0)"]
    return at.random.choice(["z", "w", "z", at.random.choice(constants)])

"""Random statements about whole arrays: assignments, operators in place, arrays made on the way,
views under names of their own, arrays that swap their names.
"""

from __future__ import annotations

from math import prod
from typing import Protocol

from tests.fuzz.integers import integer, narrowed_text
from tests.fuzz.places import Array, most
from tests.fuzz.values import TYPES
from tests.fuzz.views import View, part
from tests.fuzz.wholes import Arrays, Elements, whole_condition, whole_integers, whole_reals

MOST_ELEMENTS = 400
"""Of all runs of a statement: interpreters are slow."""

MOST_ARRAYS = 8
"""Those of which no more are made, nor named."""

IN_PLACE = ("+=", "+=", "-=", "*=", "&=", "|=", "^=")


class Block(Arrays, Protocol):
    """Where statements go."""

    branches: int

    def block(self, depth: int, indent: int, most: int = 3) -> str:
        """Some statements."""

    def fresh(self, prefix: str) -> str:
        """A name that nothing has."""

    def use(self, array: Array, indent: int) -> str:
        """A statement in which what is in an array counts."""


def target(at: Block, dtypes: tuple[str, ...] = ()) -> View | None:
    """Part of an array that may be written, and is not too large here."""
    views = []
    for array in at.arrays:
        if array.is_constant or array.name in at.inexact or (dtypes and array.dtype not in dtypes):
            continue
        view = part(at.random, at.places, array, lambda: narrowed_text(integer(at, 0)))
        if at.places.trips() * view.size <= MOST_ELEMENTS:
            views.append(view)
    return at.random.choice(views) if views else None


def array_statement(at: Block, indent: int) -> str | None:
    """A statement, or some; None if there is no array that fits."""
    kind = at.random.random()
    if kind < 0.2 and len(at.arrays) < MOST_ARRAYS:
        return _make(at, indent)
    if kind < 0.3 and len(at.arrays) < MOST_ARRAYS:
        return _name_view(at, indent)
    if kind < 0.36:
        line = _swap_names(at)
    elif kind < 0.42:
        line = _sort(at)
    else:
        view = target(at)
        if view is None:
            return None
        line = _in_place(at, view) if at.random.random() < 0.55 else _assign(at, view)
    return None if line is None else f"{'    ' * indent}{line}\n"


def _value(at: Block, view: View) -> str:
    depth = at.random.choice([0, 1, 1, 2])
    if view.array.dtype == "float32":
        return whole_reals(at, view.dims, depth)
    if view.array.dtype == "boolean":
        return whole_condition(at, view.dims) or "False"
    return whole_integers(at, view.dims, depth).text


def _assign(at: Block, view: View) -> str:
    text = f"{view.text}[:]" if "[" not in view.text else view.text
    return f"{text} = {_value(at, view)}"


def _in_place(at: Block, view: View) -> str | None:
    dtype, random = view.array.dtype, at.random
    if dtype == "boolean":
        return f"{view.text} {random.choice(['&=', '|=', '^='])} {_value(at, view)}"
    if dtype == "float32":
        if random.random() < 0.2:
            return f"{view.text} /= np.float32({random.choice([2.0, -0.5, 8.0])})"
        return f"{view.text} {random.choice(['+=', '-=', '*='])} {_value(at, view)}"
    if dtype.startswith("u"):
        return _unsigned_in_place(at, view)
    return _signed_in_place(at, view)


def _unsigned_in_place(at: Block, view: View) -> str:
    dtype, random = view.array.dtype, at.random
    cast = f"np.{dtype}"
    if random.random() < 0.2:
        return f"{view.text} {random.choice(['//=', '%='])} {cast}({random.choice([1, 3, 7, 64])})"
    if random.random() < 0.2:
        return f"{view.text} {random.choice(['<<=', '>>='])} {cast}({random.choice([1, 3, 5])})"
    value = f"{cast}({narrowed_text(integer(at, 1))})"
    return f"{view.text} {random.choice(IN_PLACE)} {value}"


def _signed_in_place(at: Block, view: View) -> str:
    random, (low, high) = at.random, TYPES[view.array.dtype]
    kind = random.random()
    if kind < 0.15:
        return f"{view.text} {random.choice(['//=', '%='])} {random.choice([1, 2, 3, 7, -3, 255])}"
    if kind < 0.25:
        return f"{view.text} {random.choice(['<<=', '>>='])} {random.choice([0, 1, 3, 7])}"
    if kind < 0.4:
        if view.array.dtype != "int32":
            return f"{view.text} **= {random.choice([2, 3])}"
        # Of larger numbers numba's powers are those of float64.
        return (
            f"{view.text} = {view.text} & 65535; {view.text} **= 2"
            if "[" in view.text
            else (f"{view.text} &= 65535; {view.text} **= 2")
        )
    operator = random.choice(IN_PLACE)
    value = whole_integers(at, view.dims, random.choice([0, 0, 1]))
    return f"{view.text} {operator} {_bounded(value, operator, low, high)}"


def _bounded(value: Elements, operator: str, low: int, high: int) -> str:
    """The value, without the bits that would make the operation overflow 64."""
    room = 2**31 if operator == "*=" else 2**62
    return value.text if value.size < room else f"({value.text} & 65535)"


def _sort(at: Block) -> str | None:
    view = target(at, ("int32", "int16", "uint8", "int8", "uint16", "uint32"))
    if view is None or len(view.dims) > 1 or at.random.random() < 0.5:
        return None
    return (
        f"{view.text}.sort()" if at.random.random() < 0.5 else f"{view.text} = np.sort({view.text})"
    )


def _swap_names(at: Block) -> str | None:
    """In loops and branches, too: then control flow is copied for each array that a name may be."""
    if (at.places.counters or at.branches) and at.random.random() < 0.5:
        return _name_another(at)
    pairs = [
        (one.name, other.name)
        for one in at.arrays
        for other in at.arrays
        if one.name < other.name
        and (one.dtype, one.dims) == (other.dtype, other.dims)
        and not one.is_constant | other.is_constant
    ]
    if not pairs:
        return None
    one, other = at.random.choice(pairs)
    return f"{one}, {other} = {other}, {one}"


def _name_another(at: Block) -> str | None:
    """A name that is one array in one iteration, and a new one in the next."""
    arrays = [
        array
        for array in at.arrays
        if array.name not in at.inexact
        and array.name.startswith("x")
        and array.dtype in ("int32", "float32")
        and at.places.trips() * prod(map(most, array.dims)) <= MOST_ELEMENTS
    ]
    if not arrays:
        return None
    array = at.random.choice(arrays)
    name, scalar = array.name, f"np.int32({at.scalar()})" if array.dtype == "int32" else "z"
    texts = [
        f"{name}.copy()",
        f"{name} {at.random.choice('+-*')} {scalar}",
        f"np.zeros_like({name})",
    ]
    return f"{name} = {at.random.choice(texts)}"


def _name_view(at: Block, indent: int) -> str | None:
    arrays = [a for a in at.arrays if a.name not in at.inexact]
    if not arrays:
        return None
    array = at.random.choice(arrays)
    view = part(at.random, at.places, array, lambda: narrowed_text(integer(at, 0)))
    text, dims = view.text, view.dims
    if len(dims) == 2 and at.random.random() < 0.3:
        text, dims = f"{text}.T", dims[::-1]
    name = at.fresh("u")
    return _scoped(at, Array(name, array.dtype, dims, array.is_constant), text, indent)


def _make(at: Block, indent: int) -> str | None:
    """An array of the kernel's own, of a size that may be known at launch only."""
    views = [
        view
        for array in at.arrays
        if array.name not in at.inexact
        for view in [part(at.random, at.places, array, lambda: "0")]
        if at.places.trips() * view.size <= MOST_ELEMENTS
    ]
    if not views:
        return None
    view = at.random.choice(views)
    dtype, text = _made_like(at, view)
    # Elements of 64 bits are read only: the array has no such.
    array = Array(at.fresh("x"), dtype, view.dims, is_constant=dtype == "int64")
    return _scoped(at, array, text, indent)


def _made_like(at: Block, view: View) -> tuple[str, str]:
    """Type and text of a new array with the lengths of `view`."""
    random, dtype = at.random, view.array.dtype
    new = random.choice(["int32", "float32", "uint8", "int16"])
    shape = f"{view.text}.shape"
    if len(view.dims) == 1 and random.random() < 0.7:
        shape = random.choice([f"len({view.text})", f"{view.text}.size"])
    cases = [
        (dtype, f"{view.text}.copy()"),
        (dtype, f"{view.text}.copy()"),
        (new, f"np.zeros({shape}, np.{new})"),
        (new, f"np.ones({shape}, np.{new})"),
        (new, f"np.full({shape}, np.{new}({random.randint(0, 9)}), np.{new})"),
        (dtype, f"np.zeros_like({view.text})"),
        (dtype, f"np.full_like({view.text}, 1)"),
    ]
    if dtype in ("int32", "int16"):
        scalar = f"np.int32({at.scalar()})"
        cases += [("int32", f"({view.text} {random.choice('+-*&|^')} {scalar})")] * 2
    if dtype == "float32":
        cases += [(dtype, f"({view.text} {random.choice('+-*')} {random.choice('zw')})")] * 2
    if len(view.dims) == 1 and "float" not in dtype and dtype != "boolean":
        cases += [
            ("int64", f"np.arange({shape})"),
            ("int32", f"np.arange({shape}).astype(np.int32)"),
        ]
    return random.choice(cases)


def _scoped(at: Block, array: Array, text: str, indent: int) -> str:
    """The array under its name, and some statements that may use it."""
    at.arrays.append(array)
    line = f"{'    ' * indent}{array.name} = {text}\n"
    inner = at.block(1 if len(at.places.counters) < 2 else 0, indent)
    use = at.use(array, indent)
    at.arrays.remove(array)
    return line + inner + use

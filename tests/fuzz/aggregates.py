"""Random integer expressions through tuples, small arrays made of them, and methods of slices."""

from __future__ import annotations

from tests.fuzz.places import Array
from tests.fuzz.values import TYPES, Value
from tests.fuzz.views import View, part
from tests.fuzz.wholes import INTEGERS, Arrays

MOST_ELEMENTS = 400
"""Of all runs of an expression: interpreters are slow."""

WORD = TYPES["int32"]


def _word(value: Value) -> str:
    return f"np.int32({value.text})"


def _items(at: Arrays, a: Value, b: Value, count: int) -> list[str]:
    """Words of which some are equal and some are constants."""
    pool = [_word(a), _word(b), f"np.int32({at.random.choice([0, 1, -1, 7])})"]
    return [at.random.choice(pool) for _ in range(count)]


def _index(at: Arrays, count: int) -> str:
    scalar = at.scalar()
    return at.random.choice([f"({scalar}) % {count}"] * 2 + [str(at.random.randrange(count))])


def of_tuple(at: Arrays, a: Value, b: Value) -> Value:
    """An element of a tuple."""
    count = at.random.randint(2, 5)
    items = _items(at, a, b, count)
    if at.random.random() < 0.2:
        return Value(f"(({items[0]},) + ({', '.join(items)}))[{_index(at, count + 1)}]", *WORD)
    return Value(f"({', '.join(items)})[{_index(at, count)}]", *WORD)


def of_nested_tuple(at: Arrays, a: Value, b: Value) -> Value:
    """An element of a tuple in a tuple."""
    rows, columns = at.random.randint(2, 3), at.random.randint(2, 3)
    text = ", ".join(f"({', '.join(_items(at, a, b, columns))})" for _ in range(rows))
    return Value(f"({text})[{_index(at, rows)}][{_index(at, columns)}]", *WORD)


def of_array(at: Arrays, a: Value, b: Value) -> Value:
    """An element of an array of runtime values, or its sum."""
    count = at.random.randint(1, 5)
    items = _items(at, a, b, count)
    text = f"({', '.join(items)},)"
    dtype = at.random.choice(["", "", "int32", "uint8", "int16"])
    text = f"np.array({text}, np.{dtype})" if dtype else f"np.array({text})"
    if at.random.random() < 0.2:
        return Value(f"np.int32({text}.sum())", *WORD)
    low, high = TYPES[dtype or "int32"]
    return Value(f"np.int64({text}[{_index(at, count)}])", low, high)


def of_table(at: Arrays, a: Value, b: Value) -> Value:
    """An element of an array of two axes, of runtime values."""
    rows, columns = at.random.randint(1, 3), at.random.randint(1, 3)
    text = ", ".join(f"({', '.join(_items(at, a, b, columns))},)" for _ in range(rows))
    text = f"np.array(({text},)){at.random.choice(['', '.T'])}"
    if text.endswith("T"):
        rows, columns = columns, rows
    return Value(f"np.int64({text}[{_index(at, rows)}, {_index(at, columns)}])", *WORD)


def of_arrays(at: Arrays, a: Value, b: Value) -> Value:
    """A length or an element of an array in a tuple of arrays."""
    arrays = [x for x in at.arrays if x.dtype in INTEGERS and x.name not in at.inexact]
    if len(arrays) < 2:
        return of_tuple(at, a, b)
    chosen = at.random.sample(arrays, 2)
    number = at.random.randrange(2)
    text = f"({chosen[0].name}, {chosen[1].name})[{number}]"
    array = chosen[number]
    if at.places.can_index(array) and at.random.random() < 0.7:
        low, high = TYPES[array.dtype]
        return Value(f"np.int64({text}[{at.places.index(array, at.scalar())}])", low, high)
    return Value(f"{text}.{at.random.choice(['size', 'shape[0]', 'ndim'])}", 0, 600)


def of_pair(at: Arrays, a: Value, b: Value) -> Value:
    """An element of the tuple that a helper function returns."""
    return Value(f"pair({_word(a)}, {_word(b)})[{at.random.randrange(2)}]", *WORD)


def of_slice(at: Arrays, a: Value, b: Value) -> Value:
    """A method of an array or of a slice."""
    found = integer_method(at)
    return a if found is None else found


def integer_method(at: Arrays) -> Value | None:
    """A sum, an extreme, its place, or a count over part of some array."""
    view = _readable(at, (*INTEGERS, "boolean"))
    if view is None:
        return None
    text, dtype = view.text, view.array.dtype
    if len(view.dims) == 1 and at.random.random() < 0.35:
        text = f"{view.text}[{_bounds(at)}]"
    forms = [f"np.int32({text}.sum())", f"np.int32(np.sum({text}))"]
    forms += [f"np.count_nonzero({text})", f"np.int32({text}.any())", f"np.int32(np.all({text}))"]
    if dtype != "boolean":
        form = at.random.choice(["{x}.min()", "{x}.max()", "np.max({x})", "{x}.argmax()"])
        form = at.random.choice([form, form, "{x}.argmin()", "({x} & 3).sum()", "({x} > 3).sum()"])
        safe = (
            f"(np.int64({form.format(x=text)}) if {text}.size > 0 else {at.random.randint(0, 3)})"
        )
        forms += [safe] * 4
    low, high = TYPES["uint32"] if dtype == "uint32" else WORD
    return Value(at.random.choice(forms), min(low, WORD[0]), max(high, WORD[1]))


def _bounds(at: Arrays) -> str:
    n = f"({at.scalar()} & 7)"
    forms = (f"{n}:", f":{n}", f"{n}:{n} + 3", f"-{n}:", f":-{n}", f"{n}::2", f"{n}::-1", f"2:{n}")
    return at.random.choice(forms)


def _readable(at: Arrays, dtypes: tuple[str, ...]) -> View | None:
    views = []
    for array in at.arrays:
        if array.dtype in dtypes and array.name not in at.inexact:
            view = part(at.random, at.places, array, at.scalar)
            if at.places.trips() * view.size <= MOST_ELEMENTS:
                views.append(view)
    return at.random.choice(views) if views else None


def real_method(at: Arrays) -> str | None:
    """A sum or an extreme of float32."""
    view = _readable(at, ("float32",))
    if view is None:
        return None
    if at.random.random() < 0.5:
        return f"np.float32({view.text}.sum())"
    form = at.random.choice(["{x}.min()", "{x}.max()", "np.max({x})"]).format(x=view.text)
    return f"({form} if {view.text}.size > 0 else np.float32(0.5))"


def used(at: Arrays, array: Array, indent: int) -> str:
    """A statement in which what is in an array counts."""
    pad = "    " * indent
    if array.dtype == "float32":
        return f"{pad}z = np.float32(z + {array.name}.sum())\n"
    value = f"{array.name}.sum()"
    if at.places.can_index(array) and at.random.random() < 0.5:
        value = f"{array.name}[{at.places.index(array, at.scalar())}]"
    return f"{pad}s = np.int32(s + np.int32({value}))\n"


AGGREGATES = (of_tuple, of_nested_tuple, of_array, of_table, of_arrays, of_pair)
METHODS = (of_slice, of_slice, of_slice, of_slice)

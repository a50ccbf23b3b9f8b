"""What a kernel returns besides one word: arrays, tuples, and where they lie when it has ended.

An array that a kernel makes and returns is a parameter that the launch makes (`Param.made`), one
word an element, two of int64 and float64 (a float64 is one float32 and a gap), of a complex number
those of its parts. A returned scalar of a tuple is such an array of one element, and so is a
complex number. What of a result only the run decides, such as how long a slice is, the kernel
writes to an array of words beside them.
"""

from __future__ import annotations

import json
from collections import namedtuple
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from keyword import iskeyword
from typing import Any, Final

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from vividc.errors import SimulationError, SourceLoc, raised
from vividc.machine.params import Formula, evaluate_formula
from vividc.machine.words import WORD_MASK

Array = NDArray[Any]
_OUTSIDE: Final = "the kernel returned an array that lies outside its memory"
TUPLE, NONE, OPTIONAL, LIST = "tuple", "none", "optional", "list"
PLACE: Final = "\0"
"""Stands for a number in the text of an exception."""
_WORD: Final = 32
_SCALAR, _ARRAY = "scalar", "array"
_FIRST: Final = {OPTIONAL: _SCALAR, LIST: _ARRAY}
"""What the first value must be that a part of a form takes."""
DTYPES: Final = frozenset(
    {"bool", "float16", "float32", "float64", "complex64", "complex128"}
    | {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
)
"""numpy's names of what may be returned."""


@dataclass(frozen=True, slots=True)
class Leaf:
    """One array, scalar or flag among what is returned.

    Attributes
    ----------
    dtype
        numpy's name of its elements.
    arrays
        The parameters that it may be, or be a part of.
    which
        Which of them it is.
    offset, shape, strides
        Bytes to its first element, elements along each dimension, and bytes from each to the next,
        as numpy counts them for `dtype`.
    is_scalar
        The one element of its array is a scalar.
    """

    dtype: str
    arrays: tuple[str, ...]
    which: Formula = (0,)
    offset: Formula = (0,)
    shape: tuple[Formula, ...] = ()
    strides: tuple[Formula, ...] = ()
    is_scalar: bool = False

    @property
    def is_sound(self) -> bool:
        """Whether it is of a type that there is, with a step for each dimension."""
        return self.dtype in DTYPES and len(self.shape) == len(self.strides)

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """All numbers of the leaf."""
        return (self.which, self.offset, *self.shape, *self.strides)


@dataclass(frozen=True, slots=True)
class Raise:
    """An exception that a kernel may raise.

    Attributes
    ----------
    kind
        The name of its type.
    text
        What it says, with `PLACE` for each number that only the run decides.
    numbers
        What these are: "int", "uint", "bool" or "float". Each takes two words behind that of the
        exception, the low one first, a float the first of them.
    """

    kind: str
    text: str
    file: str = ""
    line: int = 0
    numbers: tuple[str, ...] = ()

    @property
    def is_sound(self) -> bool:
        """Whether the text has a place for each number, and they are such as there are."""
        return self.text.count(PLACE) == len(self.numbers) and set(self.numbers) <= _SAID.keys()

    def said(self, words: Sequence[int]) -> str:
        """The text with the numbers that these words are."""
        first, *rest = self.text.split(PLACE)
        pairs = zip(words[::2], words[1::2], strict=False)
        said = (
            f"{_SAID[kind](low & WORD_MASK, high & WORD_MASK)}{piece}"
            for kind, (low, high), piece in zip(self.numbers, pairs, rest, strict=False)
        )
        return "".join((first, *said))


def _said_int(low: int, high: int) -> int:
    whole = low | high << _WORD
    return whole - ((whole >> 2 * _WORD - 1) << 2 * _WORD)


_SAID: Final[dict[str, Callable[[int, int], object]]] = {
    "int": _said_int,
    "uint": lambda low, high: low | high << _WORD,
    "bool": lambda low, _: bool(low),
    "float": lambda low, _: np.uint32(low).view(np.float32),
}
"""Numbers by what they are, of two words."""


@dataclass(frozen=True, slots=True)
class Results:
    """What a kernel returns.

    Attributes
    ----------
    leaves
        Its arrays, scalars and flags, in order.
    form
        How they are put together, in postfix form: the number of a leaf; "none"; "tuple 2", or with
        the names of a named tuple "tuple 2 Point x y"; "optional": of a flag and a value the value,
        if the flag is set, else None; "list": of an array the list of its elements.
    words
        The array of words that the run decides, "" if there are none. Word k is the input
        "s:" + `words` + ".k" of the leaves' formulas.
    made
        The arrays that the launch makes: others are arguments.
    error, raises
        The array of one word that says which exception the kernel raised, from 1 on; 0: none.
    """

    leaves: tuple[Leaf, ...]
    form: tuple[int | str, ...] = (0,)
    words: str = ""
    made: tuple[str, ...] = ()
    error: str = ""
    raises: tuple[Raise, ...] = ()

    def value(self, arrays: Mapping[str, Array], inputs: Mapping[str, int]) -> object:
        """What the kernel has returned.

        Parameters
        ----------
        arrays
            Those of the launch after it, by parameter.
        inputs
            The words of the launch.

        Raises
        ------
        SimulationError
            An array that it returned lies outside its memory.
        KernelRaised
            The kernel raised an exception; it is one of that type, too.
        """
        self._demand_no_raise(arrays)
        words = arrays[self.words] if self.words else ()
        decided = {f"{self.words}.{n}": int(w) & WORD_MASK for n, w in enumerate(words)}
        known = {**inputs, **decided}
        bases: dict[tuple[str, str], Array] = {}
        made = [partial(self._leaf, leaf, arrays, known, bases) for leaf in self.leaves]
        return _assembled(self.form, made)

    def _demand_no_raise(self, arrays: Mapping[str, Array]) -> None:
        code = int(arrays[self.error][0]) if self.error else 0
        if code:
            one = self.raises[code - 1] if 0 < code <= len(self.raises) else Raise("Exception", "")
            loc = SourceLoc(one.file, one.line) if one.file else None
            raise raised(one.kind, one.said(arrays[self.error].tolist()[1:]), loc)

    @property
    def is_sound(self) -> bool:
        """Whether the form is one of its leaves, with scalars for flags, and so are the texts."""
        if not all(one.is_sound for one in self.raises):
            return False
        kinds: list[str] = []
        for item in self.form:
            if isinstance(item, int):
                if not 0 <= item < len(self.leaves):
                    return False
                kinds.append(_SCALAR if self.leaves[item].is_scalar else _ARRAY)
                continue
            needed = _needed(item)
            if needed is None or len(kinds) < needed:
                return False
            start = len(kinds) - needed
            if item in _FIRST and kinds[start] != _FIRST[item]:
                return False
            kinds[start:] = [""]
        return len(kinds) == 1

    def to_text(self) -> str:
        """JSON."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_text(text: str) -> Results:
        """What `to_text` wrote.

        Raises
        ------
        ValueError, TypeError, KeyError
            The text is nothing of that kind.
        """
        raw = json.loads(text)
        leaves = (
            Leaf(
                leaf["dtype"],
                tuple(leaf["arrays"]),
                tuple(leaf["which"]),
                tuple(leaf["offset"]),
                tuple(map(tuple, leaf["shape"])),
                tuple(map(tuple, leaf["strides"])),
                leaf["is_scalar"],
            )
            for leaf in raw["leaves"]
        )
        raises = tuple(
            Raise(**{**one, "numbers": tuple(one.get("numbers", ()))}) for one in raw["raises"]
        )
        form, made = tuple(raw["form"]), tuple(raw["made"])
        return Results(tuple(leaves), form, raw["words"], made, raw["error"], raises)

    def _leaf(
        self,
        leaf: Leaf,
        arrays: Mapping[str, Array],
        known: Mapping[str, int],
        bases: dict[tuple[str, str], Array],
    ) -> object:
        which = evaluate_formula(leaf.which, known)
        if not 0 <= which < len(leaf.arrays):  # of an optional value that is none
            return None
        name = leaf.arrays[which]
        if (name, leaf.dtype) not in bases:
            elements = _of_words if name in self.made else _of_elements
            bases[name, leaf.dtype] = elements(arrays[name].reshape(-1), np.dtype(leaf.dtype))
        base = bases[name, leaf.dtype]
        if leaf.is_scalar:
            return _view(base, 0, (1,), (base.itemsize,))[0].item()
        offset = evaluate_formula(leaf.offset, known)
        shape = tuple(evaluate_formula(size, known) for size in leaf.shape)
        strides = tuple(evaluate_formula(step, known) for step in leaf.strides)
        whole = arrays[name]
        if (offset, shape, strides) == (
            0,
            whole.shape,
            whole.strides,
        ) and whole.dtype == base.dtype:
            return whole
        return _view(base, offset, shape, strides)


def named_leaves(value: object, name: str = "return") -> Iterator[tuple[str, Array]]:
    """The arrays and scalars of a returned value: `return`, or of a tuple `return0`, `return1`, of
    one in a tuple `return0_0`; None is left out.
    """
    if isinstance(value, tuple):
        joint = "_" if name[-1].isdigit() else ""
        for number, item in enumerate(value):
            yield from named_leaves(item, f"{name}{joint}{number}")
    elif value is not None:
        yield name, np.asarray(value)


def _needed(item: str) -> int | None:
    """How many values a part of a form takes; None: it is none."""
    if item in (NONE, OPTIONAL, LIST):
        return {NONE: 0, LIST: 1, OPTIONAL: 2}[item]
    kind, *rest = item.split(" ")
    if kind != TUPLE or not rest or not (rest[0].isascii() and rest[0].isdigit()):
        return None
    count, names = int(rest[0]), rest[1:]
    if names and (len(names) != count + 1 or not all(map(_is_name, names))):
        return None
    return count if len(set(names[1:])) == len(names[1:]) else None


def _is_name(name: str) -> bool:
    return name.isidentifier() and not name.startswith("_") and not iskeyword(name)


Made = Callable[[], object]


def _assembled(form: tuple[int | str, ...], made: Sequence[Made]) -> object:
    """The value; what is behind a flag that is not set is nothing, and is not looked at."""
    stack: list[Made] = []
    for item in form:
        if isinstance(item, int):
            stack.append(made[item])
        elif item == NONE:
            stack.append(lambda: None)
        elif item == OPTIONAL:
            value, flag = stack.pop(), stack.pop()
            stack.append(partial(_optional, flag, value))
        elif item == LIST:
            stack.append(partial(_list, stack.pop()))
        else:
            _, count, *names = item.split(" ")
            start = len(stack) - int(count)
            stack[start:] = [partial(_tuple, stack[start:], names)]
    return stack.pop()()


def _list(array: Made) -> object:
    return np.asarray(array()).tolist()


def _optional(flag: Made, value: Made) -> object:
    return value() if flag() else None


def _tuple(parts: Sequence[Made], names: Sequence[str]) -> object:
    values = tuple(part() for part in parts)
    make: Any = namedtuple  # its names are data
    return make(names[0], names[1:])(*values) if names else values


def _view(base: Array, offset: int, shape: tuple[int, ...], strides: tuple[int, ...]) -> Array:
    """The part of an array, inside it, whatever the numbers."""
    if min(shape, default=1) < 0:
        raise SimulationError(f"the kernel returned an array of shape {shape}")
    if 0 in shape:
        return np.empty(shape, base.dtype)
    item = base.itemsize
    ends = [(size - 1) * step for size, step in zip(shape, strides, strict=True)]
    first = offset + sum(end for end in ends if end < 0)
    last = offset + sum(end for end in ends if end > 0)
    if first < 0 or last + item > base.nbytes or offset % item:
        raise SimulationError(_OUTSIDE)
    found: Array = as_strided(base[offset // item :], shape, strides)
    return found


def _of_elements(array: Array, dtype: np.dtype[Any]) -> Array:
    """The elements of an argument, looked at as another type if the kernel does."""
    return array if array.dtype == dtype else _viewed(array, dtype)


def _viewed(array: Array, dtype: np.dtype[Any]) -> Array:
    if array.nbytes % dtype.itemsize:
        raise SimulationError(_OUTSIDE)
    return array.view(dtype)


def _of_words(words: Array, dtype: np.dtype[Any]) -> Array:
    """The elements whose words the kernel has written."""
    if dtype in (np.float64, np.complex128):  # float32 words, each before a gap
        return _viewed(_viewed(words, np.dtype(np.float32))[::2].astype(np.float64), dtype)
    if dtype.itemsize >= words.itemsize:
        return _viewed(words, dtype)
    return words != 0 if dtype == np.bool_ else words.astype(dtype)

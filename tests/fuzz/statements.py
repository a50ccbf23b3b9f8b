"""Random statements: loops, branches, jumps, assignments and stores."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

from tests.fuzz.aggregates import real_method, used
from tests.fuzz.array_statements import array_statement
from tests.fuzz.integers import Form, integer, narrowed_text, unsigned
from tests.fuzz.places import Array, Counter, Places, most
from tests.fuzz.reals import elementary, real
from tests.fuzz.values import TYPES

TESTS = ("<", "<=", ">", ">=", "==", "!=")
SHORT = (("3", 2), ("1, 9, 2", 7), ("4", 3), ("n & 3", 3), ("q & 7", 7), ("6, 0, -2", 6), ("1", 0))
"""Ranges that know no array, and the greatest value of their counters."""

WIDE = (
    "-(2**31), 2**30, 2**30",
    "-(2**31), 2**31 - 2**29, 2**29",
    "2**30, -(2**31), -(2**29)",
    "(n & 15) - 2**31, 2**30, 2**28",
    "-5, (q & 7) + 2**30, 2**28",
    "(q & 7) + 2**30, -(2**30) - 2**29, -(2**28)",
)
WIDEST = 12
"""Ranges that no signed word is as wide as, or nearly, and the most iterations of one."""

MOST_TRIPS = 400
"""Of the innermost loop, over all runs of it: interpreters are slow."""


@dataclass
class Program:
    """Writes the body of one kernel."""

    random: Random
    arrays: list[Array]
    places: Places
    returns: str
    is_wide: bool
    number: int = 0
    inexact: set[str] = field(default_factory=set)
    items: list[tuple[str, str]] = field(default_factory=list)
    more: tuple[Form, ...] = ()
    whole: float = 0.0
    branches: int = 0

    def block(self, depth: int, indent: int, most: int = 3) -> str:
        """Some statements."""
        count = self.random.choice([1, 1, 2, most])
        return "".join(self.statement(depth, indent) for _ in range(count))

    def statement(self, depth: int, indent: int) -> str:
        """One statement, of one line or of many."""
        if self.random.random() < self.whole:
            found = array_statement(self, indent)
            if found is not None:
                return found
        kind = self.random.random()
        counters = self.places.counters
        if depth and kind < 0.18:
            return self._branch(depth, indent)
        if depth and kind < 0.36 and len(counters) < 3:
            loop = self.random.choice(
                [self._loop, self._loop, self._loop, self._while, self._halve]
            )
            return loop(depth, indent)
        if counters and kind < 0.42:
            return self._jump(indent)
        return f"{'    ' * indent}{self._assignment()}\n"

    def loop_over(self, depth: int, indent: int) -> str:
        """A loop over a dimension."""
        dims = [d for d in self.places_dims() if self.places.trips() * most(d) <= MOST_TRIPS]
        if not dims:
            return self._short(depth, indent)
        if self.random.random() < 0.15:
            return self._over_items(depth, indent)
        bounds, counter = self.places.over(self._name("i"), self.random.choice(dims))
        return self._with(counter, f"for {counter.name} in range({bounds}):", depth, indent)

    def _over_items(self, depth: int, indent: int) -> str:
        """A loop over the elements of an array, or over its rows."""
        array = self.random.choice([a for a in self.arrays if a.name not in self.inexact])
        if any("-" in dim or "/" in dim for dim in array.dims):
            return self._short(depth, indent)
        trips, item = most(array.dims[0]), self._name("e")
        if self.places.trips() * trips > MOST_TRIPS or array.dtype not in TYPES:
            return self._short(depth, indent)
        counter = Counter(self._name("i"), array.dims[0], 0, 0, trips, trips)
        head = f"for {counter.name}, {item} in enumerate({array.name}):"
        if len(array.dims) > 1:
            row = Array(item, array.dtype, array.dims[1:], array.is_constant)
            self.arrays.append(row)
            text = self._with(counter, head, depth, indent)
            self.arrays.remove(row)
            return text
        self.items.append((item, array.dtype))
        text = self._with(counter, head, depth, indent)
        self.items.pop()
        return text

    def places_dims(self) -> list[str]:
        """The dimensions of the arrays."""
        dims = {dim for array in self.arrays for dim in array.dims}
        return sorted(dim for dim in dims if "-" not in dim and "/" not in dim)

    def _name(self, prefix: str) -> str:
        self.number += 1
        return f"{prefix}{self.number}"

    def scalar(self) -> str:
        """A signed expression that reads no array as a whole."""
        names = [counter.name for counter in self.places.counters]
        return self.random.choice([*names, *names, "n", "s", "q", "np.int64(m8)", "k"])

    def fresh(self, prefix: str) -> str:
        """A name that nothing has."""
        return self._name(prefix)

    def use(self, array: Array, indent: int) -> str:
        """A statement in which what is in an array counts."""
        return used(self, array, indent)

    def real_method(self) -> str | None:
        """A sum or an extreme of float32."""
        return real_method(self)

    def _loop(self, depth: int, indent: int) -> str:
        return (self._short if self.random.random() < 0.25 else self.loop_over)(depth, indent)

    def _over_wide_range(self, indent: int) -> str:
        """A loop whose counter is too large for an index."""
        pad, name = "    " * indent, self._name("w")
        return (
            f"{pad}for {name} in range({self.random.choice(WIDE)}):\n"
            f"{pad}    s = np.int32(s * 5 + ({name} >> 24))\n"
            f"{pad}    {self._assignment()}\n"
        )

    def _short(self, depth: int, indent: int) -> str:
        if self.random.random() < 0.08 and self.places.trips() * WIDEST <= MOST_TRIPS:
            return self._over_wide_range(indent)
        bounds, most = self.random.choice(SHORT)
        counter = Counter(self._name("j"), "", 0, 0, most, most + 1)
        if self.places.trips() * counter.trips > MOST_TRIPS:
            return f"{'    ' * indent}{self._assignment()}\n"
        if self.places.counters and self.random.random() < 0.3:
            bounds = f"{self.places.counters[-1].name} & {most}"
        return self._with(counter, f"for {counter.name} in range({bounds}):", depth, indent)

    def _with(self, counter: Counter, head: str, depth: int, indent: int, first: str = "") -> str:
        pad = "    " * indent
        self.places.counters.append(counter)
        self.places.nonempty.append(counter.dim)
        inner = self.block(depth - 1, indent + 1)
        self.places.nonempty.pop()
        self.places.counters.pop()
        lines = "".join(f"{pad}    {line}\n" for line in first.splitlines())
        text = f"{pad}{head}\n{lines}{inner}"
        if "break\n" in inner and self.random.random() < 0.3:
            text += f"{pad}else:\n{self._inside(0, indent + 1, 1)}"
        return text

    def _inside(self, depth: int, indent: int, most: int) -> str:
        """Statements that do not always run."""
        self.branches += 1
        text = self.block(depth, indent, most)
        self.branches -= 1
        return text

    def _while(self, depth: int, indent: int) -> str:
        """A loop whose counter moves first, so that `continue` does no harm."""
        name, pad = self._name("w"), "    " * indent
        dims = [d for d in self.places_dims() if self.places.trips() * most(d) <= MOST_TRIPS]
        if dims and self.random.random() < 0.6:
            dim = self.random.choice(dims)
            limit, counter = (
                self.places.length(dim),
                Counter(name, dim, 1, -1, most(dim), most(dim)),
            )
        else:
            limit, counter = self.random.choice(["5", "n & 7"]), Counter(name, "", 0, 0, 8, 8)
        if self.places.trips() * counter.trips > MOST_TRIPS:
            return f"{pad}{self._assignment()}\n"
        test, first = f"{name} < {limit}", f"{name} += 1"
        if self.random.random() < 0.3:
            first = f"if {name} >= {limit}:\n    break\n{first}"
            test = "True"
        elif self.random.random() < 0.5:
            test += f" and {self.condition(1)}"
        inner = self._with(counter, f"while {test}:", depth, indent, first)
        return f"{pad}{name} = 0\n{inner}"

    def _halve(self, depth: int, indent: int) -> str:
        """A loop over the bits of a value."""
        name, pad = self._name("v"), "    " * indent
        counter = Counter(name, "", 0, 0, 255, 8)
        if self.places.trips() * counter.trips > MOST_TRIPS:
            return f"{pad}{self._assignment()}\n"
        start = f"{pad}{name} = {narrowed_text(integer(self, 1))} & 255\n"
        step = self.random.choice([f"{name} >>= 1", f"{name} //= 3", f"{name} &= {name} - 1"])
        test = self.random.choice([f"{name}", f"{name} != 0", f"{name} > 0"])
        return start + self._with(counter, f"while {test}:", depth, indent, step)

    def _branch(self, depth: int, indent: int) -> str:
        pad = "    " * indent
        text = f"{pad}if {self.condition(1)}:\n{self._inside(depth - 1, indent + 1, 2)}"
        if self.random.random() < 0.3:
            text += f"{pad}elif {self.condition(1)}:\n{self._inside(depth - 1, indent + 1, 2)}"
        if self.random.random() < 0.5:
            text += f"{pad}else:\n{self._inside(depth - 1, indent + 1, 2)}"
        return text

    def _jump(self, indent: int) -> str:
        pad = "    " * indent
        word = self.random.choice(["break", "continue", "continue", f"return {self.result()}"])
        return f"{pad}if {self.condition(1)}:\n{pad}    {word}\n"

    def result(self) -> str:
        """What the kernel returns."""
        if self.returns == "float32":
            return real(self, 1)
        if self.returns == "uint64":
            return unsigned(self, 1)
        if self.returns == "boolean":
            return f"bool({self.condition(1)})"
        kind = self.random.random()
        text = "s" if kind < 0.3 else integer(self, 1).text
        if kind > 0.8 and self.is_wide:
            text = "t"
        return f"np.{self.returns}({text})"

    def _assignment(self) -> str:
        kind = self.random.random()
        if kind < 0.2:
            return f"s = np.int32({integer(self, 2).text})"
        if kind < 0.3 and self.is_wide:
            return self._wide()
        if kind < 0.48:
            return self._variable()
        if kind < 0.52:
            return self._swap()
        return self._store()

    def _variable(self) -> str:
        """An assignment to an accumulator, a byte or a flag."""
        value = narrowed_text(integer(self, 1))
        forms = (
            f"z = {real(self, 2)}",
            f"z = {real(self, 2)}",
            f"s, z = {value}, {real(self, 1)}",
            f"k += {value}",
            f"k = k + {value}",
            f"k = max(k, {value})",
            f"k -= {self.random.choice(['1', 'np.int64(y)'])}",
            f"y = np.uint8({value})",
            f"y = np.uint8(y + np.uint8({value}))",
            f"f = {self.condition(1)}",
            f"f = f or {self.condition(0)}",
            f"f = f and {self.condition(0)}",
        )
        return self.random.choice(forms)

    def _wide(self) -> str:
        if self.random.random() < 0.4:
            return f"h = {unsigned(self, 2)}"
        if self.random.random() < 0.5:
            return f"t += {narrowed_text(integer(self, 1))}"
        value = integer(self, 2)
        return f"t = np.int64({value.text}) >> {0 if value.size <= 2**62 else 2}"

    def _swap(self) -> str:
        array = self._target()
        if array is None or array.dtype == "boolean" or array.name in self.inexact:
            return f"s = np.int32(s + {integer(self, 1).text})"
        if self.random.random() < 0.15 and array.dtype != "float32":
            whole = f"s ^= np.int32({array.name}.sum())"
            return self.random.choice([f"{array.name}[:] = {self.random.randint(0, 9)}", whole])
        one, other = self._at(array), self._at(array)
        return f"{one}, {other} = {other}, {one}"

    def _store(self) -> str:
        array = self._target()
        if array is None:
            return f"s = np.int32({integer(self, 2).text})"
        target = self._at(array)
        operators = ["=", "=", "+=", "-="]
        if array.name in self.inexact:
            return f"{target} = {elementary(self)}"
        if array.dtype == "boolean":
            return f"{target} = {self.condition(1)}"
        if array.dtype == "float32":
            return f"{target} {self.random.choice(operators)} {real(self, 2)}"
        value = integer(self, 2)
        if array.dtype.startswith("u"):
            cast = self.random.choice([f"np.{array.dtype}({value.text})", value.text])
            word = f"{target} {self.random.choice(['+=', '^='])} np.{array.dtype}({value.text})"
            return self.random.choice([f"{target} = {cast}", word])
        text = value.text if value.size < 2**60 else narrowed_text(value)
        return f"{target} {self.random.choice([*operators, '^='])} {text}"

    def _target(self) -> Array | None:
        found = [a for a in self.arrays if not a.is_constant and self.places.can_index(a)]
        return self.random.choice(found) if found else None

    def _at(self, array: Array, deep: bool = True) -> str:
        inner = integer(self, 1 if deep and self.random.random() < 0.3 else 0)
        return f"{array.name}[{self.places.index(array, inner.text)}]"

    def element(self, dtypes: tuple[str, ...], deep: bool) -> tuple[str, str] | None:
        """An element of an array of one of the types, and its type."""
        found = [
            array
            for array in self.arrays
            if array.dtype in dtypes
            and array.name not in self.inexact
            and self.places.can_index(array)
        ]
        if not found:
            return None
        array = self.random.choice(found)
        if deep:
            return self._at(array), array.dtype
        # A counter or a variable: an element in the index would lead here again.
        names = [counter.name for counter in self.places.counters] or ["s", "n", "q"]
        inner = self.random.choice(names)
        return f"{array.name}[{self.places.index(array, inner)}]", array.dtype

    def real(self, depth: int) -> str:
        """A float32 expression."""
        return real(self, depth)

    def condition(self, depth: int) -> str:
        """A boolean expression."""
        kind = self.random.random()
        if depth and kind < 0.2:
            word = self.random.choice(["and", "or", "and", "or", "and not"])
            return f"({self.condition(0)} {word} {self.condition(0)})"
        if kind < 0.3:
            return f"({real(self, 0)} {self.random.choice(TESTS)} {real(self, 0)})"
        if kind < 0.36:
            flag = self.element(("boolean",), False)
            return self.random.choice("of") if flag is None else flag[0]
        return self._comparison(depth)

    def _comparison(self, depth: int) -> str:
        kind, test = self.random.random(), self.random.choice(TESTS)
        if depth and self.is_wide and kind < 0.1:
            return f"({unsigned(self, depth - 1)} {test} {unsigned(self, 0)})"
        a, b = integer(self, depth).text, integer(self, 0).text
        if kind < 0.2:
            return f"({integer(self, 0).text} <= {a} {self.random.choice(['<', '<=', '!='])} {b})"
        return f"({a} {test} {b})"

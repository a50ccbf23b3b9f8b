"""Recognises a kernel that is one matrix product with its epilogue, in SSA form.

    for i: for j: acc = 0 or bias[j]
        for k: acc += a[i, k] * b[k, j]
        c[i, j] = act(acc + bias[j])

Either loop may be the outer one, and every matrix may be transposed. The loops run from 0 in steps
of 1. What else there may be are checks of sizes that raise (`np.dot(a, b, c)`), if no sizes for
which the product is defined fail them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product as combinations

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import TRAP
from vividc.machine.product import Factor, Product, Size
from vividc.machine.semantics import evaluate
from vividc.ssa.analysis.counters import counter_of
from vividc.ssa.analysis.induction import initial
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Const, Function, Input, Instr, Phi, Ref, Value

_NEST = 3
_WORD_SHIFT = 2
_ONE = 0x3F800000
_MINUS_ONE = 0xBF800000
_CHECKED = range(1, 4)
"""Sizes with which checks of sizes are tried."""
_COMPARISONS = frozenset({Opcode.ICMP_EQ, Opcode.ICMP_NE, Opcode.AND, Opcode.OR})


class _NoProduct(Exception):
    """The kernel is no matrix product; its text says why."""


def recognise(function: Function) -> Product | str:
    """The product that a normalised function computes, or why it is none.

    Returns
    -------
    A product without mode and cost, or the reason as the end of "no matrix product: ...".
    """
    try:
        return _Matcher(function).match()
    except _NoProduct as reason:
        return str(reason)


@dataclass(frozen=True)
class _Counter:
    """A loop, its counter, and its bound."""

    loop: Loop
    phi: int
    limit: Size


def _demand(holds: bool, reason: str) -> None:
    if not holds:
        raise _NoProduct(reason)


class _Matcher:
    def __init__(self, function: Function) -> None:
        self._function = function
        self._made: dict[int, Instr | Phi] = {}
        self._where: dict[int, str] = {}
        for block in function.blocks:
            items: list[Instr | Phi] = [*block.phis, *block.instrs]
            for item in items:
                self._made[item.id] = item
                self._where[item.id] = block.name

    def match(self) -> Product:
        """The product, or _NoProduct."""
        loops = find_loops(self._function)
        _demand(len(loops) == _NEST, f"it has {len(loops)} loops, not 3")
        inner, middle, outer = loops
        nested = inner.header in middle.blocks and middle.header in outer.blocks
        _demand(nested, "its loops are not nested in one another")
        _demand(self._function.returns is None, "it returns a value")
        counters = [self._counter(loop) for loop in (outer, middle, inner)]
        self._demand_straight(outer, {loop.header for loop in loops})
        store = self._store(middle, inner)
        row, col, result = self._result(store, counters[0], counters[1])
        total = self._sum(inner)
        left, right = self._factors(total[1], row, col, counters[2])
        bias, starts, relu = self._epilogue(store.operands[2], total, col)
        product = Product(
            left,
            right,
            result,
            row.limit,
            col.limit,
            counters[2].limit,
            bias,
            starts,
            relu,
            str(total[0].loc or ""),
        )
        _demand(result.array not in (left.array, right.array, bias), "it overwrites what it reads")
        self._check_rest(product, outer)
        return product

    # Values

    def _instr(self, value: Value, op: Opcode) -> Instr | None:
        """The instruction behind a value, if it has this opcode. Phis of one value are seen
        through.
        """
        value = self._plain(value)
        item = self._made[value.id] if isinstance(value, Ref) else None
        return item if isinstance(item, Instr) and item.op is op else None

    def _plain(self, value: Value) -> Value:
        while isinstance(value, Ref):
            item = self._made[value.id]
            if not isinstance(item, Phi) or len(item.incoming) != 1:
                break
            value = item.incoming[0][1]
        return value

    def _is(self, value: Value, id_: int) -> bool:
        return self._plain(value) == Ref(id_)

    # Loops

    def _counter(self, loop: Loop) -> _Counter:
        counter = counter_of(self._function, loop)
        reason = "a loop does not count from 0 in steps of 1 to a bound known before"
        if counter is None or [source for source, _ in loop.exits] != [loop.header]:
            raise _NoProduct(reason)
        _demand((counter.initial, counter.step) == (Const(0), 1), reason)
        _demand(isinstance(counter.limit, Input | Const), reason)
        return _Counter(loop, counter.phi.id, self._size(counter.limit))

    def _store(self, middle: Loop, inner: Loop) -> Instr:
        stores = [
            item
            for item in self._made.values()
            if isinstance(item, Instr)
            and item.op is Opcode.STORE
            and not item.array.startswith(TRAP)
        ]
        _demand(len(stores) == 1, f"it has {len(stores)} stores, not one")
        (store,) = stores
        inside = self._where[store.id] in middle.blocks - inner.blocks
        _demand(inside, "the store is not in the middle loop")
        return store

    def _demand_straight(self, outer: Loop, headers: set[str]) -> None:
        """No branches in the loops but those of their headers: all runs in each iteration."""
        for block in self._function.blocks:
            if block.name in outer.blocks and block.name not in headers:
                _demand(block.branch.cond is None, "there is a condition inside its loops")

    def _result(
        self, store: Instr, outer: _Counter, middle: _Counter
    ) -> tuple[_Counter, _Counter, Factor]:
        """The counters of rows and columns, and the result."""
        _demand(len(store.operands) == _NEST, "its store is conditional")
        for row, col in ((outer, middle), (middle, outer)):
            factor = self._factor(store, row, col)
            if factor is not None and not factor.transposed:
                return row, col, factor
        raise _NoProduct("the result is not stored as c[i, j]")

    def _size(self, value: Value) -> Size:
        settled = self._function.settled(value)
        assert isinstance(settled, Input | Const)
        return settled.key if isinstance(settled, Input) else settled.word

    # Memory

    def _factor(self, access: Instr, first: _Counter, second: _Counter) -> Factor | None:
        """The matrix that is accessed at [first, second], or transposed."""
        if not self._is_element(access, 2):
            return None
        add = self._instr(access.operands[1], Opcode.ADD)
        for times, plus in () if add is None else (add.operands, add.operands[::-1]):
            product = self._instr(times, Opcode.MUL)
            for counter, stride in () if product is None else _both(product.operands):
                if not isinstance(stride, Input | Const):
                    continue
                if self._is(counter, first.phi) and self._is(plus, second.phi):
                    return Factor(access.array, False, self._size(stride))
                if self._is(counter, second.phi) and self._is(plus, first.phi):
                    return Factor(access.array, True, self._size(stride))
        return None

    def _is_element(self, access: Instr, ndim: int) -> bool:
        """Whether it accesses a whole float of a parameter."""
        param = next((p for p in self._function.params if p.name == access.array), None)
        if param is None or param.ndim != ndim or param.dtype.value != "float32":
            return False
        plain = access.shift == _WORD_SHIFT and access.offset == 0
        return plain and access.operands[0] == Input(f"&{access.array}")

    def _sum(self, inner: Loop) -> tuple[Phi, Instr]:
        """The sum that the inner loop carries, and the product that it adds."""
        phis = block_of(self._function, inner.header).phis
        floats = [phi for phi in phis if phi.type is Type.F32]
        _demand(len(floats) == 1, "its inner loop does not carry one sum")
        (phi,) = floats
        update = next(value for source, value in phi.incoming if source in inner.blocks)
        add = self._instr(update, Opcode.FADD)
        for total, term in () if add is None else _both(add.operands):
            product = self._instr(term, Opcode.FMUL)
            if self._is(total, phi.id) and product is not None:
                return phi, product
        raise _NoProduct("its inner loop does not add products to a sum")

    def _factors(
        self, product: Instr, row: _Counter, col: _Counter, inner: _Counter
    ) -> tuple[Factor, Factor]:
        loads = [self._instr(value, Opcode.LOAD) for value in product.operands]
        for one, other in (loads, loads[::-1]):
            if one is None or other is None:
                continue
            left, right = self._factor(one, row, inner), self._factor(other, inner, col)
            if left is not None and right is not None:
                return left, right
        raise _NoProduct("what it multiplies are not elements a[i, k] and b[k, j] of two matrices")

    # What precedes and follows the sum

    def _epilogue(
        self, stored: Value, total: tuple[Phi, Instr], col: _Counter
    ) -> tuple[str, bool, bool]:
        """Bias, whether the sum starts from it, and whether negative results become 0."""
        phi = total[0]
        start = initial(phi, self._loop_of(phi))
        positive = self._positive_part(stored)
        relu, stored = positive is not None, positive or stored
        begins = "" if start == Const(0) else self._bias(start, col)
        _demand(begins is not None, "its sum starts neither from 0 nor from bias[j]")
        if self._is(stored, phi.id):
            return begins or "", True, relu
        add = self._instr(stored, Opcode.FADD)
        for kept, added in () if add is None else _both(add.operands):
            bias = self._bias(added, col)
            if self._is(kept, phi.id) and bias:
                _demand(not begins, "it adds two biases")
                return bias, False, relu
        raise _NoProduct("what it stores is not the sum, with a bias[j] and max(..., 0) at most")

    def _loop_of(self, phi: Phi) -> frozenset[str]:
        header = self._where[phi.id]
        return next(lp.blocks for lp in find_loops(self._function) if lp.header == header)

    def _bias(self, value: Value, col: _Counter) -> str | None:
        """The array whose element of the column this is."""
        load = self._instr(value, Opcode.LOAD)
        if load is None or not self._is_element(load, 1) or not self._is(load.operands[1], col.phi):
            return None
        return load.array

    def _positive_part(self, value: Value) -> Value | None:
        """x, if a value is max(x, 0) as a number."""
        select = self._instr(value, Opcode.SELECT)
        if select is None:
            return None
        inside = [self._plain(arm) for arm in select.operands[1:] if arm != Const(0)]
        condition = select.operands[0]
        test = self._made[condition.id] if isinstance(condition, Ref) else None
        if len(inside) != 1 or not isinstance(test, Instr):
            return None
        if not test.mnemonic.startswith("fcmp"):
            return None
        (x,) = inside
        if any(self._plain(operand) not in (x, Const(0)) for operand in test.operands):
            return None
        expected = {_ONE: _ONE, _MINUS_ONE: 0, 0: 0}
        for word, wanted in expected.items():
            words = [word if self._plain(o) == x else 0 for o in test.operands]
            arms = [word if self._plain(o) == x else 0 for o in select.operands[1:]]
            if arms[1 - evaluate(test.opcode, words)] != wanted:
                return None
        return x

    # What else there is

    def _check_rest(self, product: Product, outer: Loop) -> None:
        """Outside the loops there is nothing but checks that a defined product passes."""
        for block in self._function.blocks:
            if block.name in outer.blocks or block.branch.cond is None:
                continue
            raising = [t for t in block.branch.successors if self._raises(t)]
            _demand(len(raising) == 1, "there is a condition around its loops")
            taken = block.branch.target == raising[0]
            for sizes in combinations(_CHECKED, repeat=_NEST):
                words = _shapes(product, *sizes)
                if self._word(block.branch.cond, words) == int(taken):
                    raise _NoProduct("a check before its loops asks for certain sizes")

    def _raises(self, name: str) -> bool:
        """Whether a block raises, whatever else it does."""
        block = block_of(self._function, name)
        return any(i.op is Opcode.STORE and i.array.startswith(TRAP) for i in block.instrs)

    def _word(self, value: Value, shapes: Mapping[str, int]) -> int:
        if isinstance(value, Const) and value.word < _CHECKED.stop:
            return value.word
        if isinstance(value, Input) and value.key in shapes:
            return shapes[value.key]
        item = self._made[value.id] if isinstance(value, Ref) else None
        if isinstance(item, Instr) and item.op in _COMPARISONS:
            return evaluate(item.op, [self._word(operand, shapes) for operand in item.operands])
        raise _NoProduct("a check before its loops is not one of the matrices' sizes")


def _shapes(product: Product, rows: int, cols: int, depth: int) -> dict[str, int]:
    """The sizes of a product's arrays, by input key."""
    sizes = {
        product.left: (rows, depth),
        product.right: (depth, cols),
        product.result: (rows, cols),
    }
    words: dict[str, int] = {}
    for factor, shape in sizes.items():
        for axis, size in enumerate(shape[::-1] if factor.transposed else shape):
            words[f"{factor.array}.shape{axis}"] = size
    if product.bias:
        words[f"{product.bias}.shape0"] = cols
    return words


def _both(pair: tuple[Value, ...]) -> tuple[tuple[Value, ...], tuple[Value, ...]]:
    return pair, pair[::-1]

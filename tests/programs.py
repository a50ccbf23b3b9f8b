"""Random structured integer programs: an AST, its direct meaning in Python, and its SSA control-
flow graph.

They vary: the order and kinds of statements, branches, jumps out of loops and to their next
iteration; counted loops of all trip counts and loops with a test of their own, nested up to a
depth; loads and stores of words, halves and bytes at addresses that depend on data (`programs`);
nests with one loop in another and code on both sides of it (`nests`); and nests of two loops whose
accesses are affine in both counters, as dependence tests want them (`affine_nests`).
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass, field

from hypothesis import strategies as st

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, Param
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref, Value

VARIABLES = 3
WORDS = 16
CELLS = 64
"""Words of the array that affine nests need; others use the first 16."""

MASK = 0xFFFFFFFF


@dataclass(frozen=True)
class Assign:
    """v[target] = v[left] op v[right] (or a constant); op: add, sub, xor, mul, or set (to it)."""

    target: int
    op: str
    left: int
    right: int
    constant: int | None


@dataclass(frozen=True)
class Load:
    """v[target] = a[v[index] & 15], or of bytes or halves of the same memory."""

    target: int
    index: int
    width: int = 4
    signed: bool = False


@dataclass(frozen=True)
class Store:
    """a[v[index] & 15] = v[value], or the value's low bytes to bytes or halves."""

    index: int
    value: int
    width: int = 4


@dataclass(frozen=True)
class Access:
    """v[2] += a[index] ("load") or a[index] = v[2] ("store"), at v[0] * row + v[1] * column +
    constant.
    """

    kind: str
    row: int = 0
    column: int = 0
    constant: int = 0


@dataclass(frozen=True)
class If:
    """if v[left] < v[right] (signed)."""

    left: int
    right: int
    then: tuple[object, ...]
    other: tuple[object, ...]


@dataclass(frozen=True)
class For:
    """for index in range(start, count): a counted loop whose index is read into v[target]."""

    target: int
    start: int
    count: int
    body: tuple[object, ...]


@dataclass(frozen=True)
class While:
    """while v[left] < v[right], at most `fuel` times (the fuel is a variable of its own)."""

    left: int
    right: int
    fuel: int
    body: tuple[object, ...]


@dataclass(frozen=True)
class Jump:
    """`break` or `continue` if v[left] < v[right]."""

    kind: str
    left: int
    right: int


Program = tuple[object, ...]
Strategy = st.SearchStrategy[Program]
_VARIABLE = st.integers(0, VARIABLES - 1)
_WIDTHS = st.sampled_from([1, 2])


def programs(depth: int = 2) -> Strategy:
    """Statement lists with loops nested up to `depth` deep."""
    return _statements(depth, in_loop=False)


def nests(depth: int = 3) -> Strategy:
    """Some statements, one nest up to `depth` deep in which each loop has at most one in its body,
    and more statements.
    """
    return _around(_nest(depth), in_loop=False)


@dataclass(frozen=True)
class Nest:
    """for i in range(outer): v[2] = i (or goes on); before; for j in range(inner): body; after."""

    outer: int
    inner: int
    before: Program
    body: Program
    after: Program
    fresh: bool = True

    @property
    def program(self) -> Program:
        """Its statements; v[0] is i, v[1] is j, which starts anew with each i."""
        start = (Assign(2, "add", 0, 0, 0),) if self.fresh else ()
        body = (Assign(1, "set", 1, 1, 0), *start, *self.before)
        inner = For(1, 0, self.inner, self.body)
        return (For(0, 0, self.outer, (*body, inner, *self.after)),)


def affine_nests() -> st.SearchStrategy[Nest]:
    """Nests of up to six by five iterations; every index lies in the array."""
    small, mix = st.integers(0, 4), st.just(Assign(2, "mul", 2, 2, 3))
    access = st.builds(Access, st.sampled_from(["load", "store"]), small, small, st.integers(0, 20))
    steps = st.lists(access | access | mix, max_size=2).map(tuple)
    fresh = st.booleans() | st.just(True)
    return st.builds(Nest, st.integers(0, 6), st.integers(0, 5), steps, steps, steps, fresh)


def _simple(*, in_loop: bool) -> list[st.SearchStrategy[object]]:
    """Statements without others in them."""
    ops, constant = st.sampled_from(["add", "sub", "xor"]), st.none() | st.integers(-4, 9)
    choices: list[st.SearchStrategy[object]] = [
        st.builds(Assign, _VARIABLE, ops, _VARIABLE, _VARIABLE, constant),
        st.builds(Load, _VARIABLE, _VARIABLE),
        st.builds(Store, _VARIABLE, _VARIABLE),
        st.builds(Load, _VARIABLE, _VARIABLE, _WIDTHS, st.booleans()),
        st.builds(Store, _VARIABLE, _VARIABLE, _WIDTHS),
    ]
    jump = st.builds(Jump, st.sampled_from(["break", "continue"]), _VARIABLE, _VARIABLE)
    return [*choices, jump] if in_loop else choices


def _statements(depth: int, *, in_loop: bool) -> Strategy:
    choices = _simple(in_loop=in_loop)
    if depth:
        inner = _statements(depth - 1, in_loop=in_loop)
        choices.append(st.builds(If, _VARIABLE, _VARIABLE, inner, inner))
        choices += _loops(_statements(depth - 1, in_loop=True))
    return st.lists(st.one_of(choices), min_size=1, max_size=4).map(tuple)


def _loops(body: Strategy) -> list[st.SearchStrategy[object]]:
    return [
        st.builds(For, _VARIABLE, st.integers(0, 2), st.integers(-1, 5), body),
        st.builds(While, _VARIABLE, _VARIABLE, st.integers(1, 5), body),
    ]


def _few(*, in_loop: bool, depth: int = 1) -> Strategy:
    """Up to two statements without a loop."""
    choices = _simple(in_loop=in_loop)
    if depth:
        inner = _few(in_loop=in_loop, depth=depth - 1)
        choices.append(st.builds(If, _VARIABLE, _VARIABLE, inner, inner))
    return st.lists(st.one_of(choices), max_size=2).map(tuple)


def _around(middle: st.SearchStrategy[object], *, in_loop: bool) -> Strategy:
    few = _few(in_loop=in_loop)
    return st.tuples(few, middle, few).map(lambda parts: (*parts[0], parts[1], *parts[2]))


def _nest(depth: int) -> st.SearchStrategy[object]:
    body = _few(in_loop=True)
    if depth > 1:
        inner = _nest(depth - 1)
        skipped = st.builds(If, _VARIABLE, _VARIABLE, st.tuples(inner), body)
        body = _around(st.one_of(inner, inner, skipped), in_loop=True)
    counted, tested = _loops(body)
    return st.one_of(counted, counted, tested)


_OPERATIONS = {
    "add": operator.add,
    "sub": operator.sub,
    "xor": operator.xor,
    "mul": operator.mul,
    "set": lambda _, right: right,
}


class _Break(BaseException):
    pass


class _Continue(BaseException):
    pass


def signed(word: int) -> int:
    """Two's complement."""
    return word - (1 << 32) if word & 0x80000000 else word


def run(program: Sequence[object], memory: list[int]) -> None:
    """What the program means: `memory` after it, its variables added to the last words."""
    v = [3, 5, 7]
    _run(program, v, memory)
    for number in range(VARIABLES):
        memory[number] = (memory[number] + v[number]) & MASK


def _run(statements: Sequence[object], v: list[int], a: list[int]) -> None:
    for s in statements:
        match s:
            case Assign(target, op, left, right, constant):
                other = v[right] if constant is None else constant
                v[target] = _OPERATIONS[op](v[left], other) & MASK
            case Access() | Load() | Store():
                _access(s, v, a)
            case If(left, right, then, other):
                _run(then if signed(v[left]) < signed(v[right]) else other, v, a)
            case Jump(kind, left, right):
                if signed(v[left]) < signed(v[right]):
                    raise _Break if kind == "break" else _Continue
            case For(target, start, count, body):
                _loop(iter(range(start, count)), target, body, v, a)
            case While(left, right, fuel, body):
                _while(left, right, fuel, body, v, a)


def _access(s: Access | Load | Store, v: list[int], a: list[int]) -> None:
    match s:
        case Access(kind, row, column, constant):
            index = row * v[0] + column * v[1] + constant
            if kind == "load":
                v[2] = (v[2] + a[index]) & MASK
            else:
                a[index] = v[2]
        case Load(target, index, width, is_signed):
            raw = _bytes(a)[_place(v[index], width)]
            v[target] = int.from_bytes(raw, "little", signed=is_signed) & MASK
        case Store(index, value, width):
            memory = _bytes(a)
            memory[_place(v[index], width)] = v[value].to_bytes(4, "little")[:width]
            a[:] = memoryview(memory).cast("I").tolist()


def _bytes(words: list[int]) -> bytearray:
    return bytearray(b"".join(word.to_bytes(4, "little") for word in words))


def _place(index: int, width: int) -> slice:
    start = index % (4 * WORDS // width) * width
    return slice(start, start + width)


def _loop(indices: object, target: int, body: Sequence[object], v: list[int], a: list[int]) -> None:
    for index in indices:  # type: ignore[attr-defined]
        v[target] = index
        try:
            _run(body, v, a)
        except _Continue:
            continue
        except _Break:
            break


def _while(
    left: int, right: int, fuel: int, body: Sequence[object], v: list[int], a: list[int]
) -> None:
    while signed(v[left]) < signed(v[right]) and fuel > 0:
        fuel -= 1
        try:
            _run(body, v, a)
        except _Continue:
            continue
        except _Break:
            break


Env = list[Value]


@dataclass
class _Lowering:
    """Emits SSA blocks; `current` is None after a jump."""

    ids: int = 0
    names: int = 0
    done: list[Block] = field(default_factory=list)
    name: str = "entry"
    phis: tuple[Phi, ...] = ()
    instrs: list[Instr] = field(default_factory=list)

    def new_id(self) -> int:
        self.ids += 1
        return self.ids - 1

    def new_name(self) -> str:
        self.names += 1
        return f"b{self.names}"

    def emit(
        self, op: Opcode, result: Type, *operands: Value, width: int = 4, signed: bool = False
    ) -> Ref:
        ident = self.new_id()
        memory = op in (Opcode.LOAD, Opcode.STORE)
        array, shift = ("a", width.bit_length() - 1) if memory else ("", 0)
        instr = Instr(ident, op, result, operands, array, shift, width=width, signed=signed)
        self.instrs.append(instr)
        return Ref(ident)

    def finish(self, branch: Branch) -> str:
        self.done.append(Block(self.name, self.phis, tuple(self.instrs), branch))
        return self.name

    def start(self, name: str, edges: list[tuple[str, Env]]) -> Env:
        """A block reached from `edges`: a phi for each variable (trivial ones included)."""
        self.name, self.instrs = name, []
        ids = [self.new_id() for _ in edges[0][1]]
        self.phis = tuple(
            Phi(ident, Type.I32, tuple((source, env[k]) for source, env in edges))
            for k, ident in enumerate(ids)
        )
        return [Ref(ident) for ident in ids]

    def less(self, env: Env, left: int, right: int) -> Value:
        return self.emit(Opcode.ICMP_SLT, Type.PRED, env[left], env[right])

    def address(self, env: Env, index: int, width: int) -> Value:
        return self.emit(Opcode.AND, Type.I32, env[index], Const(4 * WORDS // width - 1))

    def access(self, env: Env, s: Access) -> Env:
        index: Value = Const(s.constant)
        for variable, factor in ((0, s.row), (1, s.column)):
            if factor:
                scaled = self.emit(Opcode.MUL, Type.I32, env[variable], Const(factor))
                index = self.emit(Opcode.ADD, Type.I32, scaled, index)
        if s.kind == "store":
            self.emit(Opcode.STORE, Type.NONE, Input("&a"), index, env[2])
            return env
        word = self.emit(Opcode.LOAD, Type.I32, Input("&a"), index)
        return [*env[:2], self.emit(Opcode.ADD, Type.I32, env[2], word), *env[3:]]

    def load(self, env: Env, s: Load) -> Value:
        place = Input("&a"), self.address(env, s.index, s.width)
        signed = s.signed and s.width < 4
        return self.emit(Opcode.LOAD, Type.I32, *place, width=s.width, signed=signed)

    def store(self, env: Env, s: Store) -> Value:
        place = Input("&a"), self.address(env, s.index, s.width)
        return self.emit(Opcode.STORE, Type.NONE, *place, env[s.value], width=s.width)


Targets = tuple[str, list[tuple[str, Env]], str, list[tuple[str, Env]]]


def lower(program: Sequence[object]) -> Function:
    """The program as a kernel over one array `a` of 16 words."""
    low = _Lowering()
    env: Env = [Const(3), Const(5), Const(7)]
    env = _lower(program, env, low, None) or env
    for number in range(VARIABLES):
        address = Const(number)
        old = low.emit(Opcode.LOAD, Type.I32, Input("&a"), address)
        total = low.emit(Opcode.ADD, Type.I32, old, env[number])
        low.emit(Opcode.STORE, Type.NONE, Input("&a"), address, total)
    low.finish(Branch())
    return Function("random", (Param("a", DType.I32, 1),), tuple(low.done))


def _lower(statements: Sequence[object], env: Env, low: _Lowering, loop: Targets | None) -> Env:
    for s in statements:
        env = list(env)
        match s:
            case Assign(target, op, left, right, constant):
                other = env[right] if constant is None else Const(constant & MASK)
                is_set = op == "set"
                env[target] = other if is_set else low.emit(Opcode(op), Type.I32, env[left], other)
            case Access():
                env = low.access(env, s)
            case Load():
                env[s.target] = low.load(env, s)
            case Store():
                low.store(env, s)
            case If():
                env = _lower_if(s, env, low, loop)
            case Jump():
                env = _lower_jump(s, env, low, loop)
            case For():
                env = _lower_for(s, env, low)
            case While():
                env = _lower_while(s, env, low)
    return env


def _lower_if(s: If, env: Env, low: _Lowering, loop: Targets | None) -> Env:
    then, other, join = low.new_name(), low.new_name(), low.new_name()
    source = low.finish(Branch(then, low.less(env, s.left, s.right), other))
    ends = []
    for name, body in ((then, s.then), (other, s.other)):
        inner = _lower(body, low.start(name, [(source, env)]), low, loop)
        ends.append((low.finish(Branch(join)), inner))
    return low.start(join, ends)


def _lower_jump(s: Jump, env: Env, low: _Lowering, loop: Targets | None) -> Env:
    assert loop is not None
    exit_name, exits, latch_name, latches = loop
    leave, stay = low.new_name(), low.new_name()
    source = low.finish(Branch(leave, low.less(env, s.left, s.right), stay))
    inner = low.start(leave, [(source, env)])
    name, edges = (exit_name, exits) if s.kind == "break" else (latch_name, latches)
    edges.append((low.finish(Branch(name)), inner))
    return low.start(stay, [(source, env)])


def _lower_for(s: For, env: Env, low: _Lowering) -> Env:
    extended = [*env, Const(s.start)]
    return _lower_loop(
        low,
        extended,
        test=lambda e: low.emit(Opcode.ICMP_SLT, Type.PRED, e[-1], Const(s.count & MASK)),
        body=s.body,
        enter=lambda e: [*e[: s.target], e[-1], *e[s.target + 1 :]],
        step=lambda e: [*e[:-1], low.emit(Opcode.ADD, Type.I32, e[-1], Const(1))],
    )


def _lower_while(s: While, env: Env, low: _Lowering) -> Env:
    extended = [*env, Const(s.fuel)]

    def test(e: Env) -> Value:
        fuel = low.emit(Opcode.ICMP_SLT, Type.PRED, Const(0), e[-1])
        return low.emit(Opcode.AND, Type.PRED, low.less(e, s.left, s.right), fuel)

    def enter(e: Env) -> Env:
        return [*e[:-1], low.emit(Opcode.SUB, Type.I32, e[-1], Const(1))]

    return _lower_loop(low, extended, test, s.body, enter, step=lambda e: e)


def _lower_loop(low, env, test, body, enter, step) -> Env:  # type: ignore[no-untyped-def]
    header, inside, latch, after = (low.new_name() for _ in range(4))
    before = low.finish(Branch(header))
    at_header = low.start(header, [(before, env)])
    phis = low.phis
    condition = test(at_header)
    low.finish(Branch(inside, condition, after))
    exits: list[tuple[str, Env]] = [(header, at_header)]
    latches: list[tuple[str, Env]] = []
    position = len(low.done) - 1
    inner = enter(low.start(inside, [(header, at_header)]))
    count = len(inner)
    counter = inner[-1]
    end = _lower(body, inner, low, (after, exits, latch, latches))
    end = [*end[: count - 1], counter]
    latches.append((low.finish(Branch(latch)), end))
    full = [(name, [*e[: count - 1], counter]) for name, e in latches]
    stepped = step(low.start(latch, full))
    back = low.finish(Branch(header))
    block = low.done[position]
    closed = tuple(
        Phi(phi.id, phi.type, (*phi.incoming, (back, stepped[k]))) for k, phi in enumerate(phis)
    )
    low.done[position] = Block(block.name, closed, block.instrs, block.branch)
    cut = [(name, e[: count - 1]) for name, e in exits]
    return low.start(after, cut)

"""Plants small defects in the SSA passes, and counts which tests notice: `python -m tests.mutants`.

A defect is one change of a pass's syntax tree: a field forgotten in a `replace`, two operands
exchanged, a use dropped, an intersection or a union left out, a number off by one, the wrong side
of a relation, a condition negated, `<` for `<=`. As many are drawn from each pass, by a seed. Each
runs in a process of its own, first with the cases of the pass's own test file, then with all of
that file, then with the tests of others. Defects that change nothing anybody could notice are
listed in `EQUIVALENT`, each with its reason, and drawn anew.

    python -m tests.mutants                    draw, run, and write the table of tests/README.md
    python -m tests.mutants --only diamonds    of one pass
"""

from __future__ import annotations

import argparse
import ast
import copy
import importlib
import importlib.abc
import importlib.machinery
import os
import random
import re
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType

import numba  # noqa: F401  (here, so that no process that is split off has to)
import pytest

import vividc
from tests.mutants_equivalent import EQUIVALENT

ROOT = Path(__file__).parents[1]
ROOMS = ("rewrite", "loops", "formats", "parallel", "polyhedral")
README = ROOT / "tests/README.md"
COUNT, SEED = 100, 1
OWN_S, OTHERS_S = 60, 600
"""Of processor time. Who waits for something has `_PATIENCE` times as long."""
_PATIENCE = 20
OTHERS = ("tests/ssa", "tests/dfg/cut", "tests/compiler/planning", "tests/e2e/test_transforms.py")
_ORDERS = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
_RECORDS = {"replace", "Instr", "Phi", "Branch", "Block", "Clone"}
_SETS = {
    "intersect",
    "intersect_domain",
    "intersect_range",
    "intersect_params",
    "union",
    "subtract",
}
_SIDES = {"in_": "out", "out": "in_"}
_BOUNDS = (("<= ", "< "), (">= ", "> "), ("< ", "<= "), ("> ", ">= "))
"""In isl's words."""
_BESIDE = {
    "parallel/products/checks": ("parallel/products/recognise",),
    "parallel/products/effects": ("parallel/products/recognise",),
    "parallel/products/rows": ("parallel/products/recognise",),
    "parallel/products/steps": ("parallel/products/recognise",),
    "polyhedral/loops": ("polyhedral/guards", "polyhedral/generate"),
    "polyhedral/places": ("polyhedral/generate",),
    "polyhedral/relations": ("polyhedral/met",),
    "polyhedral/schedule": ("polyhedral/guards", "polyhedral/orders"),
    "polyhedral/scop": ("polyhedral/met", "polyhedral/generate"),
    "polyhedral/trees": ("polyhedral/orders", "polyhedral/rows"),
    "polyhedral/words": ("polyhedral/generate",),
    "polyhedral/orders/bands": ("polyhedral/orders/realigned",),
    "polyhedral/orders/families": ("polyhedral/orders/realigned",),
    "polyhedral/orders/search": ("polyhedral/orders",),
    "polyhedral/writing/registers": ("polyhedral/generate", "polyhedral/streams"),
    "polyhedral/writing/words": ("polyhedral/generate",),
}
"""Tests of modules beside those named after them: they are no pass by themselves."""


@dataclass(frozen=True)
class Pass:
    """A module of passes, and the test files that mirror it."""

    name: str
    source: Path
    tests: tuple[Path, ...]

    @property
    def own(self) -> tuple[str, ...]:
        """What pytest is to run of the pass's own: its test, or its cases in that of all passes."""
        if self.tests:
            return tuple(map(str, self.tests))
        return (str(ROOT / "tests/test_passes.py"), "-k", f"ssa/{self.name}:")

    @property
    def quickest(self) -> tuple[str, ...]:
        """The cases in its test, or all of its own if there are none."""
        cases = ROOT / f"tests/ssa/{self.name}.cases"
        return (*self.own, "-k", "rules") if cases.exists() and self.tests else self.own


_Step = tuple[str, int | None]


@dataclass(frozen=True)
class Mutant:
    """A defect: what stands for the node of a pass's tree that this way leads to."""

    of: Pass
    kind: str
    tree: ast.Module
    path: tuple[_Step, ...]
    new: ast.AST

    @property
    def change(self) -> str:
        """What is changed, and in which function."""
        node: ast.AST = self.tree
        names = []
        for name, at in self.path:
            node = _below(node, name, at)
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                names.append(node.name)
        place = ".".join(names) or "module"
        return f"{place}: {_short(node)} -> {_short(self.new)}"

    @property
    def text(self) -> str:
        """The module with the defect."""
        whole = copy.deepcopy(self.tree)
        node: ast.AST = whole
        for name, at in self.path[:-1]:
            node = _below(node, name, at)
        name, at = self.path[-1]
        if at is None:
            setattr(node, name, self.new)
        else:
            getattr(node, name)[at] = self.new
        return ast.unparse(ast.fix_missing_locations(whole))


def _below(node: ast.AST, name: str, at: int | None) -> ast.AST:
    value = getattr(node, name)
    return value if at is None else value[at]


def _short(node: ast.AST) -> str:
    shown = node.test if isinstance(node, ast.If | ast.While) else node
    return re.sub(r"\s+", " ", ast.unparse(shown))[:90]


def passes() -> list[Pass]:
    """All modules of passes; those of threads are one pass with one test file."""
    found = []
    for room in ROOMS:
        for source in sorted((ROOT / "vividc/ssa" / room).rglob("*.py")):
            place = source.relative_to(ROOT / "vividc/ssa").with_suffix("")
            if source.name != "__init__.py" and "def " in source.read_text():
                found.append(Pass(str(place), source, _tests_of(place)))
    return found


def _tests_of(place: Path) -> tuple[Path, ...]:
    """The test files of a module, by where it is in `ssa`; () if it has cases only."""
    stems = [place.parent if place.parent.name == "threads" else place]
    stems += map(Path, _BESIDE.get(str(place), ()))
    tests = (ROOT / "tests/ssa" / stem.parent / f"test_{stem.name}.py" for stem in stems)
    return tuple(test for test in tests if test.exists())


# Defects


def mutants(of: Pass) -> list[Mutant]:
    """Every defect of a pass, in the order of its text."""
    tree = ast.parse(of.source.read_text())
    return [
        Mutant(of, kind, tree, path, new)
        for path, node in _nodes(tree)
        for kind, change in _KINDS.items()
        for new in change(copy.deepcopy(node))
    ]


def _nodes(tree: ast.AST) -> Iterator[tuple[tuple[_Step, ...], ast.AST]]:
    """Nodes that may be changed, each with the way to it."""
    pending: list[tuple[tuple[_Step, ...], ast.AST]] = [((), tree)]
    while pending:
        path, node = pending.pop()
        yield path, node
        below: list[tuple[tuple[_Step, ...], ast.AST]] = []
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "slice", "targets"):
                continue
            items = enumerate(value) if isinstance(value, list) else [(None, value)]
            below += [((*path, (name, at)), n) for at, n in items if isinstance(n, ast.AST)]
        skipped = (ast.JoinedStr, ast.Import, ast.ImportFrom, ast.Raise, ast.Assert)
        pending += [] if isinstance(node, skipped) else reversed(below)


def _forgotten(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.Call) and _name(node) in _RECORDS:
        for at in range(len(node.keywords)):
            new = copy.deepcopy(node)
            del new.keywords[at]
            yield new
        if len(node.args) > 3:
            new = copy.deepcopy(node)
            new.args.pop()
            yield new


def _exchanged(node: ast.AST) -> Iterator[ast.AST]:
    is_pair = isinstance(node, ast.Tuple) and len(node.elts) == 2
    if is_pair and isinstance(node.ctx, ast.Load) and not _has_star(node):
        node.elts.reverse()
        yield node
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Sub):
        node.left, node.right = node.right, node.left
        yield node
    if isinstance(node, ast.IfExp):
        node.body, node.orelse = node.orelse, node.body
        yield node
    if isinstance(node, ast.Attribute) and node.attr in _SIDES:
        node.attr = _SIDES[node.attr]
        yield node


def _dropped(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.Tuple | ast.List | ast.Set) and _has_star(node):
        for at in range(len(node.elts)):
            new = copy.deepcopy(node)
            del new.elts[at]
            yield new
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
        yield from (node.left, node.right)
    if isinstance(node, ast.BoolOp):
        for at in range(len(node.values)):
            values = node.values[:at] + node.values[at + 1 :]
            yield values[0] if len(values) == 1 else ast.BoolOp(node.op, values)
    called = node.func if isinstance(node, ast.Call) else None
    if isinstance(called, ast.Attribute) and called.attr in _SETS:
        yield called.value


def _has_star(node: ast.Tuple | ast.List | ast.Set) -> bool:
    return any(isinstance(one, ast.Starred) for one in node.elts)


def _off_by_one(node: ast.AST) -> Iterator[ast.AST]:
    for place in _numbers(node):
        if isinstance(place, ast.Constant) and type(place.value) is int:
            place.value += 1
            yield copy.deepcopy(node)
            place.value -= 1
    if isinstance(node, ast.Call) and _name(node) in ("range", "Const") and node.args:
        node.args[-1] = ast.BinOp(node.args[-1], ast.Add(), ast.Constant(1))
        yield node
    for part in node.values if isinstance(node, ast.JoinedStr) else ():
        if isinstance(part, ast.Constant):
            for old, new in _BOUNDS:
                if re.search(rf" {old}", before := part.value):
                    part.value = before.replace(f" {old}", f" {new}", 1)
                    yield copy.deepcopy(node)
                    part.value = before


def _numbers(node: ast.AST) -> Sequence[ast.expr]:
    """Where a number may stand."""
    match node:
        case ast.BinOp(right=number) | ast.Assign(value=number):
            return [number]
        case ast.Compare(comparators=numbers) | ast.Dict(values=numbers):
            return numbers
    return []


def _name(call: ast.Call) -> str:
    return call.func.id if isinstance(call.func, ast.Name) else ""


def _negated(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.If | ast.While | ast.IfExp):
        node.test = ast.UnaryOp(ast.Not(), node.test)
        yield node
    if isinstance(node, ast.comprehension):
        for at in range(len(node.ifs)):
            new = copy.deepcopy(node)
            new.ifs[at] = ast.UnaryOp(ast.Not(), new.ifs[at])
            yield new
    if isinstance(node, ast.Compare) and type(node.ops[0]) in _ORDERS:
        node.ops[0] = _ORDERS[type(node.ops[0])]()
        yield node


_KINDS: dict[str, Callable[[ast.AST], Iterator[ast.AST]]] = {
    "forgotten": _forgotten,
    "exchanged": _exchanged,
    "dropped": _dropped,
    "off by one": _off_by_one,
    "negated": _negated,
}


def drawn(count: int, seed: int) -> list[Mutant]:
    """As many from each pass as from the others, of as many kinds as there are."""
    piles = [_pile(of, random.Random(f"{seed} {of.name}")) for of in passes()]
    found: list[Mutant] = []
    missing = count
    while missing:
        for pile in piles[: missing or None]:
            one = next(_up_to_real(pile, found), None)
            missing -= one is not None
    return found


def _pile(of: Pass, rng: random.Random) -> list[Mutant]:
    """Defects of a pass, shuffled, kinds in turns."""
    all_of = mutants(of)
    rng.shuffle(all_of)
    turns: Counter[str] = Counter()
    pile = []
    for at, mutant in enumerate(all_of):
        pile.append((turns[mutant.kind], at, mutant))
        turns[mutant.kind] += 1
    return [mutant for _, _, mutant in sorted(pile, key=lambda item: item[:2])]


def _up_to_real(pile: list[Mutant], found: list[Mutant]) -> Iterator[Mutant]:
    """Moves defects from the pile to the found ones, up to one that somebody could notice."""
    while pile:
        found.append(pile.pop(0))
        if not _is_equivalent(found[-1]):
            yield found[-1]


def _is_equivalent(mutant: Mutant) -> bool:
    return (mutant.of.name, mutant.change) in EQUIVALENT


# Running


class _Planted(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Loads one module with its defect."""

    def __init__(self, name: str, mutant: Mutant) -> None:
        self.name, self.mutant = name, mutant

    def find_spec(
        self, name: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        if name != self.name:
            return None
        origin = str(self.mutant.of.source)
        return importlib.machinery.ModuleSpec(name, self, origin=origin)

    def exec_module(self, module: ModuleType) -> None:
        exec(compile(self.mutant.text, str(self.mutant.of.source), "exec"), module.__dict__)


def notices(mutant: Mutant, tests: Sequence[str], limit_s: int) -> bool:
    """Whether a test fails, or does not end, with the defect planted."""
    sys.stdout.flush()
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s))
        os._exit(_run(mutant, tests))
    end = time.monotonic() + _PATIENCE * limit_s
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status) not in (0, 5)
        time.sleep(0.05)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return True


def _run(mutant: Mutant, tests: Sequence[str]) -> int:
    name = f"{vividc.__name__}.ssa." + mutant.of.name.replace("/", ".")
    _forget(name)
    sys.meta_path.insert(0, _Planted(name, mutant))
    quiet = ("-x", "-q", "-m", "not slow", "-p", "no:cacheprovider", "--no-header")
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
        try:  # the package first, in the order in which its users load it
            importlib.import_module(vividc.__name__)
        except Exception:  # whatever it is, the defect is noticed
            return 1
        return int(pytest.main([*quiet, *tests]))


def _forget(name: str) -> None:
    """Let the module and all that imports it, tests too, be imported anew."""
    loaded = [m for m in sys.modules if m.split(".")[0] in ("vividc", "tests")]
    imports = {m: _imported(sys.modules[m]) for m in loaded}
    gone, before = {name}, 0
    while len(gone) > before:
        before = len(gone)
        gone |= {m for m, read in imports.items() if read & gone}
    for one in gone & set(loaded):
        module = sys.modules.pop(one)
        parent, _, last = one.rpartition(".")
        if getattr(sys.modules.get(parent), last, None) is module:
            delattr(sys.modules[parent], last)


_READ: dict[str, set[str]] = {}


def _imported(module: ModuleType) -> set[str]:
    """Names of the modules that a module's text imports."""
    file = getattr(module, "__file__", None) or ""
    if not file.startswith(str(ROOT)) or not file.endswith(".py"):
        return set()
    if file not in _READ:
        found = set()
        for node in ast.walk(ast.parse(Path(file).read_text())):
            if isinstance(node, ast.ImportFrom) and node.module:
                found |= {node.module, *(f"{node.module}.{one.name}" for one in node.names)}
            elif isinstance(node, ast.Import):
                found |= {one.name for one in node.names}
        _READ[file] = found
    return _READ[file]


def judged(mutant: Mutant, *, quick: bool) -> str:
    """Who notices a defect: its own file, others, or nobody; "equivalent" if nobody can."""
    if _is_equivalent(mutant):
        return "equivalent"
    own, verdict = mutant.of.own, "nobody"
    quickest = mutant.of.quickest
    wider = () if quick else (own, OTHERS) if quickest != own else (OTHERS,)
    whose_tests = [("own", quickest), *(("own" if t is own else "others", t) for t in wider)]
    for whose, tests in whose_tests:
        if notices(mutant, tests, OTHERS_S if whose == "others" else OWN_S):
            verdict = whose
            break
    print(f"{verdict}: {mutant.of.name}: {mutant.kind}: {mutant.change}", flush=True)
    return verdict


def table(rows: dict[str, dict[str, int]]) -> str:
    """The table of the README, a row a pass and one of sums."""
    columns = ("planted", "own", "others", "nobody", "equivalent")
    head = "| pass | planted | its own file | others | nobody | equivalent, drawn anew |"
    lines = [head, "|---" + "|---:" * len(columns) + "|"]
    for name, row in rows.items():
        lines.append(f"| `{name}` | " + " | ".join(str(row.get(c, 0)) for c in columns) + " |")
    sums = [str(sum(row.get(c, 0) for row in rows.values())) for c in columns]
    lines.append("| all | " + " | ".join(sums) + " |")
    return "\n".join(lines)


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants")
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", default="", help="passes whose names hold this")
    parser.add_argument("--jobs", type=int, default=2, help="defects tried at a time")
    parser.add_argument("--quick", action="store_true", help="only the cases of own files")
    options = parser.parse_args()
    os.chdir(ROOT)
    rows: dict[str, dict[str, int]] = {}
    chosen = [m for m in drawn(options.count, options.seed) if options.only in m.of.name]
    judge = partial(judged, quick=options.quick)
    for module in list(sys.modules.values()):  # once, before the processes are split off
        _imported(module)
    with ThreadPoolExecutor(options.jobs) as pool:
        verdicts = list(pool.map(judge, chosen))
    for mutant, verdict in zip(chosen, verdicts, strict=True):
        row = rows.setdefault(mutant.of.name, {})
        if verdict == "equivalent":
            row[verdict] = row.get(verdict, 0) + 1
            continue
        row["planted"] = row.get("planted", 0) + 1
        row[verdict] = row.get(verdict, 0) + 1
    made = table(rows)
    print(made)
    if not options.only and not options.quick and options.seed == SEED:
        text = README.read_text()
        begin, end = "<!-- mutants -->\n", "<!-- end -->"
        head, _, rest = text.partition(begin)
        README.write_text(f"{head}{begin}{made}\n{end}{rest.partition(end)[2]}")


if __name__ == "__main__":
    main()

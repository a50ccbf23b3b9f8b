"""One node: where and when it can begin, and which place is best: compiled functions."""

from __future__ import annotations

from typing import Final, NamedTuple

from vividc.mapper.engines.greedy.board import CHANGES, FULL, NONE, Board, back_to, put
from vividc.mapper.engines.greedy.compiled import inlined
from vividc.mapper.engines.greedy.search import LINK_COST, Search, hops_from, route, word_of
from vividc.mapper.engines.greedy.task import CONTROL, LIVE_OUT, MEMORY, Task
from vividc.mapper.engines.greedy.words import Ways, park, settle
from vividc.mapper.resources.arrays import Ints
from vividc.mapper.resources.distances import FAR

PATIENCE: Final = 8
"""Cycles by which a node may be late on one PE before the others are asked again."""


class Rules(NamedTuple):
    """How a pass decides: see `Policy`. `parked`: words, above which readers go first; `lowest`: by
    node, how high it lies, negated.
    """

    parked: float
    deep: int
    affinity: int
    constants: int
    spared: int
    apart: int
    lowest: Ints


class Options(NamedTuple):
    """Of the node that is placed: `pending`, its edges in the order in which they are routed. By
    PE: `earliest`, the first cycle in which what comes before lets it begin; `extra`, what a place
    costs beside routes; and where `open`, what is to be tried next there: a `score`, `cost` and
    `time` as in `Option`, those that it has at least.
    """

    pending: Ints
    earliest: Ints
    extra: Ints
    open: Ints
    score: Ints
    cost: Ints
    time: Ints


class Pass(NamedTuple):
    """All that a pass works on. `horizon[0]`: cycles of the region so far; `tried[0]`: placements
    that were tried.
    """

    task: Task
    rules: Rules
    board: Board
    search: Search
    ways: Ways
    options: Options
    horizon: Ints
    tried: Ints


class Option(NamedTuple):
    """A place, the better the less: the cycles that the region would have with it, and what else it
    costs.
    """

    score: float
    cost: int
    time: int
    pe: int


@inlined
def place(job: Pass, node: int) -> bool:
    """Try places in the order of the best they could give; stop when no other can be better. The
    best one is taken; False if there is none.
    """
    board, options = job.board, job.options
    board.counts[CHANGES] = 0
    _list_options(job, node)
    last_chance = job.horizon[0] + 2 * job.task.grid.diameter + 2 * PATIENCE
    best, is_there = Option(0.0, 0, 0, NONE), False
    while not board.counts[FULL]:
        option = _least(options)
        pe = option.pe
        if pe == NONE:
            break
        if best.pe != NONE and (option.score > best.score or _is_behind(option, best)):
            break
        back_to(board, 0)
        options.open[pe], is_there = 0, False
        tried = _tried(job, node, option)
        if tried.pe == NONE:
            if option.time < max(last_chance, options.earliest[pe] + PATIENCE):
                options.open[pe] = 1
                options.score[pe] += 1
                options.time[pe] += 1
        elif best.pe == NONE or _is_less(tried, best):
            best, is_there = tried, True
    if not is_there and not board.counts[FULL]:
        back_to(board, 0)
        if best.pe != NONE:
            _take(job, node, best.pe, best.time)
    return best.pe != NONE


@inlined
def _is_less(one: Option, other: Option) -> bool:
    """Whether it is better, with the earlier cycle and then the lower PE among equal ones."""
    if one.score != other.score:
        return one.score < other.score
    if one.cost != other.cost:
        return one.cost < other.cost
    return one.time < other.time if one.time != other.time else one.pe < other.pe


@inlined
def _is_behind(option: Option, best: Option) -> bool:
    """Whether neither it nor any that comes after it can be better. (One that waits for a bank has
    a greater score than it had before: with others that fail now and come later it is compared.)
    """
    return option.score + 1 > best.score and _is_less(best, option)


@inlined
def _least(options: Options) -> Option:
    """The best of those that are open; without a PE if there is none."""
    best = Option(0.0, 0, 0, NONE)
    for pe in range(len(options.open)):
        if options.open[pe]:
            option = Option(options.score[pe], options.cost[pe], options.time[pe], pe)
            if best.pe == NONE or _is_less(option, best):
                best = option
    return best


@inlined
def _tried(job: Pass, node: int, option: Option) -> Option:
    """What becomes of a place that may work, which is taken then; if it does not, without a PE, and
    what was changed for it is still to be taken back.
    """
    pe, time = option.pe, option.time
    if not _is_free(job.task, job.board, node, pe, time):
        return Option(0.0, 0, 0, NONE)
    late = job.rules.apart * meeting(job.task, job.board, node, time)
    cost = _take(job, node, pe, time)
    if cost == NONE:
        return Option(0.0, 0, 0, NONE)
    return Option(option.score + late, job.options.extra[pe] + cost, time, pe)


@inlined
def meeting(task: Task, board: Board, node: int, time: int) -> float:
    """Cycles that an access is expected to wait for the others of its cycle so far, at most one."""
    row, total = task.nodes.access[node], 0.0
    if row == NONE:
        return total
    other = board.cells[board.begin.latest + time]
    while other != NONE:
        if other != node:
            total += task.meets[row, task.nodes.access[other]]
        other = board.cells[board.begin.earlier + other]
    return min(1.0, total)


# --- what a place would give ---


@inlined
def _list_options(job: Pass, node: int) -> None:
    """What is to be tried first on each PE."""
    task, board, options = job.task, job.board, job.options
    nodes = task.nodes
    for pe in range(task.grid.pes):
        options.open[pe], options.extra[pe] = 0, 0
    list_earliest(task, board, options, node)
    _add_affinity(job, node)
    for at in range(nodes.pe_begin[node], nodes.pe_begin[node + 1]):
        pe = nodes.pe_items[at]
        if options.earliest[pe] >= FAR or not has_room(task, board, node, pe):
            continue
        new = _new_entries(task, board, node, pe)
        left = task.grid.room[pe] - board.cells[board.begin.stored + pe] - new
        crowding = new * max(job.rules.spared - left, 0) if job.rules.spared else 0
        options.open[pe] = 1
        options.time[pe] = options.earliest[pe]
        options.score[pe] = options.earliest[pe] + nodes.after[node, pe] + crowding
        options.extra[pe] += job.rules.constants * new
        options.cost[pe] = options.extra[pe] + LINK_COST * _hops(task, board, node, pe)


@inlined
def list_earliest(task: Task, board: Board, options: Options, node: int) -> None:
    """By PE, the first cycle in which what comes before `node` lets it begin."""
    grid, begin, edges = task.grid, board.begin, task.edges
    earliest = options.earliest
    for pe in range(grid.pes):
        earliest[pe] = task.nodes.release[node, pe]
    for at in range(edges.before_begin[node], edges.before_begin[node + 1]):
        before, brings = edges.before[at, 0], edges.before[at, 2]
        if board.cells[begin.pe + before] == NONE:
            continue
        ready = board.cells[begin.start + before] + edges.before[at, 1]
        for pe in range(grid.pes):
            hops = grid.distance[board.cells[begin.pe + before], pe] if brings else 0
            earliest[pe] = max(earliest[pe], ready + hops - (0 < hops < FAR))
    for at in range(task.nodes.reader_begin[node], task.nodes.reader_begin[node + 1]):
        reader = task.nodes.reader_items[at]
        pe = board.cells[begin.pe + reader]
        if pe != NONE:
            earliest[pe] = max(earliest[pe], board.cells[begin.start + reader])


@inlined
def _add_affinity(job: Pass, node: int) -> None:
    """By PE, hops to the words that the readers of `node` will need as well."""
    task, board = job.task, job.board
    nodes, edges = task.nodes, task.edges
    if job.rules.affinity == 0:
        return
    for fed in range(nodes.fed_begin[node], nodes.fed_begin[node + 1]):
        reader = edges.dst[nodes.fed_items[fed]]
        for at in range(nodes.read_begin[reader], nodes.read_begin[reader + 1]):
            there = board.cells[board.begin.pe + edges.src[nodes.read_items[at]]]
            if there != NONE:
                for pe in range(task.grid.pes):
                    away = task.grid.distance[there, pe]
                    job.options.extra[pe] += job.rules.affinity * away


@inlined
def _hops(task: Task, board: Board, node: int, pe: int) -> int:
    """Links at least that words take which `node` reads there."""
    hops = 0
    for at in range(task.nodes.source_begin[node], task.nodes.source_begin[node + 1]):
        word = word_of(task, board, task.nodes.source_items[at])
        hops += hops_from(task.grid, board, word, pe)
    return hops


@inlined
def has_room(task: Task, board: Board, node: int, pe: int) -> bool:
    """Whether the PE's constant store has room for the node's entries."""
    new = _new_entries(task, board, node, pe)
    return new == 0 or board.cells[board.begin.stored + pe] + new <= task.grid.room[pe]


@inlined
def _new_entries(task: Task, board: Board, node: int, pe: int) -> int:
    """Entries of the node that the PE's constant store does not hold."""
    new, held = 0, board.begin.held + pe * board.keys
    for at in range(task.nodes.key_begin[node], task.nodes.key_begin[node + 1]):
        new += 1 - board.cells[held + task.nodes.key_items[at]]
    return int(new)


# --- taking a place ---


@inlined
def _is_free(task: Task, board: Board, node: int, pe: int, time: int) -> bool:
    """Whether nothing that the node claims is claimed, nor the variable that it reads written."""
    nodes, begin, cells = task.nodes, board.begin, board.cells
    for at in range(nodes.writer_begin[node], nodes.writer_begin[node + 1]):
        writer = nodes.writer_items[at]
        if cells[begin.pe + writer] == pe and cells[begin.start + writer] < time:
            return False
    row, kind = time * board.pes + pe, nodes.kind[node]
    if kind & LIVE_OUT:
        return not cells[begin.shown + row]
    for cycle in range(nodes.busy[node]):
        if cells[begin.issued + row + cycle * board.pes]:
            return False
    done = time + nodes.latency[node]
    if cells[begin.completed + done * board.pes + pe]:
        return False
    if kind & CONTROL and cells[begin.control + done]:
        return False
    return not (kind & MEMORY and cells[begin.accesses + time] >= task.grid.banks)


@inlined
def _claim(task: Task, board: Board, node: int, pe: int, time: int) -> None:
    nodes, begin = task.nodes, board.begin
    row, kind = time * board.pes + pe, nodes.kind[node]
    if kind & LIVE_OUT:
        put(board, begin.shown + row, 1)
        return
    for cycle in range(nodes.busy[node]):
        put(board, begin.issued + row + cycle * board.pes, 1)
    done = time + nodes.latency[node]
    put(board, begin.completed + done * board.pes + pe, 1)
    if kind & CONTROL:
        put(board, begin.control + done, 1)
    if kind & MEMORY:
        put(board, begin.accesses + time, board.cells[begin.accesses + time] + 1)
    if nodes.access[node] != NONE:
        put(board, begin.earlier + node, board.cells[begin.latest + time])
        put(board, begin.latest + time, node)


@inlined
def _take(job: Pass, node: int, pe: int, time: int) -> int:
    """Place `node`, route its operands, park its result; the routes' cost, or `NONE`."""
    task, board, nodes = job.task, job.board, job.task.nodes
    begin = board.begin
    job.tried[0] += 1
    cost = _route_operands(job, node, pe, time)
    if cost == NONE:
        return NONE
    put(board, begin.pe + node, pe)
    put(board, begin.start + node, time)
    _claim(task, board, node, pe, time)
    _store(task, board, node, pe)
    for at in range(nodes.source_begin[node], nodes.source_begin[node + 1]):
        source = nodes.source_items[at]
        if board.cells[begin.unread + source] == 0:
            settle(task, board, source)
    if board.cells[begin.unread + node] > 0:
        ready = time + nodes.latency[node]
        if not park(task.grid, board, job.ways, node, ready):
            return NONE
    return cost


@inlined
def _store(task: Task, board: Board, node: int, pe: int) -> None:
    """Give the node's entries room in the PE's constant store."""
    held, stored = board.begin.held + pe * board.keys, board.begin.stored + pe
    for at in range(task.nodes.key_begin[node], task.nodes.key_begin[node + 1]):
        key = held + task.nodes.key_items[at]
        if not board.cells[key]:
            put(board, key, 1)
            put(board, stored, board.cells[stored] + 1)


@inlined
def _route_operands(job: Pass, node: int, pe: int, time: int) -> int:
    """Route in turn; when one fails, again with it first: order decides ports and links."""
    nodes, board, pending = job.task.nodes, job.board, job.options.pending
    first, count = nodes.read_begin[node], nodes.read_begin[node + 1] - nodes.read_begin[node]
    for at in range(count):
        pending[at] = nodes.read_items[first + at]
    for _ in range(count + 1):
        mark = board.counts[CHANGES]
        failed, cost = _route_in_order(job, count, pe, time)
        if failed == NONE:
            return cost
        if failed == 0 or board.counts[FULL]:
            return NONE
        back_to(board, mark)
        edge = pending[failed]
        for at in range(failed, 0, -1):
            pending[at] = pending[at - 1]
        pending[0] = edge
    return NONE


@inlined
def _route_in_order(job: Pass, count: int, pe: int, time: int) -> tuple[int, int]:
    """The first of the edges that failed, or `NONE`, and what the routes cost."""
    board, total = job.board, 0
    for at in range(count):
        edge = job.options.pending[at]
        cost = route(job.task, board, job.search, edge, pe, time)
        if cost == NONE or board.counts[FULL]:
            return at, total
        total += cost
        unread = board.begin.unread + job.task.edges.src[edge]
        put(board, unread, board.cells[unread] - 1)
    return NONE, total

"""Random loop nests: each loop has at most one loop in its body, with code on both sides of it."""

from __future__ import annotations

from hypothesis import strategies as st

from tests.dfg.programs import VARIABLES, Assign, For, If, Jump, Load, Store, While


def nests(depth: int = 3) -> st.SearchStrategy[tuple[object, ...]]:
    """A program of some statements, one nest up to `depth` deep, and more statements."""
    return st.tuples(_simple(in_loop=False), _loop(depth), _simple(in_loop=False)).map(
        lambda parts: (*parts[0], parts[1], *parts[2])
    )


def _simple(*, in_loop: bool, depth: int = 1) -> st.SearchStrategy[tuple[object, ...]]:
    """Up to two statements without a loop."""
    variable = st.integers(0, VARIABLES - 1)
    constant = st.none() | st.integers(-4, 9)
    choices: list[st.SearchStrategy[object]] = [
        st.builds(
            Assign, variable, st.sampled_from(["add", "sub", "xor"]), variable, variable, constant
        ),
        st.builds(Load, variable, variable),
        st.builds(Store, variable, variable),
    ]
    if in_loop:
        choices.append(st.builds(Jump, st.sampled_from(["break", "continue"]), variable, variable))
    if depth:
        inner = _simple(in_loop=in_loop, depth=depth - 1)
        choices.append(st.builds(If, variable, variable, inner, inner))
    return st.lists(st.one_of(choices), max_size=2).map(tuple)


def _loop(depth: int) -> st.SearchStrategy[object]:
    variable = st.integers(0, VARIABLES - 1)
    body = _body(depth)
    counted = st.builds(For, variable, st.integers(0, 2), st.integers(-1, 5), body)
    return st.one_of(
        counted, counted, st.builds(While, variable, variable, st.integers(1, 5), body)
    )


def _body(depth: int) -> st.SearchStrategy[tuple[object, ...]]:
    if depth <= 1:
        return _simple(in_loop=True)
    variable = st.integers(0, VARIABLES - 1)
    inner = _loop(depth - 1)
    skipped = st.builds(If, variable, variable, st.tuples(inner), _simple(in_loop=True))
    return st.tuples(
        _simple(in_loop=True), st.one_of(inner, inner, skipped), _simple(in_loop=True)
    ).map(lambda parts: (*parts[0], parts[1], *parts[2]))

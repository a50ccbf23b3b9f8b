"""Options of loop transformations, which become one `vividc.LoopOptions`."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from typing import Any, Final

import click

from vividc import LoopOptions

_FACTOR: Final = re.compile(r"(?P<line>\d{1,9})=(?P<factor>\d{1,9})")


def _factors(
    _ctx: click.Context, _param: click.Parameter, value: tuple[str, ...]
) -> dict[int, int]:
    """Factors by source line, from options of the form LINE=N."""
    factors: dict[int, int] = {}
    for text in value:
        match = _FACTOR.fullmatch(text)
        if match is None:
            raise click.BadParameter(f"{text!r} is not of the form LINE=N, as in 12=4.")
        factors[int(match["line"])] = int(match["factor"])
    return factors


_OPTIONS: Final = (
    click.option(
        "--transform/--no-transform",
        "auto",
        default=True,
        help="Unroll, jam and flatten loops where an estimate says that it pays.",
    ),
    click.option(
        "--unroll",
        multiple=True,
        metavar="LINE=N",
        callback=_factors,
        help="Unroll the loop on this line by N; 1 leaves it as it is.",
    ),
    click.option(
        "--jam",
        multiple=True,
        metavar="LINE=N",
        callback=_factors,
        help="Run N iterations of the loop on this line together in the loop inside it.",
    ),
    click.option(
        "--flatten",
        multiple=True,
        type=int,
        metavar="LINE",
        help="Make one loop of the loop on this line and the loop inside it.",
    ),
    click.option(
        "--no-flatten",
        multiple=True,
        type=int,
        metavar="LINE",
        help="Do not flatten the loop on this line.",
    ),
    click.option(
        "--threads",
        type=int,
        metavar="N",
        help="Run N iterations of the loop over prange side by side, 1 to 8.  [default: what pays]",
    ),
    click.option(
        "--restructure/--no-restructure",
        "restructure",
        default=True,
        help="Give nests of affine loops another order and tiles for registers, where it pays.  "
        "[default: --restructure]",
    ),
)


def loop_options(command: Callable[..., None]) -> Callable[..., None]:
    """Adds the options; the command gets one `loops`."""

    @wraps(command)
    def with_loops(
        *,
        auto: bool,
        unroll: dict[int, int],
        jam: dict[int, int],
        flatten: tuple[int, ...],
        no_flatten: tuple[int, ...],
        threads: int | None,
        restructure: bool,
        **rest: Any,
    ) -> None:
        both = sorted({*flatten} & {*no_flatten})
        if both:
            raise click.UsageError(f"--flatten {both[0]} and --no-flatten {both[0]}: choose one")
        choices = dict.fromkeys(flatten, True) | dict.fromkeys(no_flatten, False)
        command(loops=LoopOptions(auto, unroll, jam, choices, threads, restructure), **rest)

    for option in reversed(_OPTIONS):
        option(with_loops)
    return with_loops

"""`python -m tests.fuzz`: random kernels through all witnesses; exit code 1 on a find."""

from __future__ import annotations

import gc
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from random import Random
from time import monotonic

import click
import numba
from numba.core.errors import NumbaError
from rich.console import Console
from rich.progress import Progress

from tests.fuzz.features import features
from tests.fuzz.generator import random_source
from tests.fuzz.nests import random_nest_source
from tests.fuzz.shrink import shrink
from tests.fuzz.spreads import judge_spread, random_spread_source
from tests.fuzz.tally import Tally
from tests.fuzz.witnesses import Simulated, Verdict, judge, stays_inside

console = Console()

_NESTS = 0.2
"""Share of affine nests among the programs for one tile."""
_COLLECT = 100
"""Programs from one collection and one count to the next."""


def _small(source: str, seed: int, verdict: Verdict, folder: Path, simulate: Simulated) -> str:
    """The source shrunk; a smaller kernel must fail in the same way. Those for all tiles are short,
    and are shown as they are.
    """
    if simulate == "tiles":
        return source
    if verdict.text.startswith("interpreter"):
        simulate = ""

    def key(found: Verdict) -> tuple[str, str]:
        return found.kind, found.text.split(":")[0].split(",")[0]

    def fails(candidate: str) -> bool:
        try:
            found = judge(candidate, seed, folder, simulate=simulate)
            return key(found) == key(verdict) and stays_inside(candidate, seed, folder)
        except (NameError, TypeError, SyntaxError, NumbaError):
            return False

    return shrink(source, fails, budget_s=45.0)


def _report(seed: int, verdict: Verdict, source: str, simulate: Simulated) -> None:
    console.rule(f"seed {seed} {verdict.kind} {simulate}")
    console.print(verdict.text, markup=False)
    body = source.replace('"""', "'''")
    console.print(f"def test_fuzz_seed_{seed}(tmp_path: Path) -> None:", markup=False)
    console.print(f'    source = """{body}"""', markup=False, highlight=False, soft_wrap=True)
    console.print(f"    assert not judge(source, {seed}, tmp_path).is_find", markup=False)


@dataclass(frozen=True)
class _Search:
    """Which seeds are run how long, which shares are simulated, and where the counts are kept."""

    seeds: range
    shares: tuple[float, float, float]
    seconds: float
    state: Path | None


def _run_one(seed: int, shares: tuple[float, float, float], folder: Path, tally: Tally) -> None:
    simulate = _simulated(seed, shares)
    if simulate == "tiles":
        source = random_spread_source(seed)
        verdict = judge_spread(source, seed, folder)
    else:
        is_nest = Random(-seed - 1).random() < _NESTS
        source = random_nest_source(seed) if is_nest else random_source(seed)
        verdict = judge(source, seed, folder, simulate=simulate)
    how = verdict.text if simulate == "tiles" and verdict.kind == "agrees" else simulate
    found = features(source) | set(verdict.tried)
    tally.add(seed, verdict.kind, verdict.text, how, found)
    if verdict.is_find:
        _report(seed, verdict, _small(source, seed, verdict, folder, simulate), simulate)


def _show(tally: Tally) -> None:
    console.print(tally.summary(), markup=False, highlight=False, soft_wrap=True)
    for reason, number in tally.reasons.most_common():
        text = f"{number:5} refused, first by seed {tally.examples[reason]}: {reason}"
        console.print(text, markup=False, soft_wrap=True)


def _fuzz(search: _Search, folder: Path) -> Tally:
    tally = Tally.kept_in(search.state)
    first = search.seeds.start if tally.next_seed is None else tally.next_seed
    seeds = range(max(search.seeds.start, first), search.seeds.stop)
    spent, started = tally.seconds, monotonic()
    gc.disable()  # numba's garbage is collected faster in bulk
    try:
        with Progress(console=console) as progress:
            task = progress.add_task("fuzzing", total=len(seeds))
            for number, seed in enumerate(seeds):
                if monotonic() > started + search.seconds:
                    break
                _run_one(seed, search.shares, folder, tally)
                tally.seconds = spent + monotonic() - started
                tally.keep_in(search.state)
                if number % _COLLECT == _COLLECT - 1:
                    gc.collect()
                    _show(tally)
                shown = ", ".join(f"{n} {kind}" for kind, n in sorted(tally.counts.items()))
                progress.update(task, advance=1, description=f"seed {seed}: {shown}")
    except KeyboardInterrupt:
        console.print("interrupted")
    return tally


def _simulated(seed: int, shares: tuple[float, float, float]) -> Simulated:
    """`shares`: mapped, in blocks, and with a loop over `prange` on all tiles."""
    drawn = Random(seed).random()
    if drawn < shares[0]:
        return "mapped"
    if drawn < sum(shares[:2]):
        return "blocks"
    return "tiles" if drawn < sum(shares) else ""


@click.command()
@click.option("--count", default=1000, show_default=True, help="Programs to run.")
@click.option("--seed", default=1, show_default=True, help="Seed of the first program.")
@click.option("--mapped", default=0.03, show_default=True, help="Share mapped and simulated.")
@click.option("--blocks", default=0.1, show_default=True, help="Share simulated without schedules.")
@click.option("--tiles", default=0.0, show_default=True, help="Share of loops over prange.")
@click.option("--minutes", default=1e6, help="Stop after so many minutes.")
@click.option(
    "--state",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Counts of a search that goes on where it stopped.",
)
@click.option("--json", "as_json", is_flag=True, help="The last line is the counts as JSON.")
def main(
    count: int,
    seed: int,
    mapped: float,
    blocks: float,
    tiles: float,
    minutes: float,
    state: Path | None,
    as_json: bool,
) -> None:
    """Run random kernels through numba, interpreter and simulator; exit code 1 on a find."""
    # The witness is numba, not LLVM's optimisation of what it writes: a fifth of the time is saved.
    numba.config.OPT = type(numba.config.OPT)(0)
    search = _Search(range(seed, seed + count), (mapped, blocks, tiles), 60 * minutes, state)
    with tempfile.TemporaryDirectory() as folder:
        tally = _fuzz(search, Path(folder))
    _show(tally)
    if as_json:
        click.echo(tally.to_json())
    sys.exit(1 if tally.finds else 0)


if __name__ == "__main__":
    main()

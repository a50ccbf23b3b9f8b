"""`python -m tests.fuzz`: random kernels through all witnesses; exit code 1 on a find."""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from pathlib import Path
from random import Random
from time import monotonic

import click
from rich.console import Console
from rich.progress import Progress

from tests.fuzz.generator import random_source
from tests.fuzz.shrink import shrink
from tests.fuzz.witnesses import Verdict, judge

console = Console()


def _small(source: str, seed: int, verdict: Verdict, folder: Path, simulate: bool) -> str:
    """The source shrunk; a smaller kernel must fail in the same way."""
    simulate = simulate and not verdict.text.startswith("interpreter")

    def key(found: Verdict) -> tuple[str, str]:
        return found.kind, found.text.split(":")[0].split(",")[0]

    def fails(candidate: str) -> bool:
        try:
            return key(judge(candidate, seed, folder, simulate=simulate)) == key(verdict)
        except (NameError, TypeError, SyntaxError):
            return False

    return shrink(source, fails)


def _report(seed: int, verdict: Verdict, source: str) -> None:
    console.rule(f"seed {seed} {verdict.kind}")
    console.print(verdict.text, markup=False)
    body = source.replace('"""', "'''")
    console.print(f"def test_fuzz_seed_{seed}(tmp_path: Path) -> None:", markup=False)
    console.print(f'    source = """{body}"""', markup=False, highlight=False)
    console.print(f"    assert not judge(source, {seed}, tmp_path).is_find", markup=False)


def _fuzz(seeds: range, simulate: float, seconds: float, folder: Path) -> Counter[str]:
    counts: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    deadline, since = monotonic() + seconds, 0
    try:
        with Progress(console=console) as progress:
            task = progress.add_task("fuzzing", total=len(seeds))
            for seed in seeds:
                if monotonic() > deadline:
                    break
                source = random_source(seed)
                chosen = Random(seed).random() < simulate
                verdict = judge(source, seed, folder, simulate=chosen)
                counts.update([verdict.kind, *["simulated"] * chosen])
                since = 0 if verdict.is_find else since + 1
                if verdict.kind == "refused":
                    reasons.update([verdict.text])
                if verdict.is_find:
                    _report(seed, verdict, _small(source, seed, verdict, folder, chosen))
                shown = ", ".join(f"{n} {kind}" for kind, n in sorted(counts.items()))
                progress.update(task, advance=1, description=f"seed {seed}: {shown}")
    except KeyboardInterrupt:
        console.print("interrupted")
    console.print(f"{dict(counts)}; the last {since} without a find")
    for reason, number in reasons.most_common():
        console.print(f"{number:5} refused: {reason}", markup=False)
    return counts


@click.command()
@click.option("--count", default=1000, show_default=True, help="Programs to run.")
@click.option("--seed", default=1, show_default=True, help="Seed of the first program.")
@click.option("--simulate", default=0.0, show_default=True, help="Share that is also simulated.")
@click.option("--minutes", default=1e6, help="Stop after so many minutes.")
def main(count: int, seed: int, simulate: float, minutes: float) -> None:
    """Run random kernels through numba, interpreter and simulator; exit code 1 on a find."""
    with tempfile.TemporaryDirectory() as folder:
        seeds = range(seed, seed + count)
        counts = _fuzz(seeds, simulate, 60 * minutes, Path(folder))
    sys.exit(1 if counts["differs"] or counts["crashes"] else 0)


if __name__ == "__main__":
    main()

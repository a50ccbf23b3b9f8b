"""`python -m tests.fuzz --count 2000 --seed 1 [--simulate 0.05] [--minutes M]`."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random

from numba.core.errors import NumbaError
from rich.console import Console

from tests.fuzz.generate import random_source
from tests.fuzz.shrink import shrink
from tests.fuzz.witness import Verdict, judge


def main() -> int:
    """Returns 1 if a program differs or crashes."""
    parser = argparse.ArgumentParser(prog="tests.fuzz")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--simulate", type=float, default=0.05, help="share of programs")
    parser.add_argument("--minutes", type=float, default=1e9)
    asked = parser.parse_args()
    console = Console()
    kinds: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    deadline = time.monotonic() + 60 * asked.minutes
    with tempfile.TemporaryDirectory() as name, console.status("") as status:
        try:
            for seed in range(asked.seed, asked.seed + asked.count):
                if time.monotonic() > deadline:
                    break
                verdict = judged(seed, Path(name), Random(seed).random() < asked.simulate)
                kinds[verdict.kind] += 1
                status.update(f"seed {seed}: {dict(kinds)}")
                if verdict.kind in ("refused", "timeout"):
                    reasons[verdict.detail.split("\n")[0].split(": ", 1)[-1]] += 1
                if verdict.find:
                    report(console, seed, verdict, Path(name))
        except KeyboardInterrupt:
            console.print("interrupted")
    console.print(f"{sum(kinds.values())} programs: {dict(kinds)}", highlight=False)
    for reason, times in reasons.most_common():
        console.print(f"{times} x {reason}", highlight=False, markup=False)
    return int(bool(kinds["differs"] or kinds["crashed"]))


def judged(seed: int, folder: Path, simulate: bool) -> Verdict:
    """The verdict on one seed; "numba" if numba itself does not take the program."""
    try:
        return judge(random_source(seed), seed, folder, f"fuzz{seed}", simulate)
    except NumbaError as error:
        return Verdict("numba", "numba", str(error))


def report(console: Console, seed: int, verdict: Verdict, folder: Path) -> None:
    """Prints the find and its smallest kernel."""
    console.print(f"seed {seed} {verdict.kind}, {verdict.witness}: {verdict.detail}", markup=False)
    tries = 0

    def fails(source: str) -> bool:
        nonlocal tries
        tries += 1
        try:
            found = judge(
                source, seed, folder, f"small{seed}_{tries}", verdict.witness == "simulator"
            )
        except (NumbaError, SyntaxError):
            return False
        return found.kind == verdict.kind

    console.print(shrink(random_source(seed), fails), markup=False, highlight=False)


if __name__ == "__main__":
    sys.exit(main())

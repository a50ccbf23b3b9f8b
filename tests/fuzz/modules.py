"""`python -m tests.fuzz.modules`: random `.ll` modules; exit code 1 on a find.

A find is an exception that is no message, a file that foreign code made, or a kernel that is
defined in C and gives something else on the array than on the host.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections import Counter
from pathlib import Path
from random import Random
from time import monotonic

import click
import numpy as np

import vividc
from tests.fuzz.module_text import WORDS, random_module
from tests.fuzz.witnesses import Verdict, words_in_blocks
from vividc.errors import VividcError, VividcWarning
from vividc.frontend import LLKernel
from vividc.frontend.c import host as ll_host

_CYCLES = 200_000
_LIMIT_S = 30.0


def judge(seed: int, folder: Path) -> Verdict:
    """What becomes of a module: it is read, lowered, and run by the simulator and the host."""
    marker = folder / "executed"
    text, name, defined = random_module(seed, f"touch {marker}")
    path = folder / "module.ll"
    path.write_bytes(text.encode())
    try:
        verdict = _judged(path, name, seed, defined=defined)
    except VividcError as error:
        verdict = Verdict("refused", error.reason[:160])
    except Exception as error:
        verdict = Verdict("crashes", f"{type(error).__name__}: {str(error)[:300]}")
    if marker.exists():
        marker.unlink()
        return Verdict("crashes", "foreign code ran")
    return verdict


def _judged(path: Path, name: str, seed: int, *, defined: bool) -> Verdict:
    kernel = vividc.load_ll(path, name)
    program = words_in_blocks(kernel.lower())
    by_array, by_host = (_arguments(kernel, seed) for _ in range(2))
    ran: dict[str, object] = {}
    for who, arguments in (("array", by_array), ("host", by_host)):
        try:
            if who == "array":
                done = vividc.simulate(program, *arguments, cycle_limit=_CYCLES)
                ran[who] = done.value
            else:
                ran[who] = kernel(*arguments)
        except VividcError as error:
            ran[who] = error
    if not defined:
        return Verdict("agrees", "mutated")
    for who, value in ran.items():
        if isinstance(value, VividcError):
            return Verdict("differs", f"{who}: {str(value)[:300]}")
    if _same([ran["array"], *by_array], [ran["host"], *by_host]):
        return Verdict("agrees", "")
    return Verdict(
        "differs", f"array {ran['array']} {by_array[0]}, host {ran['host']} {by_host[0]}"
    )


def _arguments(kernel: LLKernel, seed: int) -> list[object]:
    random = Random(seed)
    found: list[object] = []
    for param in kernel.params:
        if param.ndim:
            values = [
                random.choice((0, 1, 2, 3, 5, 100, random.randrange(127))) for _ in range(WORDS)
            ]
            found.append(np.array(values, param.dtype.value))
        else:
            found.append(random.choice((0, 1, 3, 4)))
    return found


def _same(left: list[object], right: list[object]) -> bool:
    return all(
        np.allclose(a, b, rtol=1e-5, atol=1e-5, equal_nan=True)  # type: ignore[arg-type]
        for a, b in zip(left, right, strict=True)
        if a is not None
    )


@click.command()
@click.option("--count", default=1000, show_default=True, help="Modules to try.")
@click.option("--seed", default=1, show_default=True, help="Seed of the first module.")
@click.option("--minutes", default=1e6, help="Stop after so many minutes.")
def main(count: int, seed: int, minutes: float) -> None:
    """Run random `.ll` modules; exit code 1 on a find."""
    ll_host.LIMIT_S = _LIMIT_S
    warnings.simplefilter("ignore", VividcWarning)
    counts: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    started = monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(seed, seed + count):
            if monotonic() - started > 60 * minutes:
                break
            verdict = judge(number, Path(folder))
            counts.update([verdict.kind, *(["mutated"] if verdict.text == "mutated" else [])])
            if verdict.kind == "refused":
                reasons[verdict.text[:60]] += 1
            if verdict.is_find:
                print(f"seed {number} {verdict.kind}: {verdict.text}", flush=True)
            if (number - seed + 1) % 500 == 0:
                rate = (number - seed + 1) / (monotonic() - started)
                print(f"{number}: {dict(counts)}, {rate:.1f}/s", flush=True)
    print(dict(counts))
    for reason, times in reasons.most_common(40):
        print(f"{times:6} refused: {reason}")
    sys.exit(1 if counts["differs"] or counts["crashes"] else 0)


if __name__ == "__main__":
    main()

"""Damaged files of every kind that vividc reads: `python -m tests.fuzz.files --count 50000`.

Each is given to what reads it, in a child process. A find is: exit code 1, an exception that is no
message, a signal, text that is not one message, a file half written, memory of more than four times
what the file holds, or a run without an end. Finds make the exit code 1.
"""

from __future__ import annotations

import json
import os
import resource
import select
import shutil
import signal
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import asdict, dataclass
from io import StringIO
from pathlib import Path
from random import Random
from time import monotonic, process_time
from typing import Final

import click

from tests.fuzz.file_damage import damaged, unpacked_size
from tests.fuzz.file_kinds import Kind, kinds
from vividc.cli import main as vividc_main
from vividc.errors import VividcError, VividcWarning
from vividc.sim.native import code as native_code

_BATCH: Final = 100
_SLOW_S: Final = 10.0
_HANGS_S: Final = 60.0
_STANDS_S: Final = 1200.0
"""Of the processor, and of the clock: others may keep it busy."""
_ROOM: Final = 48 << 20
"""Bytes of memory that a run may take beside what its input asks for."""
_ADDRESSES: Final = 6 << 30
_TIMES: Final = 4
_BEFORE: Final = b"what was there before\n"
_MOST_TEXT: Final = 20_000


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a file: an exit code (or "refused", "read"), and what is wrong with that."""

    fate: str
    find: str = ""
    grown: int = 0
    seconds: float = 0.0


def file_of(kind: Kind, seed: int) -> bytes:
    """The damaged file of a seed."""
    return damaged(Random(seed), kind.data, kind.form)


def draw(found: Sequence[Kind], seed: int) -> Kind:
    """The kind of a seed's file."""
    return Random(f"kind {seed}").choices(found, [kind.share for kind in found])[0]


def judge(kind: Kind, data: bytes, home: Path, base: int = 0) -> Outcome:
    """Have a file read in this process; what `home` holds is as before afterwards."""
    path = home / kind.file
    out = home / "out" / "out"
    shutil.rmtree(out.parent, ignore_errors=True)
    out.parent.mkdir()
    before = path.read_bytes() if path.exists() else None
    path.write_bytes(data)
    if before is not None and path.parent.name in ("entries", "compiled"):
        path.chmod(0o600)
    for name in ("out", "out.png"):
        (out.parent / name).write_bytes(_BEFORE)
    native_code.known_code.clear()
    _reset_peak()
    resident, started = _memory("VmRSS"), process_time()
    fate, find = _call(kind, path) if kind.call else _command(kind, path, out, home)
    seconds, grown = process_time() - started, _memory("VmHWM") - resident
    if before is not None:
        path.write_bytes(before)
    bound = _TIMES * unpacked_size(data) + 2 * base + _ROOM
    if not find and grown > bound:
        find = f"takes {grown >> 20} MiB, and may {bound >> 20}"
    if not find and seconds > _SLOW_S:
        find = f"takes {seconds:.0f} s of the processor"
    return Outcome(fate, find, grown, seconds)


def _call(kind: Kind, path: Path) -> tuple[str, str]:
    assert kind.call is not None
    try:
        with _strict_warnings():
            kind.call(path)
    except VividcError as error:
        return "refused", _fault_of_text(f"vividc: {error}")
    except Exception as error:
        return "raises", f"{type(error).__name__}: {str(error)[:300]}"
    return "read", ""


def _command(kind: Kind, path: Path, out: Path, home: Path) -> tuple[str, str]:
    arguments = [part.format(file=path, out=out, home=home) for part in kind.arguments]
    stdout, stderr = StringIO(), StringIO()
    status: object = None
    with redirect_stdout(stdout), redirect_stderr(stderr), _strict_warnings():
        try:
            vividc_main(arguments, prog_name="vividc")
        except SystemExit as done:
            status = done.code or 0
        except BaseException as error:  # whatever leaves the command
            return "raises", f"{type(error).__name__}: {str(error)[:300]}"
    told = stderr.getvalue()
    return f"exit {status}", _fault_of_run(kind, status, stdout.getvalue(), told, out)


def _fault_of_run(kind: Kind, status: object, stdout: str, stderr: str, out: Path) -> str:
    if status not in kind.codes:
        return f"exit code {status}: {stderr[-600:]}"
    if status in (2, 3, 4) and "vividc: " not in stderr:
        return f"exit code {status} without a message: {stderr[-300:]!r}"
    fault = _fault_of_text(stderr) or _fault_of_text(stdout, most=1 << 22)
    if fault:
        return fault
    if status == 0 and "--json" in kind.arguments:
        try:
            json.loads(stdout)
        except ValueError as error:
            return f"what --json prints is no JSON: {error}"
    return _fault_of_output(kind, status, out)


def _fault_of_text(text: str, most: int = _MOST_TEXT) -> str:
    if "Traceback (most recent call last)" in text:
        return f"a traceback: {text[-300:]}"
    odd = next((c for c in text if not c.isprintable() and c not in "\n\t"), None)
    if odd is not None:
        return f"a message with {odd!r}: {text[:200]!r}"
    if len(text) > most:
        return f"a message of {len(text)} characters: {text[:200]!r}"
    return ""


def _fault_of_output(kind: Kind, status: object, out: Path) -> str:
    names = {name for name in os.listdir(out.parent)}
    if names != {"out", "out.png"}:
        return f"files are left: {sorted(names)}"
    written = [name for name in sorted(names) if (out.parent / name).read_bytes() != _BEFORE]
    wanted = [f"out{part[5:]}" for part in kind.arguments if part.startswith("{out}")]
    if status == 0 and kind.arguments and written != wanted:
        return f"written: {written}, not {wanted}"
    if status in (1, 2, 3) and written:
        return f"exit code {status}, and {written} was written"
    return ""


@contextmanager
def _strict_warnings() -> Iterator[None]:
    """Warnings of numpy and the like are errors: a user would see them."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind in (VividcWarning, ResourceWarning):
            warnings.simplefilter("ignore", kind)
        yield


def _reset_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def _memory(name: str) -> int:
    status = Path("/proc/self/status").read_text()
    return int(status.partition(f"{name}:")[2].split()[0]) << 10


class Children:
    """Judges files in child processes, so that a crash is a find and not the end."""

    def __init__(self, found: Sequence[Kind], home: Path) -> None:
        self._home = home
        self._base: dict[str, int] = {}
        for kind in found:
            if not kind.alone:
                judge(kind, kind.data, home)  # what is set up once does not count
            self._base[kind.name] = self._base.get(kind.name, _ROOM)
            outcome = next(self.judge([(kind, kind.data)]))
            assert not outcome.find, f"{kind.name}, undamaged: {outcome}"
            self._base[kind.name] = outcome.grown

    def judge(self, batch: Sequence[tuple[Kind, bytes]]) -> Iterator[Outcome]:
        """What becomes of each file."""
        done = 0
        while done < len(batch):
            for outcome in self._in_one_child(batch[done:]):
                done += 1
                yield outcome

    def _in_one_child(self, batch: Sequence[tuple[Kind, bytes]]) -> Iterator[Outcome]:
        """Up to the first file with which the child ends."""
        reading, writing = os.pipe()
        child = os.fork()
        if not child:
            os.close(reading)
            self._work(batch, writing)
        os.close(writing)
        try:
            yield from _outcomes(child, reading, len(batch))
        finally:
            os.close(reading)

    def _work(self, batch: Sequence[tuple[Kind, bytes]], writing: int) -> None:
        code = 1
        try:
            resource.setrlimit(resource.RLIMIT_AS, (_ADDRESSES, _ADDRESSES))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            for number in (0, 1, 2):
                os.dup2(os.open(os.devnull, os.O_RDWR), number)
            for kind, data in batch:
                outcome = judge(kind, data, self._home, self._base.get(kind.name, 0))
                os.write(writing, json.dumps(asdict(outcome)).encode("ascii") + b"\n")
            code = 0
        finally:
            os._exit(code)


def _outcomes(child: int, reading: int, count: int) -> Iterator[Outcome]:
    pending = b""
    for _ in range(count):
        while b"\n" not in pending:
            piece = _awaited(child, reading)
            pending += piece or b""
            if not piece:
                status = os.waitpid(child, 0)[1]
                why = f"ends with status {status}" if piece == b"" else "hangs"
                yield Outcome("crashes", f"the process {why}")
                return
        line, _, pending = pending.partition(b"\n")
        yield Outcome(**json.loads(line))
    os.waitpid(child, 0)


def _awaited(child: int, reading: int) -> bytes | None:
    """What a child tells next, b"" at its end; None: it was ended, as it took too much time of the
    processor, or none for long.
    """
    began, used = monotonic(), _processor_s(child)
    while not select.select([reading], [], [], 1.0)[0]:
        if _processor_s(child) - used > _HANGS_S or monotonic() - began > _STANDS_S:
            os.kill(child, signal.SIGKILL)
            return None
    return os.read(reading, 1 << 16)


def _processor_s(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def shrunk(kind: Kind, data: bytes, children: Children, seconds: float = 30.0) -> bytes:
    """A shorter file that fails in the same way, for texts."""
    wanted = _manner(next(children.judge([(kind, data)])))
    ends = monotonic() + seconds
    size = len(data) // 2
    while size and monotonic() < ends and kind.form not in ("npz", "bundle"):
        at = 0
        while at < len(data) and monotonic() < ends:
            shorter = data[:at] + data[at + size :]
            if _manner(next(children.judge([(kind, shorter)]))) == wanted:
                data = shorter
            else:
                at += size
        size //= 2
    return data


def _manner(outcome: Outcome) -> str:
    return f"{outcome.fate} {outcome.find[-40:]}"


def _batches(found: Sequence[Kind], seeds: range) -> Iterator[list[tuple[int, Kind]]]:
    batch: list[tuple[int, Kind]] = []
    for seed in seeds:
        kind = draw(found, seed)
        if kind.alone:
            yield [(seed, kind)]
            continue
        batch.append((seed, kind))
        if len(batch) == _BATCH:
            yield batch
            batch = []
    yield batch


@click.command()
@click.option("--count", default=1000, show_default=True, help="Files to try.")
@click.option("--seed", default=1, show_default=True, help="Seed of the first file.")
@click.option("--only", default="", help="Kinds whose name begins so.")
@click.option("--minutes", default=1e6, help="Stop after so many minutes.")
@click.option("--keep", type=click.Path(path_type=Path), help="Folder for the files of finds.")
@click.option("--shrink/--no-shrink", default=True)
def main(count: int, seed: int, only: str, minutes: float, keep: Path | None, shrink: bool) -> None:
    """Try damaged files of all kinds; exit code 1 on a find."""
    tally: dict[str, Counter[str]] = {}
    with tempfile.TemporaryDirectory() as folder, suppress(KeyboardInterrupt):
        found = [kind for kind in kinds(Path(folder)) if kind.name.startswith(only)]
        children = Children(found, Path(folder))
        started, done, finds = monotonic(), 0, 0
        print(f"{len(found)} kinds", flush=True)
        for batch in _batches(found, range(seed, seed + count)):
            if monotonic() - started > 60 * minutes:
                break
            finds += _tried(batch, children, tally, keep, shrink=shrink)
            before, done = done, done + len(batch)
            if done // 1000 > before // 1000:
                rate = done / (monotonic() - started)
                print(f"{done} files, {finds} finds, {rate:.0f}/s", flush=True)
    _show(tally)
    sys.exit(1 if any(counts["find"] for counts in tally.values()) else 0)


def _tried(
    batch: Sequence[tuple[int, Kind]],
    children: Children,
    tally: dict[str, Counter[str]],
    keep: Path | None,
    *,
    shrink: bool,
) -> int:
    """Judge a batch; how many finds there were, which are shown and kept."""
    finds = 0
    files = [(kind, file_of(kind, number)) for number, kind in batch]
    for (number, kind), (_, data), outcome in zip(batch, files, children.judge(files), strict=True):
        counts = tally.setdefault(kind.name, Counter())
        counts.update([outcome.fate, *(["find"] if outcome.find else [])])
        counts["ms"] += int(1000 * outcome.seconds)
        counts["MiB"] = max(counts["MiB"], outcome.grown >> 20)
        if outcome.find:
            finds += 1
            print(f"seed {number}, {kind.name}: {outcome.find}", flush=True)
            _keep(keep, number, kind, shrunk(kind, data, children) if shrink else data)
    return finds


def _keep(folder: Path | None, number: int, kind: Kind, data: bytes) -> None:
    print(f"    {data[:300]!r}", flush=True)
    if folder is not None:
        folder.mkdir(exist_ok=True)
        (folder / f"{number}-{Path(kind.file).name}").write_bytes(data)


def _show(tally: dict[str, Counter[str]]) -> None:
    for name, counts in sorted(tally.items()):
        fates = {key: counts[key] for key in sorted(counts) if key not in ("ms", "MiB")}
        number = sum(value for key, value in fates.items() if key != "find")
        cost = f"{counts['ms'] / number:.0f} ms, at most {counts['MiB']} MiB"
        print(f"{number:6} {name}: {fates}, {cost}")


if __name__ == "__main__":
    main()

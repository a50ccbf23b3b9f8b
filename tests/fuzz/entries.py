"""Damaged entries of a store: `python -m tests.fuzz.entries --count 10000`.

An entry is damaged in some way, and must be read as what was written or not at all, then be thrown
away and written again. A find is printed with its seed and makes the exit code 1.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Final

from vividc.errors import VividcWarning
from vividc.host.store import Store

_KEYS: Final = ("one", "two", "three")


def check_damaged(kept: Store, chance: random.Random) -> None:
    """Write entries, damage one, read all.

    Raises
    ------
    AssertionError
        Something was read that was not written under its name, or an undamaged one was not.
    """
    contents = {key: chance.randbytes(chance.choice((0, 1, 7, 60, 3000))) for key in _KEYS}
    for key, content in contents.items():
        assert kept.write("a", key, content)
    files = sorted(kept.folder.iterdir())
    assert len(files) == len(_KEYS)
    file = chance.choice(files)
    before = file.read_bytes()
    chance.choice(_DAMAGES)(file, files, chance)
    same = file.is_file() and not file.is_symlink() and file.read_bytes() == before
    same = same and not file.stat().st_mode & 0o022
    found = {key: kept.read("a", key) for key in _KEYS}
    lost = [key for key in _KEYS if found[key] is None]
    assert len(lost) == (0 if same else 1), f"{len(lost)} entries are lost"
    assert all(found[key] == contents[key] for key in _KEYS if key not in lost)
    for key in lost:
        assert kept.write("a", key, contents[key])
        assert kept.read("a", key) == contents[key]


Damage = Callable[[Path, list[Path], random.Random], None]


def _flip(file: Path, _: list[Path], chance: random.Random) -> None:
    data = bytearray(file.read_bytes())
    for _turn in range(chance.choice((1, 1, 2, 30))):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    file.write_bytes(data)


def _cut(file: Path, _: list[Path], chance: random.Random) -> None:
    os.truncate(file, chance.randrange(file.stat().st_size))


def _lengthen(file: Path, _: list[Path], chance: random.Random) -> None:
    with file.open("ab") as opened:
        opened.write(chance.choice((b"\0", b"\n", file.read_bytes(), bytes(5000))))


def _move_a_piece(file: Path, _: list[Path], chance: random.Random) -> None:
    data = file.read_bytes()
    first, second = sorted(chance.sample(range(len(data)), 2))
    file.write_bytes(data[:first] + data[second:] + data[first:second])


def _take_another(file: Path, files: list[Path], chance: random.Random) -> None:
    file.write_bytes(chance.choice([other for other in files if other != file]).read_bytes())


def _splice_another(file: Path, files: list[Path], chance: random.Random) -> None:
    data = file.read_bytes()
    at = chance.randrange(len(data))
    file.write_bytes(data[:at] + chance.choice(files).read_bytes()[at:])


def _zeros(file: Path, _: list[Path], chance: random.Random) -> None:
    data = file.read_bytes()
    at = chance.randrange(len(data))
    file.write_bytes(data[:at] + bytes(len(data) - at))


def _open_to_others(file: Path, _: list[Path], chance: random.Random) -> None:
    file.chmod(chance.choice((0o620, 0o602, 0o666, 0o644)))


def _replace(file: Path, files: list[Path], chance: random.Random) -> None:
    file.unlink()
    kind = chance.randrange(4)
    if kind == 0:
        os.mkfifo(file)
    elif kind == 1:
        file.mkdir()
    elif kind == 2:
        file.symlink_to(chance.choice(files))
    else:
        file.symlink_to("/dev/zero")


_DAMAGES: Final[tuple[Damage, ...]] = (
    _flip,
    _flip,
    _flip,
    _cut,
    _lengthen,
    _move_a_piece,
    _take_another,
    _splice_another,
    _zeros,
    _open_to_others,
    _replace,
)


def main() -> int:
    """Damage entries until one is misread; the exit code says whether one was."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=10_000)
    options = parser.parse_args()
    warnings.simplefilter("ignore", VividcWarning)
    with tempfile.TemporaryDirectory() as folder:
        kept = Store(Path(folder) / "entries", 1 << 20)
        for seed in range(options.seed, options.seed + options.count):
            try:
                check_damaged(kept, random.Random(seed))
            except AssertionError as find:
                print(f"seed {seed}: {find}")
                return 1
    print(f"{options.count} damaged entries, none misread")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Machine code that comes with an installation: `objects/` of the package, two equal files for each
unit.

A file is known by all that it was made from and the platform, so that one that is out of date is
never found: one by what the functions follow from, bytecode of one Python, which is known at once,
the other by the text of their module. `make setup` and `make wheel` write them.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from typing import Final

from vividc.host.machine_code.assembler import platform

FOLDER: Final = Path(__file__).parents[2] / "objects"
_DIGEST: Final = sha256().digest_size
"""Bytes of a hash, which come before the code."""


def read(made_from: str) -> bytes | None:
    """The object file of a module, if there is one for this platform, and it is whole."""
    try:
        content = _file(FOLDER, made_from).read_bytes()
    except OSError:
        return None
    code = content[_DIGEST:]
    return code if sha256(code).digest() == content[:_DIGEST] else None


def write(folder: Path, modules: dict[str, bytes]) -> None:
    """Have a folder hold the object files of modules, by what they are made from, and nothing else.

    Raises
    ------
    OSError
        It cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    for made_from, code in modules.items():
        _file(folder, made_from).write_bytes(sha256(code).digest() + code)


def _file(folder: Path, made_from: str) -> Path:
    about = f"{platform()}\n{made_from}"
    return folder / f"{sha256(about.encode()).hexdigest()}"

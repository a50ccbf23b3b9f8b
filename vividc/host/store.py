"""Entries in a folder of the user's own, which are either what was written under their name or are
not there: the files behind `vividc.host.cache` and `vividc.host.compiled_files`.

What others could have put there is never read: folder and entry must be ours and writable by nobody
else, and are opened as what they are and not through links. What was damaged or stands under
another name is recognised by a hash over name and content, thrown away, and said once a process.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from time import monotonic, sleep, time
from typing import Final

from vividc.errors import warn

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_MAGIC: Final = b"vividc entry 1\n"
_HASH_BYTES: Final = 32
_HEAD_BYTES: Final = len(_MAGIC) + _HASH_BYTES
_LARGEST: Final = 256 << 20
"""Bytes of an entry; a larger file is none of ours."""
_OTHERS_WRITE: Final = stat.S_IWGRP | stat.S_IWOTH
_ENTRY: Final = re.compile(r"[a-z]+-[0-9a-f]{64}")
_UNFINISHED: Final = re.compile(r"\.[0-9]+-[0-9a-f]{16}")
"""Names of entries, and of those that are being written; what has others is none of ours."""
_ABANDONED_S: Final = 3600.0
_LONGEST_TURN_S: Final = 300.0
_TURN_STEP_S: Final = 0.05
_BY_DESCRIPTOR: Final = {os.open, os.unlink, os.rename} <= os.supports_dir_fd
_FLAGS: Final = {
    name: getattr(os, name, 0) for name in ("O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC")
}
_OPEN: Final = _FLAGS["O_NOFOLLOW"] | _FLAGS["O_NONBLOCK"] | _FLAGS["O_CLOEXEC"]
warned: list[str] = []
"""The warning that was given; a process gives one."""


@dataclass(slots=True)
class Store:
    """A folder of entries, of which those used longest ago go when it holds more than `limit`.

    Any number of processes may use it at once, and any of them may be killed at any time. Nothing
    here raises: what cannot be read is not there, and what cannot be written is not kept.

    Attributes
    ----------
    folder
        Made when something is written first, with mode 0700.
    limit
        Bytes that the entries may take.
    """

    folder: Path
    limit: int
    _unchecked: int | None = field(default=None, init=False)
    """Bytes written since the sizes were added up; None: they never were."""

    def read(self, kind: str, key: str) -> bytes | None:
        """What was kept under this name, if it is there and can be trusted."""
        name = _name(kind, key)
        with suppress(OSError), self._opened() as place:
            try:
                payload, fault = place.read(name)
            except FileNotFoundError:
                return None
            except OSError as error:  # a link in its place just now, a file without permission
                payload, fault = None, error.strerror or "cannot be opened"
            if payload is None:
                self._throw_away(place, name, fault)
            return payload
        return None

    def write(self, kind: str, key: str, payload: bytes) -> bool:
        """Keep something under a name; whether that was possible."""
        name = _name(kind, key)
        if len(payload) > min(_LARGEST // 2, self.limit):
            return False
        with suppress(OSError):
            self._make()
            with self._opened() as place:
                place.replace(name, _entry(name, payload))
                self._trim(place, len(payload))
                return True
        return False

    def discard(self, kind: str, key: str, reason: str) -> None:
        """Throw away an entry whose content turned out to be of no use; said once a process."""
        with suppress(OSError), self._opened() as place:
            self._throw_away(place, _name(kind, key), reason)

    @contextmanager
    def alone(self, kind: str) -> Iterator[None]:
        """At most one process at a time is inside, for each kind: what takes long is made once.

        Only for speed: without a folder or locks, or after a long wait, nobody waits.
        """
        with suppress(OSError):
            self._make()
        with ExitStack() as until_done:
            with suppress(OSError):
                place = until_done.enter_context(self._opened())
                until_done.enter_context(place.turn(f".turn-{kind}"))
            yield

    def _make(self) -> None:
        self.folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with suppress(FileExistsError):
            os.mkdir(self.folder, 0o700)

    @contextmanager
    def _opened(self) -> Iterator[_Place]:
        """The folder, if it is ours alone.

        Raises
        ------
        OSError
            It is not there, or not to be trusted.
        """
        if not _BY_DESCRIPTOR:
            yield self._by_path()
            return
        flags = os.O_RDONLY | _FLAGS["O_DIRECTORY"] | _FLAGS["O_NOFOLLOW"] | _FLAGS["O_CLOEXEC"]
        try:
            descriptor = os.open(self.folder, flags)
        except OSError:
            if os.path.lexists(self.folder):
                _warn(f"{self.folder} is not used: it is no folder that can be opened")
            raise
        try:
            fault = _fault_of_folder(os.fstat(descriptor))
            if fault is not None:
                _warn(f"{self.folder} is not used: it {fault}")
                raise PermissionError(fault)
            yield _Place(self.folder, descriptor)
        finally:
            os.close(descriptor)

    def _by_path(self) -> _Place:
        """Without operations relative to a folder's descriptor, as on Windows."""
        if _fault_of_folder(os.lstat(self.folder)) is not None:
            raise PermissionError
        return _Place(self.folder, None)

    def _throw_away(self, place: _Place, name: str, reason: str) -> None:
        _warn(f"{self.folder / name} {reason}; it is thrown away and made again")
        place.remove(name)

    def _trim(self, place: _Place, added: int) -> None:
        """Add up the sizes at the first entry, and then not before there may be much more."""
        if self._unchecked is not None and self._unchecked + added < self.limit // 32:
            self._unchecked += added
            return
        self._unchecked = 0
        entries = []
        for name in os.listdir(self.folder if place.descriptor is None else place.descriptor):
            with suppress(OSError):
                status = os.stat(place.path(name), dir_fd=place.descriptor, follow_symlinks=False)
                if _ENTRY.fullmatch(name):
                    entries.append((_last_use(status), status.st_size, name))
                elif _UNFINISHED.fullmatch(name) and time() - status.st_mtime > _ABANDONED_S:
                    place.remove(name)
        size = sum(size for _, size, _ in entries)
        if size <= self.limit:
            return
        for _, freed, name in sorted(entries):
            place.remove(name)
            size -= freed
            if size <= self.limit * 3 // 4:
                return


@dataclass(frozen=True, slots=True)
class _Place:
    """A checked folder, by its descriptor: whatever is moved to its path meanwhile is not it."""

    folder: Path
    descriptor: int | None

    def path(self, name: str) -> str:
        return str(self.folder / name) if self.descriptor is None else name

    def remove(self, name: str) -> None:
        with suppress(OSError):
            try:
                os.unlink(self.path(name), dir_fd=self.descriptor)
            except (IsADirectoryError, PermissionError):
                os.rmdir(self.path(name), dir_fd=self.descriptor)

    def read(self, name: str) -> tuple[bytes | None, str]:
        """What an entry holds, or None and why it is none, as what follows its name.

        What is no file of ours is not opened: opening alone wakes who waits at a FIFO.

        Raises
        ------
        OSError
            It is not there, or cannot be opened.
        """
        path = self.path(name)
        fault = _fault_of(os.stat(path, dir_fd=self.descriptor, follow_symlinks=False))
        if fault is not None:
            return None, fault
        entry = os.open(path, os.O_RDONLY | _OPEN, dir_fd=self.descriptor)
        with os.fdopen(entry, "rb") as file:
            fault = _fault_of(os.fstat(entry))  # of what was opened, whatever was there before
            payload = None if fault is not None else _payload(name, file.read(_LARGEST))
            if payload is not None:
                with suppress(OSError):
                    os.utime(entry if os.utime in os.supports_fd else path)
            return payload, fault or "is damaged"

    @contextmanager
    def turn(self, name: str) -> Iterator[None]:
        """Who has locked the file of this name is inside, and removes it at the end.

        Raises
        ------
        OSError
            It cannot be opened.
        """
        flags = os.O_RDWR | os.O_CREAT | _OPEN
        turn = os.open(self.path(name), flags, 0o600, dir_fd=self.descriptor)
        try:
            _wait_for(turn)
            yield
        finally:
            self.remove(name)
            os.close(turn)  # which unlocks it

    def replace(self, name: str, content: bytes) -> None:
        """Give a name new content in one step: a reader sees all of it or what was there before.

        Raises
        ------
        OSError
            It cannot be written; what was there stays.
        """
        unfinished = f".{os.getpid()}-{os.urandom(8).hex()}"
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        entry = os.open(self.path(unfinished), flags | _OPEN, 0o600, dir_fd=self.descriptor)
        try:
            with os.fdopen(entry, "wb", buffering=0) as file:
                left = memoryview(content)
                while left:
                    left = left[os.write(file.fileno(), left) :]
                os.fsync(file.fileno())
            at = {"src_dir_fd": self.descriptor, "dst_dir_fd": self.descriptor}
            os.replace(self.path(unfinished), self.path(name), **at)
        except BaseException:
            self.remove(unfinished)
            raise


def _wait_for(turn: int) -> None:
    """Lock a file as soon as no other process has it locked; in steps, so that Ctrl-C is seen."""
    if fcntl is None:
        return
    until = monotonic() + _LONGEST_TURN_S
    while monotonic() < until:
        try:
            fcntl.flock(turn, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            sleep(_TURN_STEP_S)
        except OSError:  # a file system without locks
            return


def _last_use(status: os.stat_result) -> float:
    """When a file was read or written last; never, if that is to come: the clock was wrong then,
    and such entries would outlive all others.
    """
    return status.st_mtime if status.st_mtime < time() + _ABANDONED_S else 0.0


def _name(kind: str, key: str) -> str:
    """A file's name: keys may hold anything."""
    return f"{kind}-{sha256(key.encode('utf-8', 'surrogatepass')).hexdigest()}"


def _entry(name: str, payload: bytes) -> bytes:
    """What a file of this name holds."""
    return _MAGIC + _digest(name, payload) + name.encode() + b"\n" + payload


def _digest(name: str, payload: bytes) -> bytes:
    made = sha256(_MAGIC + name.encode() + b"\n")
    made.update(payload)
    return made.digest()


def _payload(name: str, content: bytes) -> bytes | None:
    """What an entry of this name holds; None: it is not what was written under this name."""
    head = _HEAD_BYTES + len(name) + 1
    if not content.startswith(_MAGIC) or content[_HEAD_BYTES:head] != name.encode() + b"\n":
        return None
    payload = content[head:]
    return payload if _digest(name, payload) == content[len(_MAGIC) : _HEAD_BYTES] else None


def _fault_of(status: os.stat_result) -> str | None:
    """Why a file is no entry of ours, as what follows its name; None: it may be."""
    if not stat.S_ISREG(status.st_mode):
        return "is no regular file"
    if status.st_size >= _LARGEST:
        return "is too large for an entry"
    return _shared(status)


def _fault_of_folder(status: os.stat_result) -> str | None:
    return _shared(status) if stat.S_ISDIR(status.st_mode) else "is no folder"


def _shared(status: os.stat_result) -> str | None:
    if not hasattr(os, "geteuid"):  # no owners to compare on this system
        return None
    if status.st_uid != os.geteuid():
        return "belongs to another user"
    return "can be written by others" if status.st_mode & _OTHERS_WRITE else None


def _warn(what: str) -> None:
    if not warned:
        warned.append(what)
        warn(what)

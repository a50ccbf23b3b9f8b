"""What client and server say to each other: a JSON header, then blocks of bytes."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Callable, Sequence
from typing import Any

Header = dict[str, Any]
_CHUNK = 1 << 20


def send(write: Callable[[memoryview], int | None], header: Header, blobs: Sequence[bytes]) -> None:
    """Write a message; `write` may take a part of what it is given."""
    head = json.dumps({**header, "sizes": [len(blob) for blob in blobs]}).encode()
    for block in (struct.pack("<Q", len(head)) + head, *blobs):
        view = memoryview(block)
        while view:
            view = view[write(view) or 0 :]


def receive(read: Callable[[int], bytes | None]) -> tuple[Header, list[bytes]]:
    """Read a message; `read` may give less than it is asked for.

    Raises
    ------
    EOFError
        There is no message any more, or only a part of one.
    """
    (size,) = struct.unpack("<Q", _exactly(read, 8))
    header: Header = json.loads(_exactly(read, size))
    return header, [_exactly(read, size) for size in header.pop("sizes")]


def _exactly(read: Callable[[int], bytes | None], size: int) -> bytes:
    parts = []
    while size:
        part = read(min(size, _CHUNK))
        if not part:
            raise EOFError
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


def writer(descriptor: int) -> Callable[[memoryview], int]:
    """`write` for `send` to a file descriptor."""
    return lambda view: os.write(descriptor, view[:_CHUNK])


def reader(descriptor: int) -> Callable[[int], bytes]:
    """`read` for `receive` from a file descriptor."""
    return lambda size: os.read(descriptor, size)

"""Where the arrays of launches lie in a scratchpad."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Final

from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.launch import Launch, Sizes, bytes_of
from vividc.render.errors import SceneError

_COPIES: Final = ((2, 2), (1, 2), (1, 1))
"""Of held arrays that change and of own ones, the best first: one is used while the next is moved
in.
"""


class Places:
    """Where a tile's arrays lie: those that are held first, each once, then those of them that
    change a second time; then the others of a launch, once or twice, work arrays, once, and those
    that the kernel makes.

    Parameters
    ----------
    name
        Of the kernel.
    wishes
        Banks in which the compiler wants arrays to begin, by parameter.
    banks
        That there are.
    share
        All launches of the tile, at least one.
    room
        Bytes of the scratchpad, without those of arrays that the kernel makes.
    first
        Held arrays that lie before all others.

    Attributes
    ----------
    held
        By parameter: the first byte of each copy.
    own
        From which byte on the other arrays of a launch lie, for each copy; `work`: work arrays,
        `end`: those that the kernel makes.

    Raises
    ------
    SceneError
        A launch has no room.
    """

    def __init__(
        self,
        name: str,
        wishes: Mapping[str, int],
        banks: int,
        share: Sequence[Launch],
        room: int,
        first: Collection[str] = (),
    ) -> None:
        self._wishes, self._banks = wishes, banks
        self._line = WORD_BYTES * banks
        held = _held(share, first)
        own = max((launch.sizes for launch in share), key=self._end)
        work = max(self._end(bytes_of(launch.work)) for launch in share)
        for few, many in _COPIES:
            self.held, end = self._copies(held[:few])
            own_bytes = self._end(own)
            self.own = [end + own_bytes * copy for copy in range(many)]
            self.work = end + own_bytes * many
            self.end = self.work + work
            if self.end <= room:
                return
        raise SceneError(
            f"a launch of {name} needs {self.end} bytes of a scratchpad of {room}: "
            + ", ".join(f"{name} {size}" for some in (held[0], own) for name, size in some.items()),
            hint="use a smaller model, or a fabric whose tiles have larger scratchpads",
        )

    def addresses(self, sizes: Mapping[str, int], start: int) -> dict[str, int]:
        """Return the address of each array from `start` on, in the bank the compiler wished for."""
        addresses = {}
        word = start // WORD_BYTES
        for name, size in sizes.items():
            word += (self._wishes.get(name, 0) - word) % self._banks
            addresses[name] = WORD_BYTES * word
            word += size // WORD_BYTES
        return addresses

    def _copies(self, sizes: Sequence[Sizes]) -> tuple[dict[str, list[int]], int]:
        """Return where each copy of held arrays lies, and the end of all."""
        held: dict[str, list[int]] = {name: [] for name in sizes[0]}
        end = 0
        for some in sizes:
            for name, address in self.addresses(some, end).items():
                held[name].append(address)
            end += self._end(some)
        return held, end

    def _end(self, sizes: Mapping[str, int]) -> int:
        """Return the bytes that arrays take, in whole lines of banks: so many bytes further on they
        lie in the same banks.
        """
        if not sizes:
            return 0
        name, address = list(self.addresses(sizes, 0).items())[-1]
        return -(-(address + sizes[name]) // self._line) * self._line


def _held(share: Sequence[Launch], first: Collection[str]) -> tuple[Sizes, Sizes]:
    """Return the bytes of held arrays, and of those that are not the same in all launches."""
    sizes: Sizes = {}
    arrays: dict[str, set[int]] = {}
    for group in {launch.group: launch for launch in share}.values():
        for name, size in group.held_sizes.items():
            sizes[name] = max(size, sizes.get(name, 0))
            arrays.setdefault(name, set()).add(id(group.held[name]))
    ordered = {name: sizes[name] for name in sorted(sizes, key=lambda name: name not in first)}
    return ordered, {name: size for name, size in ordered.items() if len(arrays[name]) > 1}

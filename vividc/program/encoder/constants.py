"""Where constants, inputs and variables lie in the constant stores of the PEs, over all regions."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Node
from vividc.dfg.lives import ALWAYS, Lives
from vividc.dfg.regions import RETURN_HIGH, RETURN_VARIABLE, Kernel, Region, is_variable
from vividc.errors import InternalError
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import ConstantKey, MapProblem, constant_key
from vividc.program.tables import Home, LaunchRow


@dataclass(frozen=True)
class ConstantStores:
    """By PE, the entry of its constant store that holds each constant, input and variable: several
    variables may have the same.
    """

    entries: tuple[ReadOnly[ConstantKey, int], ...]

    def index(self, pe: int, node: Node) -> int:
        """Entry of PE `pe` that holds the word of a source node or the variable of a live-out."""
        key = ("live_in", node.name) if node.op is Opcode.LIVE_OUT else constant_key(node)
        if key is None or key not in self.entries[pe]:
            raise InternalError(f"PE {pe} has no constant-store entry for node {node.id}")
        return self.entries[pe][key]

    def launch(self) -> tuple[LaunchRow, ...]:
        """What the host writes at launch, by PE and entry."""
        return tuple(
            LaunchRow(pe, entry, str(name))
            for pe, keys in enumerate(self.entries)
            for (kind, name), entry in keys.items()
            if kind == "live_in" and not is_variable(str(name))
        )

    def images(self, fabric: Fabric) -> tuple[NDArray[np.uint32], NDArray[np.bool_]]:
        """Initial words (uint32) and which of them are set (bool), both [PEs, largest store]."""
        shape = (len(fabric.pes), max(pe.constants for pe in fabric.pes))
        words = np.zeros(shape, np.uint32)
        valid = np.zeros(shape, np.bool_)
        for pe, keys in enumerate(self.entries):
            for (kind, value), entry in keys.items():
                if kind == "const":
                    words[pe, entry] = value
                    valid[pe, entry] = True
        return words, valid


def allocate(kernel: Kernel, fabric: Fabric, mappings: ReadOnly[int, Mapping]) -> ConstantStores:
    """Give each constant, input and variable an entry on every PE that reads or writes it.

    Entries are numbered in the order of regions and nodes. Where a store has fewer than that, of
    variables that are never needed at the same time (`Lives`) several share one.

    Raises
    ------
    InternalError
        A PE's store is too small, or regions disagree about where a variable lives.
    """
    entries: list[dict[ConstantKey, None]] = [{} for _ in fabric.pes]
    for index, region in enumerate(kernel.regions):
        problem = MapProblem(region.dfg, fabric)
        for node in region.dfg.placed:
            place = mappings[index].places[node.id]
            entries[place.pe].update(dict.fromkeys(problem.constants_of(node)))
    lives = Lives.of(kernel)
    numbered = []
    for pe, keys in zip(fabric.pes, entries, strict=True):
        numbers = numbered_entries(tuple(keys), pe.constants, lives)
        if numbers is None:
            raise InternalError(
                f"PE {pe.id} needs {len(keys)} constant-store entries and has {pe.constants}"
            )
        numbered.append(numbers)
    _check_variables(kernel, mappings)
    return ConstantStores(tuple(numbered))


def numbered_entries(
    keys: Sequence[ConstantKey], room: int, lives: Lives
) -> dict[ConstantKey, int] | None:
    """The entry of each key in a store with so many; None: there are too few."""
    if len(keys) <= room:
        return {key: entry for entry, key in enumerate(keys)}
    needed = {key: lives.of_key(key) for key in keys}
    used: list[int] = []  # by entry, the regions that need it
    numbers: dict[ConstantKey, int] = {}
    for key in sorted(keys, key=lambda key: (needed[key] != ALWAYS, -needed[key].bit_count())):
        entry = next((n for n, bits in enumerate(used) if not bits & needed[key]), len(used))
        if entry == len(used):
            used.append(0)
        used[entry] |= needed[key]
        numbers[key] = entry
    return numbers if len(used) <= room else None


def return_home(
    kernel: Kernel, mappings: ReadOnly[int, Mapping], stores: ConstantStores
) -> Home | None:
    """Entry of the returned scalar at the end (of its low word, if it has two)."""
    if kernel.returns is None:
        return None
    home = _home(RETURN_VARIABLE, kernel, mappings, stores)
    if home is None:
        raise InternalError(f"the regions of {kernel.name} return a value on no common PE")
    return home


def return_high(
    kernel: Kernel, mappings: ReadOnly[int, Mapping], stores: ConstantStores
) -> Home | None:
    """Entry of the returned integer's high word, None if it has one word only."""
    return _home(RETURN_HIGH, kernel, mappings, stores)


def _home(
    name: str, kernel: Kernel, mappings: ReadOnly[int, Mapping], stores: ConstantStores
) -> Home | None:
    """Entry of a variable on the lowest PE that every writer writes."""
    common: set[int] | None = None
    for index, region in enumerate(kernel.regions):
        written = _writes(region, mappings[index]).get(name)
        if written is not None:
            common = set(written) if common is None else common & set(written)
    if not common:
        return None
    pe = min(common)
    return Home(pe, stores.entries[pe]["live_in", name])


def _check_variables(kernel: Kernel, mappings: ReadOnly[int, Mapping]) -> None:
    """Every region that writes a variable writes all PEs on which some region reads it."""
    readers: dict[str, set[int]] = {}
    written: set[str] = set()
    for index, region in enumerate(kernel.regions):
        for name, pes in _reads(region, mappings[index]).items():
            readers.setdefault(name, set()).update(pes)
    for index, region in enumerate(kernel.regions):
        for name, homes in _writes(region, mappings[index]).items():
            written.add(name)
            if len(set(homes)) < len(homes):
                raise InternalError(f"region {region.name} writes {name} twice on one PE")
            missing = readers.get(name, set()) - set(homes)
            if missing:
                raise InternalError(
                    f"region {region.name} does not write {name} on its reader PE {min(missing)}"
                )
    unwritten = sorted(readers.keys() - written)
    if unwritten:
        raise InternalError(f"no region of {kernel.name} writes variable {unwritten[0]}")


def _reads(region: Region, mapping: Mapping) -> dict[str, set[int]]:
    readers: dict[str, set[int]] = {}
    for edge in region.dfg.edges:
        for source in (edge.src, edge.init):
            node = region.dfg.by_id[source] if source is not None else None
            if node is None or not edge.is_data:
                continue
            if node.op is Opcode.LIVE_IN and is_variable(node.name):
                readers.setdefault(node.name, set()).add(mapping.places[edge.dst].pe)
    return readers


def _writes(region: Region, mapping: Mapping) -> dict[str, list[int]]:
    homes: dict[str, list[int]] = {}
    for node in region.dfg.nodes:
        if node.op is Opcode.LIVE_OUT:
            homes.setdefault(node.name, []).append(mapping.places[node.id].pe)
    return homes

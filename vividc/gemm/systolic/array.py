"""A fabric as a systolic array: the PEs that multiply, and the load/store units at two edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from vividc.arch.fabric import Fabric
from vividc.errors import VividcError
from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode

_LOAD_ROWS = 2
"""Rows in the north that do not multiply: row 0 loads, row 1 stores what comes out."""

_PACK_LATENCY = 2
"""With any other, words would meet on the links between drains."""


class SystolicError(VividcError):
    """A matrix product that the fabric cannot run as a systolic array."""


@dataclass(frozen=True)
class SystolicArray:
    """`rows` x `cols` PEs that multiply; rows of A enter in the west, columns of B in the north.

    The fabric has two more rows in the north and one more column in the west, whose PEs load and
    store. Results leave northwards, against B: eastward and southward links are full.
    """

    fabric: Fabric

    @staticmethod
    def of(fabric: Fabric) -> SystolicArray:
        """`fabric` as a systolic array.

        Raises
        ------
        SystolicError
            A PE or a link that the array needs is missing, or its latencies do not suit.
        """
        array = SystolicArray(fabric)
        fault = array._fault()
        if fault is not None:
            raise SystolicError(
                f"fabric {fabric.name} is not a systolic array: {fault}",
                loc=fabric.name,
                hint="choose vivid-16x16 or vivid-8x8, or a fabric that extends one of them",
            )
        return array

    @property
    def rows(self) -> int:
        """Rows of PEs that multiply."""
        return self.fabric.rows - _LOAD_ROWS

    @property
    def cols(self) -> int:
        """Columns of PEs that multiply."""
        return self.fabric.cols - 1

    def latency(self, latency_class: LatencyClass) -> int:
        """Cycles of an operation."""
        return self.fabric.latencies[latency_class]

    def multiplier(self, row: int, col: int) -> int:
        """Id of the PE that holds element (row, col) of a block."""
        return self._pe(row + _LOAD_ROWS, col + 1)

    def west(self, row: int) -> int:
        """Id of the PE that loads row `row` of A."""
        return self._pe(row + _LOAD_ROWS, 0)

    def north(self, col: int) -> int:
        """Id of the PE that loads column `col` of B."""
        return self._pe(0, col + 1)

    def drain(self, col: int) -> int:
        """Id of the PE that stores column `col` of a block."""
        return self._pe(1, col + 1)

    def link(self, src: int, dst: int) -> int:
        """Id of the link from PE `src` to PE `dst`."""
        return self._link_ids[src, dst]

    @cached_property
    def _link_ids(self) -> dict[tuple[int, int], int]:
        return {(link.src, link.dst): link.id for link in self.fabric.links}

    def _pe(self, row: int, col: int) -> int:
        return row * self.fabric.cols + col

    def _fault(self) -> str | None:
        if self.rows < 1 or self.cols < 1:
            return "it needs two rows and one column beside those that multiply"
        if not self.fabric.is_plain:
            return "its words travel otherwise than ViViD's"
        for name in (LatencyClass.COMPARE, LatencyClass.STORE):
            if self.latency(name) != 1:
                return f"the latency of {name.value} is {self.latency(name)}, and must be 1"
        return self._missing_unit() or self._missing_link()

    def _missing_unit(self) -> str | None:
        feeders = [self.west(row) for row in range(self.rows)]
        feeders += [pe(col) for col in range(self.cols) for pe in (self.north, self.drain)]
        for pe in feeders:
            if not self.fabric.pes[pe].has_memory:
                return f"PE {pe} at its edge has no load/store unit"
        for col in range(self.cols):
            if LatencyClass.COMPARE not in self.fabric.pes[self.drain(col)].classes:
                return f"PE {self.drain(col)} at its edge does not compare"
        return self._missing_multiplier()

    @cached_property
    def compares(self) -> bool:
        """Whether all PEs that multiply compare, too."""
        return all(
            LatencyClass.COMPARE in self.fabric.pes[self.multiplier(row, col)].classes
            for row in range(self.rows)
            for col in range(self.cols)
        )

    def missing_product(self, op: Opcode) -> str | None:
        """Why the PEs that multiply cannot do it with `op`; None: they can."""
        info = OPCODES[op]
        for row in range(self.rows):
            for col in range(self.cols):
                pe = self.fabric.pes[self.multiplier(row, col)]
                if not pe.executes(info):
                    return f"PE {pe.id} has no {op.value}"
                if pe.registers < self.latency(info.latency_class):
                    return f"PE {pe.id} has fewer registers than a {op.value} takes cycles"
        return None

    def missing_pack(self, ops: Sequence[Opcode], lanes: int) -> str | None:
        """Why the drains cannot make words of `lanes` results with `ops`; None: they can."""
        if self.cols % lanes:
            return f"{self.cols} columns are not a multiple of {lanes}"
        if self.latency(LatencyClass.CONVERT) != _PACK_LATENCY:
            latency = self.latency(LatencyClass.CONVERT)
            return f"the latency of convert is {latency}, and must be {_PACK_LATENCY}"
        drains = [self.drain(col) for col in range(self.cols)]
        for pe in drains:
            for op in ops:
                if not self.fabric.pes[pe].executes(OPCODES[op]):
                    return f"PE {pe} at its edge has no {op.value}"
        for west, east in pairwise(drains):
            for src, dst in ((west, east), (east, west)):
                if (src, dst) not in self._link_ids:
                    return f"there is no link from PE {src} to PE {dst}"
        return None

    def _missing_multiplier(self) -> str | None:
        for row in range(self.rows):
            for col in range(self.cols):
                pe = self.fabric.pes[self.multiplier(row, col)]
                if LatencyClass.FMA not in pe.classes:
                    return f"PE {pe.id} has no FMA"
                if pe.registers < self.latency(LatencyClass.FMA):
                    return f"PE {pe.id} has fewer registers than an FMA takes cycles"
        return None

    def _missing_link(self) -> str | None:
        cols = range(self.cols)
        needed = [(self.north(col), self.drain(col)) for col in cols]
        for row in range(self.rows):
            for col in cols:
                here = self.multiplier(row, col)
                above = self.multiplier(row - 1, col) if row else self.drain(col)
                left = self.multiplier(row, col - 1) if col else self.west(row)
                needed += [(above, here), (here, above), (left, here)]
        for src, dst in needed:
            if (src, dst) not in self._link_ids:
                return f"there is no link from PE {src} to PE {dst}"
        return None

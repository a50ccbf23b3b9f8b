"""A program as text: per region, context and PE one readable line."""

from __future__ import annotations

from collections.abc import Iterator

from vividc.arch.fabric import Fabric
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.machine.words import WORD_BYTES
from vividc.program.program import Program
from vividc.program.tables import RegionRow
from vividc.program.words.entry import Capture, Entry, Issue, Operand, Sel, Select, Use


def disassemble(program: Program) -> str:
    """Every active entry of a program, with the source lines it came from.

    Operands read ``link<-3`` (the link from PE 3), ``r2`` (register 2), ``out``, ``iv`` or ``c4``
    (constant-store entry 4); ``c4|out`` reads entry 4 in iteration 0. ``->3=res`` drives the link
    to PE 3, ``r2=res`` writes register 2, ``c4=out`` is a live-out. ``@s1`` is the stage; of a
    straight region, the number from the end of the iteration of the loop before it.
    ``load.u1`` and ``load.s2`` extend a byte with zeros and two bytes with their sign; ``store.1``
    writes one byte.
    """
    return "\n".join(_lines(program)) + "\n"


def _lines(program: Program) -> Iterator[str]:
    yield f"program {program.name} on {program.fabric_name}"
    for row in program.launch:
        yield f"launch: PE {row.pe} c{row.entry} = {row.key}"
    for pe, entry in zip(*program.images_set.nonzero(), strict=True):
        yield f"image: PE {pe} c{entry} = 0x{program.images[pe, entry]:08x}"
    if program.return_home is not None:
        yield f"return: PE {program.return_home.pe} c{program.return_home.entry}"
    if program.return_high is not None:
        yield f"return, high word: PE {program.return_high.pe} c{program.return_high.entry}"
    for index, region in enumerate(program.table):
        yield ""
        yield _header(index, program.regions[index].name, region)
        for slot in range(region.ii):
            yield from _context(program, index, region, slot)


def _header(index: int, name: str, row: RegionRow) -> str:
    marks = [name for name, on in (("counted", row.counted), ("exit", row.has_exit)) if on]
    after = "end" if row.next is None else f"region {row.next}"
    if row.branch is not None:
        after += f" or region {row.branch}"
    kind = " ".join((row.kind, *marks))
    size = f"length {row.ii}"
    if row.kind == "loop":
        size = f"II {row.ii}, span {row.span}, {row.stages} stages"
    if row.drain or row.fill:
        after += f" in its last {row.drain or row.fill} cycles"
    return f"region {index} {name}: {kind}, {size}, then {after}"


def _context(program: Program, index: int, row: RegionRow, slot: int) -> Iterator[str]:
    entries = program.entries[row.context + slot]
    active = [(pe, entry) for pe, entry in enumerate(entries) if not entry.is_idle]
    if not active:
        yield f"  {slot:3d}: idle"
    for pe, entry in active:
        text = "  ".join(_entry(entry, program.fabric, pe))
        locs = {
            str(debug.loc): None
            for role in ("issue", "live_out")
            if (debug := program.debug_row(index, slot, pe, role)) and debug.loc is not None
        }
        source = f"  ; {', '.join(locs)}" if locs else ""
        yield f"  {slot:3d}: PE {pe:2d}  {text}{source}"


def _entry(entry: Entry, fabric: Fabric, pe: int) -> Iterator[str]:
    if entry.issue is not None:
        yield _issue(entry.issue, entry, fabric, pe)
    for k, select in enumerate(entry.links):
        if select.kind is not Sel.NONE:
            link = fabric.links_from[pe][k]
            yield f"->{link.dst}={_select(select, entry, fabric, pe)}"
    for write in entry.writes:
        if write.select.kind is not Sel.NONE:
            yield f"r{write.register}={_select(write.select, entry, fabric, pe)}"
    if entry.capture is not None:
        yield _capture(entry.capture, entry, fabric, pe)


def _issue(issue: Issue, entry: Entry, fabric: Fabric, pe: int) -> str:
    info = OPCODES[issue.op]
    operands = [_operand(o, entry, fabric, pe) for o in issue.operands[: info.arity]]
    if issue.op in MEMORY:
        address = f"[c{issue.base} + ({operands[0]} << {issue.shift}) {issue.offset:+d}]"
        operands = [address, *operands[1:]]
    text = f"{issue.op.value}{_width(issue)} {', '.join(operands)}"
    if issue.predicate.select.kind is not Sel.NONE:
        text += f" if {_operand(issue.predicate, entry, fabric, pe)}"
    if issue.use is not Use.NONE:
        text += f" !{issue.use.value}"
    if issue.unless_exit:
        text += " !unless_exit"
    return f"{text} @s{issue.stage}"


def _width(issue: Issue) -> str:
    """`.s1`, `.u2`: bytes and extension of a narrow load; `.1`: bytes of a narrow store."""
    if issue.width == WORD_BYTES:
        return ""
    kind = {Opcode.LOAD: "s" if issue.signed else "u"}.get(issue.op, "")
    return f".{kind}{issue.width}"


def _capture(capture: Capture, entry: Entry, fabric: Fabric, pe: int) -> str:
    mark = " !unless_exit" if capture.unless_exit else ""
    source = _select(capture.select, entry, fabric, pe)
    return f"c{capture.entry}={source}{mark} @s{capture.stage}"


def _operand(operand: Operand, entry: Entry, fabric: Fabric, pe: int) -> str:
    text = _select(operand.select, entry, fabric, pe)
    return text if operand.first is None else f"c{operand.first}|{text}"


def _select(select: Select, entry: Entry, fabric: Fabric, pe: int) -> str:
    if select.kind is Sel.LINK:
        return f"link<-{fabric.links_to[pe][select.index].src}"
    if select.kind is Sel.WIRE:
        return f"wire<-{fabric.links_to[pe][select.index].src}"
    if select.kind is Sel.RF:
        return f"r{entry.reads[select.index]}"
    if select.kind is Sel.CONST:
        return f"c{select.index}"
    return str(select)

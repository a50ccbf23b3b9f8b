"""Build a `Fabric` from a merged YAML tree, after the checks that no schema can express."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from types import MappingProxyType

import yaml

from vividc.arch.fabric import PE, Controller, Fabric, Link, Routing, Scratchpad
from vividc.arch.topology import topology_links
from vividc.arch.yaml.problems import Problem, raise_all, validated
from vividc.arch.yaml.schema import TIMED_CLASSES, LinkSpec, Override, PESpec, Spec, indices
from vividc.arch.yaml.tree import Path, Tree
from vividc.machine.opcodes import LatencyClass

_MEMORY = frozenset({LatencyClass.LOAD, LatencyClass.STORE})
_COMPUTE = frozenset(TIMED_CLASSES) - _MEMORY


def build(tree: Tree) -> Fabric:
    """The fabric that a merged tree describes; `Fabric.source` is its canonical text.

    Raises
    ------
    ArchError
        Everything that is missing or contradicts itself, each with its line.
    """
    spec = validated(tree, Spec)
    problems = [
        *_override_problems(spec, tree),
        *_link_problems(spec, tree),
        *_scratchpad_problems(spec, tree),
    ]
    raise_all(problems)
    pes = _pes(spec)
    raise_all([*_pe_problems(pes, spec, tree), *_coverage_problems(pes, spec, tree)])
    return Fabric(
        name=spec.name,
        rows=spec.rows,
        cols=spec.cols,
        pes=pes,
        links=tuple(Link(index, src, dst) for index, (src, dst) in enumerate(_links(spec))),
        latencies=MappingProxyType(_latencies(spec)),
        scratchpad=Scratchpad(spec.scratchpad.size_bytes, spec.scratchpad.banks),
        controller=Controller(
            contexts=spec.controller.contexts,
            control_latency=spec.controller.control_latency,
            switch_cycles=spec.controller.switch_cycles,
            max_stages=spec.controller.max_stages,
        ),
        clock_ghz=spec.clock_ghz,
        source=_canonical_text(spec),
        routing=_routing(spec),
        occupancies=MappingProxyType(_occupancies(spec)),
    )


def _canonical_text(spec: Spec) -> str:
    data = spec.model_dump(mode="json", by_alias=True, exclude_none=True)
    text: str = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100)
    return text


def _latencies(spec: Spec) -> dict[LatencyClass, int]:
    given: dict[str, int] = spec.latencies.model_dump(by_alias=True)
    given["dot"] = given["dot"] or given["fma"]
    cycles = {lat: given[lat.value] for lat in TIMED_CLASSES}
    return {LatencyClass.SOURCE: 0, LatencyClass.SINK: 0, **cycles}


def _routing(spec: Spec) -> Routing:
    given, default = spec.routing, Routing()
    if given is None:
        return default
    return Routing(
        hops=default.hops if given.hops is None else given.hops,
        holds=given.output == "hold",
        shared=given.output_readers == "neighbours",
        moves=bool(given.moves),
    )


def _occupancies(spec: Spec) -> dict[LatencyClass, int]:
    if spec.occupancy is None:
        return {}
    given: dict[str, int] = spec.occupancy.model_dump(by_alias=True, exclude_none=True)
    return {lat: given[lat.value] for lat in TIMED_CLASSES if lat.value in given}


def _links(spec: Spec) -> tuple[tuple[int, int], ...]:
    removed = {_pair(link, spec) for link in spec.links.removed}
    pairs = [*topology_links(spec.topology, spec.rows, spec.cols)]
    pairs += [_pair(link, spec) for link in spec.links.extra]
    return tuple(pair for pair in pairs if pair not in removed)


def _pair(link: LinkSpec, spec: Spec) -> tuple[int, int]:
    return _pe_id(link.src, spec), _pe_id(link.dst, spec)


def _pe_id(position: list[int], spec: Spec) -> int:
    return position[0] * spec.cols + position[1]


def _exists(position: list[int], spec: Spec) -> bool:
    return 0 <= position[0] < spec.rows and 0 <= position[1] < spec.cols


def _pes(spec: Spec) -> tuple[PE, ...]:
    settings: list[PESpec] = [spec.pe] * (spec.rows * spec.cols)
    for override in spec.overrides:
        for row in indices(override.at.rows, spec.rows):
            for col in indices(override.at.cols, spec.cols):
                pe = row * spec.cols + col
                settings[pe] = _overridden(settings[pe], override)
    return tuple(_pe(index, setting, spec) for index, setting in enumerate(settings))


def _overridden(setting: PESpec, override: Override) -> PESpec:
    changes = override.model_dump(exclude_none=True, exclude={"at", "register_file"})
    if override.register_file is not None:
        ports = override.register_file.model_dump(exclude_none=True)
        changes["register_file"] = setting.register_file.model_copy(update=ports)
    return setting.model_copy(update=changes)


def _pe(index: int, setting: PESpec, spec: Spec) -> PE:
    row, col = divmod(index, spec.cols)
    return PE(
        id=index,
        row=row,
        col=col,
        classes=_classes(setting, spec),
        registers=setting.register_file.registers,
        read_ports=setting.register_file.read_ports,
        write_ports=setting.register_file.write_ports,
        constants=setting.constants,
        rotating=bool(setting.register_file.rotating),
        written_by_fu=setting.register_file.written_by == "fu",
        sliced=setting.sliced is not False,
    )


def _classes(setting: PESpec, spec: Spec) -> frozenset[LatencyClass]:
    if setting.executes == "all":
        compute = _COMPUTE
    else:
        compute = _with_dot(LatencyClass(name) for name in setting.executes)
    return (compute | (_MEMORY if setting.memory else frozenset())) - _absent(spec)


def _absent(spec: Spec) -> frozenset[LatencyClass]:
    compute = _with_dot(LatencyClass(name) for name in spec.absent if name != "memory")
    return compute | (_MEMORY if "memory" in spec.absent else frozenset())


def _with_dot(classes: Iterable[LatencyClass]) -> frozenset[LatencyClass]:
    """`dot` comes and goes with `fma`: both are the sliced unit's."""
    chosen = frozenset(classes)
    return chosen | {LatencyClass.DOT} if LatencyClass.FMA in chosen else chosen


def _override_problems(spec: Spec, tree: Tree) -> Iterator[Problem]:
    for index, override in enumerate(spec.overrides):
        sides = (("rows", override.at.rows, spec.rows), ("cols", override.at.cols, spec.cols))
        for side, chosen, count in sides:
            place = tree.place(("overrides", index, "at", side))
            numbers = indices(chosen, count)
            beyond = [item for item in numbers if item >= count]
            if beyond:
                reason = f"`{side}` names {beyond[0]}, but the array has {side} 0 to {count - 1}"
                yield Problem(place, reason, "indices count from 0; `all` names the whole side")
            if not numbers:
                yield Problem(place, f"`{side}` names nothing", "a range runs upwards: 0..3")


def _link_problems(spec: Spec, tree: Tree) -> Iterator[Problem]:
    known = Counter(topology_links(spec.topology, spec.rows, spec.cols))
    for index, link in enumerate(spec.links.extra):
        path: Path = ("links", "extra", index)
        bad = list(_position_problems(link, path, spec, tree))
        yield from bad
        if bad:
            continue
        known[_pair(link, spec)] += 1
        if known[_pair(link, spec)] > 1:
            yield Problem(tree.place(path), f"the link {_arrow(link)} exists already")
    for index, link in enumerate(spec.links.removed):
        path = ("links", "removed", index)
        bad = list(_position_problems(link, path, spec, tree))
        yield from bad
        if not bad and not known.pop(_pair(link, spec), 0):
            reason = f"there is no link {_arrow(link)} to remove"
            yield Problem(tree.place(path), reason, "links are directed: each way is its own")


def _position_problems(link: LinkSpec, path: Path, spec: Spec, tree: Tree) -> Iterator[Problem]:
    for key, position in (("from", link.src), ("to", link.dst)):
        if not _exists(position, spec):
            size = f"{spec.rows}x{spec.cols}"
            reason = f"unknown PE {position} in a link: the array has {size} PEs"
            yield Problem(tree.place((*path, key)), reason, "a PE is [row, col], from [0, 0]")
    if link.src == link.dst:
        yield Problem(tree.place(path), f"the link {_arrow(link)} joins a PE to itself")


def _arrow(link: LinkSpec) -> str:
    return f"{link.src} -> {link.dst}"


def _scratchpad_problems(spec: Spec, tree: Tree) -> Iterator[Problem]:
    banks, size = spec.scratchpad.banks, spec.scratchpad.size_bytes
    if banks & (banks - 1):
        reason = f"{banks} banks: not a power of two"
        yield Problem(tree.place(("scratchpad", "banks")), reason)
    if size % (4 * banks):
        reason = f"{size} bytes are not a multiple of {banks} banks of 32-bit words"
        hint = f"{size // (4 * banks) * 4 * banks or 4 * banks} would be"
        yield Problem(tree.place(("scratchpad", "size_bytes")), reason, hint)


def _pe_problems(pes: tuple[PE, ...], spec: Spec, tree: Tree) -> Iterator[Problem]:
    """Contradictions inside a PE, reported once for all PEs that share them."""
    for pe in _distinct(pes):
        where = f"PE [{pe.row}, {pe.col}]"
        place = _setting_place(pe, "register_file", spec, tree)
        ports = f"{pe.read_ports} read and {pe.write_ports} write ports"
        if (pe.registers > 0) != (pe.read_ports > 0) or (pe.registers > 0) != (pe.write_ports > 0):
            reason = f"{where} has {pe.registers} registers with {ports}"
            yield Problem(
                place, reason, "a register file needs all three, and no registers no ports"
            )
        if not pe.classes:
            yield Problem(_setting_place(pe, "executes", spec, tree), f"{where} executes nothing")


def _distinct(pes: tuple[PE, ...]) -> Iterator[PE]:
    seen = set()
    for pe in pes:
        kind = (pe.registers, pe.read_ports, pe.write_ports, bool(pe.classes))
        if kind not in seen:
            seen.add(kind)
            yield pe


def _setting_place(pe: PE, key: str, spec: Spec, tree: Tree) -> str:
    for index in reversed(range(len(spec.overrides))):
        at = spec.overrides[index].at
        inside = pe.row in indices(at.rows, spec.rows) and pe.col in indices(at.cols, spec.cols)
        if inside and ("overrides", index, key) in tree.places:
            return tree.place(("overrides", index, key))
    return tree.place(("pe", key))


def _coverage_problems(pes: tuple[PE, ...], spec: Spec, tree: Tree) -> Iterator[Problem]:
    covered = frozenset().union(*(pe.classes for pe in pes)) | _absent(spec)
    missing = [lat.value for lat in TIMED_CLASSES if lat in _COMPUTE and lat not in covered]
    if missing:
        names = ", ".join(missing)
        hint = f"if the array is meant not to have it, say so: `absent: [{names}]`"
        yield Problem(tree.place(("pe", "executes")), f"no PE executes {names}", hint)
    if not covered & _MEMORY:
        hint = "give some PEs `memory: true`, or say `absent: [memory]`"
        yield Problem(tree.place(("pe", "memory")), "no PE has a load/store unit", hint)

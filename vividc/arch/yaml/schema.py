"""The keys of a fabric's YAML, as pydantic models; `docs/fabric-yaml.md` documents each of them.

A file may leave out what it inherits through `extends`, so every key of a `Layer` is optional.
`Spec` is the merged whole, in which nothing may be missing.
"""

from __future__ import annotations

import re
from typing import Annotated, Final, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, PlainValidator

from vividc.arch.topology import Topology
from vividc.machine.opcodes import LatencyClass

MAX_SIDE: Final = 32


WrittenBy = Literal["crossbar", "fu"]


Compute = Literal["int", "imul", "compare", "select", "fadd", "fmul", "fma", "convert", "generic"]
"""Names of the latency classes that an FU executes; loads and stores come with `memory`."""

TIMED_CLASSES: Final[tuple[LatencyClass, ...]] = tuple(
    lat for lat in LatencyClass if lat not in (LatencyClass.SOURCE, LatencyClass.SINK)
)
LATENCY_GROUPS: Final[dict[str, tuple[LatencyClass, ...]]] = {
    "all": TIMED_CLASSES,
    "float": (LatencyClass.FADD, LatencyClass.FMUL, LatencyClass.FMA, LatencyClass.DOT),
}

_AXES = 2
_RANGE = re.compile(r"(\d{1,4})\.\.(\d{1,4})")


def _is_index_item(value: object) -> bool:
    if isinstance(value, bool):
        return False
    if isinstance(value, int):
        return value >= 0
    return isinstance(value, str) and _RANGE.fullmatch(value) is not None


def _check_index_set(value: object) -> object:
    items = value if isinstance(value, list) else [value]
    if value == "all" or (items and all(_is_index_item(item) for item in items)):
        return value
    raise ValueError("should be `all`, an index, a range such as 0..3, or a list of these")


def _check_coordinates(value: object) -> object:
    if isinstance(value, list) and len(value) == _AXES and all(type(item) is int for item in value):
        return value
    raise ValueError("should be a PE as [row, col]")


def _check_executes(value: object) -> object:
    known = get_args(Compute)
    if value == "all" or (isinstance(value, list) and value and all(c in known for c in value)):
        return value
    raise ValueError(f"should be `all` or a list of some of {', '.join(known)}")


IndexSet = Annotated[int | str | list[int | str], PlainValidator(_check_index_set)]


def indices(spec: int | str | list[int | str], count: int) -> tuple[int, ...]:
    """The indices that an index set names, ascending, of a side of `count` PEs.

    Indices beyond the side are included: the caller reports them.
    """
    if spec == "all":
        return tuple(range(count))
    found: set[int] = set()
    for item in spec if isinstance(spec, list) else [spec]:
        match = _RANGE.fullmatch(str(item))
        found.update(range(int(match[1]), int(match[2]) + 1) if match else [int(item)])
    return tuple(sorted(found))


class StrictModel(BaseModel):
    """No unknown keys, no conversions."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, populate_by_name=True)


_Absent = Literal[
    "int", "imul", "compare", "select", "fadd", "fmul", "fma", "dot", "convert", "generic", "memory"
]
_Latency = Annotated[int, Field(ge=1, le=64)]
_Registers = Annotated[int, Field(ge=0, le=256)]
_Ports = Annotated[int, Field(ge=0, le=16)]
_Constants = Annotated[int, Field(ge=0, le=1024)]
_Side = Annotated[int, Field(ge=1, le=MAX_SIDE)]
_Coordinates = Annotated[list[int], PlainValidator(_check_coordinates)]
_Executes = Annotated[Literal["all"] | list[Compute], PlainValidator(_check_executes)]


class LinkSpec(StrictModel):
    """A directed link between two PEs, each as [row, col]."""

    src: _Coordinates = Field(alias="from")
    dst: _Coordinates = Field(alias="to")


class LinksSpec(StrictModel):
    """Links beside those of the topology."""

    extra: list[LinkSpec] = []
    removed: list[LinkSpec] = []


class RegisterFileLayer(StrictModel):
    """Register file of a PE, as far as one layer sets it."""

    registers: _Registers | None = None
    read_ports: _Ports | None = None
    write_ports: _Ports | None = None
    rotating: bool | None = None
    written_by: WrittenBy | None = None


class PELayer(StrictModel):
    """What a PE is made of, as far as one layer sets it."""

    memory: bool | None = None
    executes: _Executes | None = None
    sliced: bool | None = None
    register_file: RegisterFileLayer | None = None
    constants: _Constants | None = None


class RoutingLayer(StrictModel):
    """How words travel, as far as one layer sets it."""

    hops: Annotated[int, Field(ge=0, le=16)] | None = None
    output: Literal["pulse", "hold"] | None = None
    output_readers: Literal["own", "neighbours"] | None = None
    moves: bool | None = None


class OccupancyLayer(StrictModel):
    """Cycles for which an operation of a class keeps its FU."""

    int_: _Latency | None = Field(None, alias="int")
    imul: _Latency | None = None
    compare: _Latency | None = None
    select: _Latency | None = None
    fadd: _Latency | None = None
    fmul: _Latency | None = None
    fma: _Latency | None = None
    dot: _Latency | None = None
    convert: _Latency | None = None
    load: _Latency | None = None
    store: _Latency | None = None
    generic: _Latency | None = None


class At(StrictModel):
    """PEs by rows and columns: those in one of the rows and one of the columns."""

    rows: IndexSet = "all"
    cols: IndexSet = "all"


class Override(PELayer):
    """Other settings for some PEs; later overrides win."""

    at: At


class LatenciesLayer(StrictModel):
    """Cycles per latency class; `all` and `float` set several at once, a class by its name wins."""

    all_: _Latency | None = Field(None, alias="all")
    float_: _Latency | None = Field(None, alias="float")
    int_: _Latency | None = Field(None, alias="int")
    imul: _Latency | None = None
    compare: _Latency | None = None
    select: _Latency | None = None
    fadd: _Latency | None = None
    fmul: _Latency | None = None
    fma: _Latency | None = None
    dot: _Latency | None = None
    convert: _Latency | None = None
    load: _Latency | None = None
    store: _Latency | None = None
    generic: _Latency | None = None


class ScratchpadLayer(StrictModel):
    """The tile's memory, as far as one layer sets it."""

    size_bytes: Annotated[int, Field(ge=4, le=2**30)] | None = None
    banks: Annotated[int, Field(ge=1, le=1024)] | None = None


class ControllerLayer(StrictModel):
    """The tile controller, as far as one layer sets it."""

    contexts: Annotated[int, Field(ge=1, le=65536)] | None = None
    control_latency: Annotated[int, Field(ge=0, le=64)] | None = None
    switch_cycles: Annotated[int, Field(ge=0, le=1024)] | None = None
    max_stages: Annotated[int, Field(ge=1, le=1024)] | None = None


class Layer(StrictModel):
    """One YAML text."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")] | None = None
    extends: str | None = None
    rows: _Side | None = None
    cols: _Side | None = None
    topology: Topology | None = None
    links: LinksSpec | None = None
    pe: PELayer | None = None
    overrides: list[Override] | None = None
    absent: list[_Absent] | None = None
    latencies: LatenciesLayer | None = None
    routing: RoutingLayer | None = None
    occupancy: OccupancyLayer | None = None
    scratchpad: ScratchpadLayer | None = None
    controller: ControllerLayer | None = None
    clock_ghz: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] | None = None


class RegisterFileSpec(StrictModel):
    """Size and ports of a register file."""

    registers: _Registers
    read_ports: _Ports
    write_ports: _Ports
    rotating: bool | None = None
    written_by: WrittenBy | None = None


class PESpec(StrictModel):
    """What every PE is made of unless an override says otherwise."""

    memory: bool
    executes: _Executes
    sliced: bool | None = None
    register_file: RegisterFileSpec
    constants: _Constants


class LatenciesSpec(StrictModel):
    """Cycles of every latency class."""

    int_: _Latency = Field(alias="int")
    imul: _Latency
    compare: _Latency
    select: _Latency
    fadd: _Latency
    fmul: _Latency
    fma: _Latency
    dot: _Latency | None = None  # as `fma` if a file does not say
    convert: _Latency
    load: _Latency
    store: _Latency
    generic: _Latency


class ScratchpadSpec(StrictModel):
    """Capacity and banks."""

    size_bytes: int
    banks: int


class ControllerSpec(StrictModel):
    """Parameters of the tile controller."""

    contexts: int
    control_latency: int
    switch_cycles: int
    max_stages: int


class Spec(StrictModel):
    """A whole fabric after `extends` was resolved."""

    name: str
    rows: _Side
    cols: _Side
    topology: Topology
    links: LinksSpec = LinksSpec()
    pe: PESpec
    overrides: list[Override] = []
    absent: list[_Absent] = []
    latencies: LatenciesSpec
    routing: RoutingLayer | None = None
    occupancy: OccupancyLayer | None = None
    scratchpad: ScratchpadSpec
    controller: ControllerSpec
    clock_ghz: float
